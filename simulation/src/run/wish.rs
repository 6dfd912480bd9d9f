//! What a user wants.

use rts_schemas::system::SystemSpec;

/// What is wanted of one system.
#[derive(Debug, Clone)]
pub(super) struct Wish {
    /// As it was last applied, or would be.
    pub spec: SystemSpec,
    /// It is to be there.
    pub wanted: bool,
    /// The last word was acknowledged.
    pub acked: bool,
    /// A module was exchanged since the last apply: it counts, and what restarts needs it, once it is applied again.
    pub stale: bool,
}

impl Wish {
    /// Nothing is left to be said of it.
    pub fn is_said(&self) -> bool {
        self.acked && !(self.wanted && self.stale)
    }
}
