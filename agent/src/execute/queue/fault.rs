//! Batches that make no sense.

use std::collections::BTreeSet;

use rts_plan::plan::{Step, StepId};

/// A batch that makes no sense.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum BatchFault {
    /// A number occurs twice.
    #[error("step {0} occurs twice, or is a gate too")]
    Twice(StepId),
    /// A need that nobody meets.
    #[error("step {step} needs step {need}, which is neither in the batch nor a gate")]
    Unknown {
        /// Which step.
        step: StepId,
        /// What it needs.
        need: StepId,
    },
    /// Steps that wait for each other, perhaps.
    #[error("step {step} needs step {need}, which comes after it")]
    Backwards {
        /// Which step.
        step: StepId,
        /// What it needs.
        need: StepId,
    },
    /// A limit on what is not waited for.
    #[error("step {step} limits its wait for step {limited}, which it does not wait for")]
    NoWait {
        /// Which step.
        step: StepId,
        /// What its limit names.
        limited: StepId,
    },
    /// A limit that is over before it begins.
    #[error("step {0} has a limit of 0 ms; a wait without a limit has none")]
    NoTime(StepId),
}

/// Checks what one step waits for. `ids` are the steps of the batch.
pub(super) fn check(
    step: &Step,
    ids: &BTreeSet<StepId>,
    gates: &BTreeSet<StepId>,
) -> Result<(), BatchFault> {
    let id = step.id;
    for need in step.before() {
        if !ids.contains(&need) && !gates.contains(&need) {
            return Err(BatchFault::Unknown { step: id, need });
        }
        if need >= id {
            return Err(BatchFault::Backwards { step: id, need });
        }
    }
    if step.limits.is_empty() {
        return Ok(());
    }
    let before: BTreeSet<StepId> = step.before().collect();
    for limit in &step.limits {
        if limit.ms == 0 {
            return Err(BatchFault::NoTime(id));
        }
        let mut limited = limit.steps.iter().copied();
        if let Some(limited) = limited.find(|step| !before.contains(step)) {
            return Err(BatchFault::NoWait { step: id, limited });
        }
    }
    Ok(())
}
