//! What of an execution context is settled when a component is made.

use rts_schemas::system::{ComponentSpec, ExecutionKind, Realtime, SharedExecutionContext};

use crate::observed::ComponentObserved;

/// What cannot change in place of the execution context of a component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Context {
    /// Kind.
    pub kind: ExecutionKind,
    /// What is shared of it.
    pub shared: Option<SharedExecutionContext>,
    /// What it has of its node.
    pub realtime: Option<Realtime>,
}

impl Context {
    /// As a system says it. A stand-in runs everywhere, and needs nothing of its node.
    pub fn of(component: &ComponentSpec, stand_in: bool) -> Self {
        let context = &component.execution_context;
        let realtime = component.resources.realtime();
        Self {
            kind: context.kind,
            shared: context.shared(),
            realtime: realtime.filter(|_| !stand_in),
        }
    }

    /// As it was made.
    pub fn found(component: &ComponentObserved) -> Self {
        let realtime = component.realtime.as_ref();
        Self {
            kind: component.execution_kind,
            shared: component.execution_context.clone(),
            realtime: realtime.map(|found| found.asked.clone()),
        }
    }

    /// What is said when it is to be another one.
    pub(crate) fn changed(&self, to: &Self) -> String {
        if self.kind != to.kind {
            return format!(
                "execution kind changed from {:?} to {:?}",
                self.kind, to.kind
            );
        }
        let called = |context: &Self| {
            let shared = context.shared.as_ref();
            shared.map_or("its own".to_owned(), |shared| shared.name.clone())
        };
        if self.shared == to.shared {
            return "the resources of its execution context changed".to_owned();
        }
        let (from, to) = (called(self), called(to));
        format!("execution context changed from {from} to {to}")
    }
}
