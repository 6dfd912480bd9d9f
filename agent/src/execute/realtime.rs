//! What an execution context is to have of its node, in the words of the control protocol.

use rts_manager_api::control::{CreateRequest, RealtimeRequest};
use rts_schemas::system::Realtime;

use super::verb::StepError;
use crate::managers::Manager;

/// Adds it to a request. A manager that does not know it would make the component without and say that all is well.
pub(super) fn put_in(
    manager: &Manager,
    request: &mut CreateRequest,
    asked: Realtime,
) -> Result<(), StepError> {
    if manager.link.version().is_some_and(|version| version < 2) {
        return Err(StepError::Refused(format!(
            "manager {} speaks protocol version 1, which does not know rtsctl.resources: stop it, so that a new process takes \
             its place, then {} can be made",
            manager.key.display_name(),
            request.instance
        )));
    }
    request.realtime = Some(RealtimeRequest {
        cpus: asked.cpus,
        priority: asked.priority,
        lock_memory: asked.lock_memory,
        required: asked.required,
    });
    Ok(())
}
