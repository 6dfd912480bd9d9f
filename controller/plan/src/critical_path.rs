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
        | Work::Unbind { .. }
        | Work::Activate { .. }
        | Work::Deactivate { .. }
        | Work::Delete { .. } => 300,
        Work::Configure { .. } | Work::Reset { .. } | Work::UnloadModule { .. } => 200,
    }
}

/// The same of a step, with its wait on purpose.
pub(crate) fn micros(step: &Step) -> u64 {
    nominal_micros(&step.work) + u64::from(step.wait_ms) * 1_000
}

/// True for what something comes up by, false for what only takes something down.
fn brings_up(work: &Work) -> bool {
    match work {
        Work::Install { .. }
        | Work::StartManager { .. }
        | Work::LoadModule { .. }
        | Work::Create { .. }
        | Work::Configure { .. }
        | Work::Connect { .. }
        | Work::Reset { .. }
        | Work::Activate { .. } => true,
        Work::Deactivate { .. }
        | Work::Disconnect { .. }
        | Work::Unbind { .. }
        | Work::Delete { .. }
        | Work::UnloadModule { .. }
        | Work::StopManager { .. } => false,
    }
}

/// The steps of the chain that ends last, first to last: each waits for the one before it. Waits on purpose count in
/// full. When something is brought up it ends in the step that brings up the last of it: that is how long it takes until
/// everything is Active; what is only tidied up after that delays nobody. Empty for no steps; of two chains of one length
/// the one with the lower numbers.
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
        ends.push(begin.saturating_add(micros(step)));
        before.push(longest);
    }
    let up = |ix: &usize| brings_up(&steps[*ix].work);
    let any = (0..steps.len()).any(|ix| up(&ix));
    let last = (0..ends.len()).filter(|ix| !any || up(ix));
    let last = last.max_by_key(|ix| (ends[*ix], std::cmp::Reverse(*ix)));
    let mut path: Vec<StepId> = std::iter::successors(last, |ix| before[*ix])
        .map(|ix| steps[ix].id)
        .collect();
    path.reverse();
    path
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::json;

    use super::{critical_path, nominal_micros};
    use crate::plan::{Step, StepId};

    fn step(id: StepId, kind: &str, needs: &[StepId], wait_ms: u32) -> Step {
        let manager = json!({"name": "main"});
        let connector = json!({"name": "A.out-B.in", "kind": "data", "source": {"instance": "A", "port": "out"},
            "target": {"instance": "B", "port": "in"}});
        let end = json!({"node": "local", "manager": "main"});
        let placed = json!({"spec": connector, "source": end, "target": end});
        serde_json::from_value(json!({
            "id": id, "node": "local", "target": format!("component/C{id}"), "needs": needs, "waitMs": wait_ms,
            "reason": "", "kind": kind, "manager": manager, "instance": "A", "typeName": "T",
            "moduleDigest": null, "connector": placed, "incarnation": "",
        }))
        .unwrap()
    }

    fn micros(steps: &[Step], path: &[StepId]) -> u64 {
        let step = |id: &StepId| &steps[*id as usize - 1];
        let all = path.iter().map(step);
        all.map(|s| nominal_micros(&s.work) + u64::from(s.wait_ms) * 1_000)
            .sum()
    }

    #[test]
    fn no_steps_no_path() {
        assert!(critical_path(&[]).is_empty());
    }

    #[test]
    fn the_heavier_branch_counts() {
        let steps = [
            step(1, "Install", &[], 0),
            step(2, "StartManager", &[], 0),
            step(3, "LoadModule", &[1, 2], 0),
            step(4, "Activate", &[], 0),
        ];
        assert_eq!(critical_path(&steps), [2, 3]);
    }

    #[test]
    fn a_wait_on_purpose_counts_in_full() {
        let steps = [
            step(1, "StartManager", &[], 0),
            step(2, "Activate", &[], 7),
            step(3, "Activate", &[1, 2], 0),
        ];
        assert_eq!(critical_path(&steps), [2, 3]);
    }

    #[test]
    fn every_kind_of_edge_counts_and_of_equals_the_lower_number() {
        let mut last = step(4, "Activate", &[], 0);
        last.after_start_of = vec![2];
        last.after_end_of = vec![3];
        let first = step(1, "Activate", &[], 0);
        let two = [
            first,
            step(2, "Activate", &[], 0),
            step(3, "Activate", &[], 0),
            last,
        ];
        assert_eq!(critical_path(&two), [2, 4]);
    }

    #[test]
    fn it_ends_in_what_is_brought_up_last() {
        let mut steps = vec![
            step(1, "Deactivate", &[], 0),
            step(2, "Activate", &[1], 0),
            step(3, "StopManager", &[1], 0),
        ];
        assert_eq!(critical_path(&steps), [1, 2]);
        steps[1] = step(2, "Deactivate", &[1], 0);
        assert_eq!(critical_path(&steps), [1, 3]);
    }

    /// The weight of the heaviest chain that ends in a step, by trying all.
    fn heaviest(steps: &[Step], end: usize) -> u64 {
        let own = micros(steps, &[steps[end].id]);
        let before = steps[end]
            .before()
            .map(|id| heaviest(steps, id as usize - 1));
        own + before.max().unwrap_or_default()
    }

    fn steps() -> impl Strategy<Value = Vec<Step>> {
        let kinds = prop::sample::select(vec![
            "StartManager",
            "LoadModule",
            "Connect",
            "Activate",
            "Deactivate",
            "StopManager",
        ]);
        let one = (
            kinds,
            prop::collection::vec(any::<prop::sample::Index>(), 0..4),
            0..3u32,
        );
        prop::collection::vec(one, 0..10).prop_map(|choices| {
            let numbered = choices.into_iter().zip(1..);
            let steps = numbered.map(|((kind, edges, wait), id)| {
                let mut step = step(id, kind, &[], wait * 3);
                for (nth, edge) in edges.iter().enumerate().filter(|_| id > 1) {
                    let before = edge.index(id as usize - 1) as StepId + 1;
                    match nth {
                        0 => step.after_start_of.push(before),
                        1 => step.after_end_of.push(before),
                        _ => step.needs.push(before),
                    }
                }
                step
            });
            steps.collect()
        })
    }

    proptest! {
        /// It is a chain of edges, and no chain is heavier that ends where it may.
        #[test]
        fn critical_path_is_the_heaviest_chain(steps in steps()) {
            let path = critical_path(&steps);
            for pair in path.windows(2) {
                let later = &steps[pair[1] as usize - 1];
                prop_assert!(later.before().any(|id| id == pair[0]), "{:?}", path);
            }
            let down = |end: &usize| ["Deactivate", "StopManager"].contains(&steps[*end].work.kind());
            let only_down = (0..steps.len()).all(|end| down(&end));
            let ends = (0..steps.len()).filter(|end| only_down || !down(end));
            let heaviest = ends.map(|end| heaviest(&steps, end)).max();
            prop_assert_eq!(micros(&steps, &path), heaviest.unwrap_or_default());
        }
    }
}
