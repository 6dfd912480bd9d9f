//! A stand-in, in the words of the control protocol.

use rts_manager_api::control::{CreateRequest, PortInfo, StandInShape};
use rts_schemas::stand_in::Shape;
use rts_schemas::system::{Direction, ExecutionKind, PortKind, PortSpec};

use super::component::kind_name;
use super::verb::StepError;
use crate::managers::Manager;

/// Makes a request one for a stand-in. It runs periodically, whatever would drive the component itself.
pub(super) fn put_in(
    manager: &Manager,
    request: &mut CreateRequest,
    shape: Shape,
) -> Result<(), StepError> {
    if manager.link.version().is_some_and(|version| version < 2) {
        return Err(StepError::Refused(format!(
            "manager {} speaks protocol version 1, which does not know stand-ins: stop it, so that a new process takes its \
             place, then {} can be made",
            manager.key.display_name(),
            request.instance
        )));
    }
    // A profile may make a set active that only the component itself has.
    if let Some(active) = &request.active {
        request.sets.entry(active.clone()).or_default();
    }
    request.execution_kind = kind_name(ExecutionKind::Periodic).to_owned();
    request.rate = request.rate.or(shape.rate);
    request.stand_in = Some(StandInShape {
        ports: shape.ports.into_iter().map(port).collect(),
        parameters: shape.parameters,
        startup_ms: shape.startup_time_ms,
        fail: shape.fail.map(|fail| fail.as_str().to_owned()),
        crash_after_ms: shape.crash_after_ms,
        data: shape.data,
    });
    Ok(())
}

fn port(port: PortSpec) -> PortInfo {
    let direction = match (port.kind, port.direction) {
        (PortKind::Service, _) => "service",
        (PortKind::Data, Some(Direction::In)) => "in",
        (PortKind::Data, Some(Direction::Out)) => "out",
        (PortKind::Data, None) => "undetermined",
    };
    PortInfo {
        name: port.name,
        direction: direction.to_owned(),
        data_type: port.data_type.unwrap_or_default(),
    }
}
