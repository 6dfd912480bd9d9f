//! Stand-ins for components whose module is not to be had.

use rts_controller_api::requests::Expect;
use rts_schemas::system::{StandIn, SystemSpec};

/// Which components may be stand-ins.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct StandInArgs {
    /// Let a stand-in take the place of each component whose module is not to be had, unless its profile or an overlay
    /// says otherwise (`standIn`)
    #[arg(long)]
    pub stand_ins: bool,
    /// Refuse (exit 3) if more than N components would be stand-ins
    #[arg(long, value_name = "N")]
    max_stand_ins: Option<u32>,
}

impl StandInArgs {
    /// `--stand-ins` or not, and as many as there may be.
    pub fn new(stand_ins: bool, max_stand_ins: Option<u32>) -> Self {
        Self {
            stand_ins,
            max_stand_ins,
        }
    }

    /// Says what components do not say themselves.
    pub(super) fn lay(&self, spec: &mut SystemSpec) {
        if self.stand_ins {
            for component in &mut spec.components {
                component.stand_in.when.get_or_insert(StandIn::Missing);
            }
        }
    }

    pub(super) fn expect(&self) -> Expect {
        Expect {
            max_stand_ins: self.max_stand_ins,
            ..Expect::default()
        }
    }
}
