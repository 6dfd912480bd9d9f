//! A step on a component that hangs: where its policy has the process replaced, it fails as soon as that is known, so
//! that the next plan does so. Otherwise nothing would be done about it, and a callback that takes its time, such as an
//! orderly deactivation, must not be cut off: the step keeps its own limit.

use std::time::Duration;

use rts_plan::desired::ManagerKey;
use rts_plan::plan::Work;
use tokio::time::sleep;

use super::verb::{StepError, Verb};
use crate::events::lock;
use crate::inventory::{system_ref, why_hanging};
use crate::policies::replaces;

/// Between two looks at a component that a step waits for.
const LOOK: Duration = Duration::from_millis(500);

/// Carries out a step, but waits for nothing that hangs and is to be replaced for it.
pub(super) async fn carry_out(verb: &Verb, work: Work) -> Result<(), StepError> {
    let policies = verb.agent.policies();
    let policy = |instance: &str| policies.of_present(verb.system.as_ref()?, instance);
    let replaced = subject(&work).filter(|(_, instance)| replaces(policy(instance)));
    let Some((key, instance)) = replaced else {
        return verb.carry_out(work).await;
    };
    let hangs = known_to_hang(verb, key.clone(), instance.to_owned());
    tokio::select! {
        biased;
        outcome = verb.carry_out(work) => outcome,
        why = hangs => Err(StepError::Hangs(why)),
    }
}

/// The component whose callbacks a step waits for.
fn subject(work: &Work) -> Option<(&ManagerKey, &str)> {
    match work {
        Work::Create {
            manager, instance, ..
        }
        | Work::Configure {
            manager, instance, ..
        }
        | Work::Activate { manager, instance }
        | Work::Deactivate { manager, instance }
        | Work::Reset { manager, instance }
        | Work::Delete { manager, instance } => Some((manager, instance)),
        Work::Install { .. }
        | Work::LoadModule { .. }
        | Work::UnloadModule { .. }
        | Work::StartManager { .. }
        | Work::StopManager { .. }
        | Work::Connect { .. }
        | Work::Disconnect { .. }
        | Work::Unbind { .. } => None,
    }
}

/// Waits until a component hangs for which its process is to be replaced; gives what hangs, and since when. Whoever waits at the same time shares the looks.
async fn known_to_hang(verb: &Verb, key: ManagerKey, instance: String) -> String {
    loop {
        sleep(LOOK).await;
        verb.agent.observe().await;
        if let Some(why) = hangs_now(verb, &key, &instance) {
            return why;
        }
    }
}

fn hangs_now(verb: &Verb, key: &ManagerKey, instance: &str) -> Option<String> {
    let manager = verb.manager_if_any(key)?;
    let (policies, seen) = (verb.agent.policies(), lock(&manager.seen));
    if !seen.responsive {
        // What was seen before says nothing of now.
        return None;
    }
    let mut components = seen.inventory.components.iter();
    let component = components
        .find(|c| c.instance == instance && c.system.as_ref().map(system_ref) == verb.system)?;
    why_hanging(&policies, component)
}
