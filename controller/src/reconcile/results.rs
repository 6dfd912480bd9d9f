//! What the results of steps mean: events, metrics, back-off.

use rts_agent_api::messages::StepOutcome;
use rts_plan::plan::{Step, Work};
use rts_plan::target;

use super::deaths;
use crate::core::Core;
use crate::view::Happening;

/// What a step was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MadeFor {
    /// What is desired now.
    Now,
    /// An older generation of its system: its failure holds nothing up.
    OlderGeneration,
}

/// Takes in the end of a step.
pub fn take(core: &Core, step: &Step, outcome: &StepOutcome, made_for: MadeFor) {
    let key = target::on(&step.node, &step.target);
    let kind = step.work.kind();
    match outcome {
        StepOutcome::Succeeded => {
            core.metrics.step(kind, "succeeded");
            core.backoff().succeeded(&key);
            deaths::succeeded(core, step);
            if let Some(event) = success(step) {
                core.record(event);
            }
        }
        StepOutcome::Failed { reason } => {
            core.metrics.step(kind, "failed");
            let system = step.system.as_ref().map(|s| s.name.as_str());
            let now = core.clock.now();
            let rng = core.rng.as_ref();
            let again = if made_for == MadeFor::Now {
                let delay = core.backoff().failed(&key, system, reason, rng, now);
                format!("tried again in {:.1} s", delay.as_secs_f64())
            } else {
                "it was for an older generation".to_owned()
            };
            tracing::warn!(
                step = kind,
                target = step.target,
                node = step.node,
                reason,
                "step failed"
            );
            let message = format!("{reason}; {again}");
            let event = Happening::warning(&format!("{kind}Failed"), &step.target, message);
            core.record(event.of(system));
        }
        StepOutcome::Skipped { .. } => core.metrics.step(kind, "skipped"),
    }
}

/// The event of a notable step that succeeded.
fn success(step: &Step) -> Option<Happening> {
    let node = &step.node;
    let (reason, message) = match &step.work {
        Work::LoadModule { type_name, .. } => {
            ("ModuleLoaded", format!("module of {type_name} loaded"))
        }
        Work::Create {
            type_name, manager, ..
        } => (
            "Created",
            format!(
                "{type_name} created in {} on node {node}",
                manager.display_name()
            ),
        ),
        Work::Configure { .. } => ("Configured", step.reason.clone()),
        Work::Connect { connector } => {
            let spec = &connector.spec;
            (
                "Connected",
                format!("{} connected to {}", spec.source, spec.target),
            )
        }
        Work::Activate { .. } => ("Activated", "is Active".to_owned()),
        Work::Deactivate { .. } => ("Deactivated", step.reason.clone()),
        Work::Reset { .. } => ("Reset", "taken out of Error".to_owned()),
        Work::Disconnect { .. } => ("Disconnected", step.reason.clone()),
        Work::Unbind { .. } => ("Unbound", step.reason.clone()),
        Work::Delete { .. } => ("Deleted", step.reason.clone()),
        Work::StopManager { .. } => ("ManagerStopped", step.reason.clone()),
        // The agent tells of its processes itself, with their pid.
        Work::StartManager { .. } | Work::Install { .. } | Work::UnloadModule { .. } => {
            return None;
        }
    };
    let system = step.system.as_ref().map(|s| s.name.as_str());
    Some(Happening::normal(reason, &step.target, message).of(system))
}
