//! What holds for every batch.

use proptest::prelude::*;
use rts_plan::plan::OnTimeout;

use super::limits::limited;
use super::*;

prop_compose! {
    /// A step that waits for some of those before it, in some ways, and for some of them not for ever.
    fn any_step(id: StepId)(
        ways in proptest::collection::vec(0..8_u8, id as usize - 1),
        ms in 1..200_u32,
        goes_on in any::<bool>(),
        wait_ms in prop_oneof![Just(0), 1..50_u32],
    ) -> Step {
        let mut made = Step { wait_ms, ..step(id, &[]) };
        let mut within = Vec::new();
        for (before, way) in (1..id).zip(ways) {
            match way {
                0 => made.needs.push(before),
                1 => made.after_start_of.push(before),
                2 => made.after_end_of.push(before),
                3 => { made.needs.push(before); within.push(before) }
                4 => { made.after_end_of.push(before); within.push(before) }
                _ => {}
            }
        }
        if !within.is_empty() {
            let then = if goes_on { OnTimeout::GoOn } else { OnTimeout::Fail };
            made = limited(made, &within, ms, then);
        }
        made
    }
}

fn any_batch() -> impl Strategy<Value = (Vec<Step>, Vec<(StepId, u64, bool)>)> {
    let steps: Vec<_> = (1..=12).map(any_step).collect();
    let script = (1..=12_u32).map(|id| (Just(id), 1..300_u64, proptest::bool::weighted(0.8)));
    (steps, script.collect::<Vec<_>>())
}

/// When a step started and how it ended, and when; all from a transcript.
#[derive(Debug, Default, Clone)]
struct Told {
    started: Option<u64>,
    ended: Option<(u64, bool)>,
}

fn told(text: &str) -> BTreeMap<StepId, Told> {
    let mut all: BTreeMap<StepId, Told> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.ends_with(" end")) {
        let mut words = line.split(' ');
        let at = words.next().unwrap().parse().unwrap();
        let told = all
            .entry(words.next().unwrap().parse().unwrap())
            .or_default();
        match words.next().unwrap() {
            "started" => told.started = Some(at),
            how => {
                assert_eq!(told.ended.replace((at, how == "succeeded")), None, "{text}");
            }
        }
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Every step ends once; none starts before what stands before it, unless it went on after its time; and none waits
    /// longer than its limit.
    #[test]
    fn every_wait_is_kept_and_ends((steps, script) in any_batch()) {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .start_paused(true)
            .build()
            .unwrap();
        let hands = Pretend::new(&script);
        let text = runtime.block_on(transcript(batch(steps.clone()), &hands, vec![]));
        let told = told(&text);
        for step in &steps {
            let own = &told[&step.id];
            prop_assert!(own.ended.is_some(), "{text}");
            let Some(started) = own.started else { continue };
            let limit = step.limits.first();
            let is_limited = |id: &StepId| limit.is_some_and(|l| l.steps.contains(id));
            let met = |id: StepId, way: &str| match (way, &told[&id]) {
                ("start", Told { started: Some(at), .. }) => Some(*at),
                ("success", Told { ended: Some((at, true)), .. }) => Some(*at),
                ("start" | "end", Told { ended: Some((at, _)), .. }) => Some(*at),
                _ => None,
            };
            let mut waits: Vec<(StepId, Option<u64>)> = Vec::new();
            for (ids, way) in [
                (&step.needs, "success"),
                (&step.after_start_of, "start"),
                (&step.after_end_of, "end"),
            ] {
                waits.extend(ids.iter().map(|id| (*id, met(*id, way))));
            }
            let (within, free): (Vec<_>, Vec<_>) = waits.into_iter().partition(|(id, _)| is_limited(id));
            let begin = started - u64::from(step.wait_ms);
            let mut armed = 0;
            for (id, at) in free {
                prop_assert!(at.is_some_and(|at| at <= begin), "{} before {id}: {text}", step.id);
                armed = armed.max(at.unwrap());
            }
            let Some(limit) = limit else { continue };
            let end = armed + u64::from(limit.ms);
            prop_assert!(begin <= end, "{} waited too long: {text}", step.id);
            for (id, at) in within {
                let lost = told[&id].ended.is_some_and(|(at, ok)| !ok && at <= begin);
                let without = limit.then == OnTimeout::GoOn && (lost || begin == end);
                prop_assert!(without || at.is_some_and(|at| at <= begin), "{} before {id}: {text}", step.id);
            }
        }
    }
}
