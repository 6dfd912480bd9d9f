//! Event-driven components that nothing wakes.

use super::sink::Sink;
use crate::connector::{self, Dataflow};
use crate::rts_profile::ReadProfile;
use crate::system::{ExecutionKind, PortKind, SystemSpec};

/// Warns of event-driven components whose samples all wait to be fetched: an arrival is what wakes them, and nothing
/// arrives at an in-port that pulls.
pub(super) fn woken(sink: &mut Sink<'_>, read: &ReadProfile, spec: &SystemSpec) {
    let pulls = |properties| {
        connector::read(properties).is_ok_and(|settings| settings.dataflow == Dataflow::Pull)
    };
    let is_driven = |kind| kind == ExecutionKind::EventDriven;
    let driven = spec.components.iter();
    for component in driven.filter(|c| is_driven(c.execution_context.kind)) {
        let to_it = |c: &&crate::system::ConnectorSpec| {
            c.kind == PortKind::Data && c.target.instance == component.instance
        };
        let mut to_it = spec.connectors.iter().filter(to_it).peekable();
        if to_it.peek().is_none() || !to_it.all(|c| pulls(&c.properties)) {
            continue;
        }
        let said = read.component(&component.instance);
        let kind = said.and_then(|c| c.execution_contexts.iter().find_map(|e| e.kind.as_ref()));
        let span = kind.map(|kind| kind.span).or(said.map(|said| said.span));
        let message = format!(
            "`{}` is event-driven, and all connectors to it pull: no sample wakes it",
            component.instance
        );
        let help = "let one of them push, or make its execution context periodic";
        sink.warning("never-woken", message, span.unwrap_or_default(), help);
    }
}
