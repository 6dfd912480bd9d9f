//! What an agent takes from outside.

use std::sync::Arc;

use rts_agent_api::session::SessionApi;
use rts_host::clock::{Chance, Clock};
use rts_host::disk::Disk;

use crate::machine::Machine;
use crate::peers::Peers;

/// What an agent takes from outside. Monotonic time is tokio's, which can be paused.
#[derive(Clone)]
pub struct Inputs {
    /// Wall time.
    pub clock: Arc<dyn Clock>,
    /// Chance.
    pub chance: Arc<dyn Chance>,
    /// Holds the ledger, and what is remembered of restarts.
    pub disk: Arc<dyn Disk>,
    /// Processes, run folders and modules of the node.
    pub machine: Arc<dyn Machine>,
    /// The controller; none to run without one.
    pub controller: Option<Arc<dyn SessionApi>>,
    /// The agents of other nodes.
    pub peers: Arc<dyn Peers>,
}
