//! The chain of steps that a plan cannot be faster than.

use crate::plan::{Step, StepId, Work};

/// What a step of this kind takes on an idle machine, in microseconds: measured medians, which only weigh steps against
/// each other. What a component does in its callbacks comes on top, and nobody knows it beforehand.
pub fn nominal_micros(work: &Work) -> u64 {
    match work {
        Work::StartManager { .. } | Work::StopManager { .. } => 6_000,
        Work::Install { .. } | Work::LoadModule { .. } => 1_000,
        Work::Create { .. } => 600,
        Work::Connect { .. }
        | Work::Disconnect { .. }
        | Work::Activate { .. }
        | Work::Deactivate { .. }
        | Work::Delete { .. } => 300,
        Work::Configure { .. } | Work::Reset { .. } | Work::UnloadModule { .. } => 200,
    }
}

/// The steps of the longest chain, first to last: each waits for the one before it. Waits on purpose count in full.
/// Empty for no steps; of two chains of one length the one with the lower numbers.
pub fn critical_path(steps: &[Step]) -> Vec<StepId> {
    // Ids count from 1 in an order in which every edge leads forward.
    let mut ends: Vec<u64> = Vec::with_capacity(steps.len());
    let mut before: Vec<Option<usize>> = Vec::with_capacity(steps.len());
    for step in steps {
        let mut longest: Option<usize> = None;
        for ix in step.before().filter_map(|id| (id as usize).checked_sub(1)) {
            let Some(end) = ends.get(ix) else { continue };
            let longer = longest.is_none_or(|other| {
                (*end, std::cmp::Reverse(ix)) > (ends[other], std::cmp::Reverse(other))
            });
            if longer {
                longest = Some(ix);
            }
        }
        let begin = longest.map_or(0, |ix| ends[ix]);
        let own = nominal_micros(&step.work) + u64::from(step.wait_ms) * 1_000;
        ends.push(begin.saturating_add(own));
        before.push(longest);
    }
    let last = (0..ends.len()).max_by_key(|ix| (ends[*ix], std::cmp::Reverse(*ix)));
    let mut path: Vec<StepId> = std::iter::successors(last, |ix| before[*ix])
        .map(|ix| steps[ix].id)
        .collect();
    path.reverse();
    path
}
