//! The scheduler with hands that only pretend, on a paused clock: transcripts in text.

mod laws;
mod limits;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rts_plan::desired::ManagerKey;
use rts_plan::plan::{OnTimeout, Work};

use super::*;
use limits::limited;

/// How a pretended step goes: milliseconds, and whether it succeeds. Steps that are not named take 10 ms.
struct Pretend {
    script: BTreeMap<StepId, (u64, bool)>,
    limit: Duration,
    now: AtomicUsize,
    most: AtomicUsize,
}

impl Pretend {
    fn new(script: &[(StepId, u64, bool)]) -> Arc<Self> {
        Arc::new(Self {
            script: script
                .iter()
                .map(|(id, ms, ok)| (*id, (*ms, *ok)))
                .collect(),
            limit: Duration::from_secs(10),
            now: AtomicUsize::new(0),
            most: AtomicUsize::new(0),
        })
    }
}

/// The hands of one test.
struct Shared(Arc<Pretend>);

impl CarryOut for Shared {
    fn limit(&self, _: &Step) -> Duration {
        self.0.limit
    }

    fn carry_out(&self, step: Step, _: Duration) -> Carrying {
        let pretend = self.0.clone();
        Box::pin(async move {
            let now = pretend.now.fetch_add(1, Ordering::SeqCst) + 1;
            pretend.most.fetch_max(now, Ordering::SeqCst);
            let (ms, ok) = pretend.script.get(&step.id).copied().unwrap_or((10, true));
            tokio::time::sleep(Duration::from_millis(ms)).await;
            pretend.now.fetch_sub(1, Ordering::SeqCst);
            if step.id == 666 {
                panic!("a verb with a fault");
            }
            if ok {
                Ok(())
            } else {
                Err(StepError::Refused("it would not".to_owned()))
            }
        })
    }
}

fn step(id: StepId, needs: &[StepId]) -> Step {
    Step {
        needs: needs.to_vec(),
        ..Step::new(
            id,
            "local",
            format!("component/C{id}"),
            Work::Activate {
                manager: ManagerKey {
                    system: None,
                    name: "main".to_owned(),
                },
                instance: format!("C{id}"),
            },
        )
    }
}

fn batch(steps: Vec<Step>) -> Batch {
    Batch {
        plan_id: "p".to_owned(),
        cluster_uid: "cluster".to_owned(),
        epoch: 1,
        generation: 1,
        steps,
        gates: Vec::new(),
        deadline_ms: 60_000,
        parallelism: 10,
        seen: None,
    }
}

/// Runs a batch; says the words at their milliseconds. Gives what happened and when.
async fn transcript(batch: Batch, hands: &Arc<Pretend>, said: Vec<(u64, Word)>) -> String {
    let queue = Queue::new(&batch.steps, &batch.gates).unwrap();
    let (words, heard) = mpsc::channel(16);
    let begin = Instant::now();
    let speaker = tokio::spawn(async move {
        for (at, word) in said {
            sleep_until(begin + Duration::from_millis(at)).await;
            words.send(word).await.unwrap();
        }
        // The door stays open, as in the agent.
        std::future::pending::<()>().await;
    });
    let text = Mutex::new(String::new());
    let tell = |event: BatchEvent| {
        let at = begin.elapsed().as_millis();
        let line = match event {
            BatchEvent::Started { step } => format!("{step} started"),
            BatchEvent::Finished { step, outcome, .. } => match outcome {
                StepOutcome::Succeeded => format!("{step} succeeded"),
                StepOutcome::Failed { reason } => format!("{step} failed: {reason}"),
                StepOutcome::Skipped { because_of, reason } => {
                    format!("{step} skipped {because_of:?}: {reason}")
                }
            },
            BatchEvent::End => "end".to_owned(),
            BatchEvent::Accepted { .. } => "accepted".to_owned(),
        };
        writeln!(text.lock().unwrap(), "{at} {line}").unwrap();
    };
    run(batch, queue, Arc::new(Shared(hands.clone())), heard, tell).await;
    speaker.abort();
    text.into_inner().unwrap()
}

#[tokio::test(start_paused = true)]
async fn steps_start_when_what_they_need_is_done() {
    let hands = Pretend::new(&[(2, 30, true)]);
    let steps = vec![step(1, &[]), step(2, &[]), step(3, &[1]), step(4, &[2, 3])];
    insta::assert_snapshot!(transcript(batch(steps), &hands, vec![]).await, @r"
    0 1 started
    0 2 started
    10 1 succeeded
    10 3 started
    20 3 succeeded
    30 2 succeeded
    30 4 started
    40 4 succeeded
    40 end
    ");
}

#[tokio::test(start_paused = true)]
async fn a_failure_skips_its_dependents_and_the_rest_goes_on() {
    let hands = Pretend::new(&[(1, 10, false), (666, 10, true)]);
    let steps = vec![
        step(1, &[]),
        step(2, &[1]),
        step(3, &[2]),
        step(4, &[]),
        step(5, &[4]),
        step(666, &[5]),
    ];
    insta::assert_snapshot!(transcript(batch(steps), &hands, vec![]).await, @r#"
    0 1 started
    0 4 started
    10 1 failed: Activate component/C1: it would not
    10 2 skipped Some(1): step 1 failed
    10 3 skipped Some(1): step 1 failed
    10 4 succeeded
    10 5 started
    20 5 succeeded
    20 666 started
    30 666 failed: the agent failed: task 5 panicked with message "a verb with a fault"
    30 end
    "#);
}

#[tokio::test(start_paused = true)]
async fn asynchronous_needs_wait_for_a_start_and_wait_times_are_slept() {
    let hands = Pretend::new(&[(1, 100, false)]);
    let mut after = step(2, &[]);
    after.after_start_of = vec![1];
    let mut later = step(3, &[2]);
    later.wait_ms = 50;
    let steps = vec![step(1, &[]), after, later];
    insta::assert_snapshot!(transcript(batch(steps), &hands, vec![]).await, @r#"
    0 1 started
    0 2 started
    10 2 succeeded
    60 3 started
    70 3 succeeded
    100 1 failed: Activate component/C1: it would not
    100 end
    "#);
}

#[tokio::test(start_paused = true)]
async fn gates_hold_steps_until_other_nodes_report() {
    let hands = Pretend::new(&[]);
    let mut after = step(14, &[]);
    after.after_start_of = vec![3];
    let mut gated = batch(vec![
        step(10, &[1]),
        step(11, &[2]),
        step(12, &[11]),
        step(13, &[]),
        after,
    ]);
    gated.gates = vec![1, 2, 3];
    let report = |started: &[StepId], succeeded: &[StepId], failed: &[StepId]| {
        Word::Gates(GateReport {
            started: started.to_vec(),
            succeeded: succeeded.to_vec(),
            failed: failed.to_vec(),
        })
    };
    let said = vec![
        (50, report(&[3], &[1], &[])),
        // Nonsense about a step that is here, and a repetition.
        (60, report(&[], &[1, 12], &[13])),
        (70, report(&[], &[], &[2])),
    ];
    insta::assert_snapshot!(transcript(gated, &hands, said).await, @r#"
    0 13 started
    10 13 succeeded
    50 10 started
    50 14 started
    60 10 succeeded
    60 14 succeeded
    70 11 skipped Some(2): step 2 failed
    70 12 skipped Some(2): step 2 failed
    70 end
    "#);
}

#[tokio::test(start_paused = true)]
async fn the_deadline_fails_what_runs_and_skips_the_rest() {
    let hands = Pretend::new(&[(2, 5_000, true)]);
    let mut late = batch(vec![
        step(1, &[]),
        step(2, &[]),
        step(3, &[2]),
        step(4, &[]),
    ]);
    late.steps[3].wait_ms = 9_000;
    late.deadline_ms = 200;
    insta::assert_snapshot!(transcript(late, &hands, vec![]).await, @r#"
    0 1 started
    0 2 started
    10 1 succeeded
    200 3 skipped None: the batch ran out of time
    200 4 skipped None: the batch ran out of time
    200 2 failed: Activate component/C2 did not end within 200 ms
    200 end
    "#);
}

#[tokio::test(start_paused = true)]
async fn a_step_that_ends_at_the_deadline_does_not_keep_its_batch_for_ever() {
    let hands = Pretend::new(&[(1, 200, true)]);
    let mut late = batch(vec![
        step(1, &[]),
        step(2, &[]),
        step(3, &[1]),
        step(4, &[]),
    ]);
    late.steps[3].wait_ms = 9_000;
    late.deadline_ms = 200;
    late.gates = vec![100];
    let mut gated = step(101, &[100]);
    gated.wait_ms = 1;
    late.steps.push(gated);
    // In a task of its own, as in the agent: there the end of the step is seen before the alarm.
    let text = tokio::spawn(async move { transcript(late, &hands, vec![]).await });
    let text = tokio::time::timeout(Duration::from_secs(60), text).await;
    let text = text.expect("the batch ends").unwrap();
    assert!(text.ends_with("200 end\n"), "{text}");
    for id in [3, 4, 101] {
        let skipped = format!("200 {id} skipped None: the batch ran out of time\n");
        assert!(text.contains(&skipped), "{text}");
    }
}

#[tokio::test(start_paused = true)]
async fn who_waits_only_for_a_start_goes_on_when_that_step_is_lost() {
    let hands = Pretend::new(&[(1, 10, false)]);
    let mut steps = vec![
        step(1, &[]),
        step(3, &[1]),
        step(4, &[2]),
        step(5, &[]),
        step(6, &[4]),
    ];
    // Behind a skipped step, and behind one that other nodes lost.
    steps[3].after_start_of = vec![2, 3];
    steps[4].after_start_of = vec![3];
    let mut gated = batch(steps);
    gated.gates = vec![2];
    let lost = Word::Gates(GateReport {
        started: Vec::new(),
        succeeded: Vec::new(),
        failed: vec![2],
    });
    insta::assert_snapshot!(transcript(gated, &hands, vec![(50, lost)]).await, @r#"
    0 1 started
    10 1 failed: Activate component/C1: it would not
    10 3 skipped Some(1): step 1 failed
    50 4 skipped Some(2): step 2 failed
    50 6 skipped Some(2): step 2 failed
    50 5 started
    60 5 succeeded
    60 end
    "#);
}

#[tokio::test(start_paused = true)]
async fn a_step_has_a_limit_of_its_own() {
    let mut hands = Pretend::new(&[(1, 50_000, true)]);
    Arc::get_mut(&mut hands).unwrap().limit = Duration::from_secs(2);
    let steps = vec![step(1, &[]), step(2, &[1])];
    insta::assert_snapshot!(transcript(batch(steps), &hands, vec![]).await, @r#"
    0 1 started
    3000 1 failed: Activate component/C1 did not end within 3000 ms
    3000 2 skipped Some(1): step 1 failed
    3000 end
    "#);
}

#[tokio::test(start_paused = true)]
async fn a_cancelled_batch_lets_running_steps_end() {
    let hands = Pretend::new(&[(1, 100, true)]);
    let mut steps = vec![step(1, &[]), step(2, &[1]), step(3, &[])];
    steps[2].wait_ms = 80;
    let said = vec![(50, Word::Cancel("replaced".to_owned()))];
    insta::assert_snapshot!(transcript(batch(steps), &hands, said).await, @r#"
    0 1 started
    50 2 skipped None: replaced
    50 3 skipped None: replaced
    100 1 succeeded
    100 end
    "#);
}

#[tokio::test(start_paused = true)]
async fn no_more_steps_run_at_once_than_allowed() {
    let hands = Pretend::new(&[]);
    let mut narrow = batch((1..=20).map(|id| step(id, &[])).collect());
    narrow.parallelism = 3;
    let text = transcript(narrow, &hands, vec![]).await;
    assert_eq!(hands.most.load(Ordering::SeqCst), 3);
    assert!(text.ends_with("70 20 succeeded\n70 end\n"), "{text}");
}

#[tokio::test(start_paused = true)]
async fn an_empty_batch_ends_at_once() {
    let text = transcript(batch(vec![]), &Pretend::new(&[]), vec![]).await;
    assert_eq!(text, "0 end\n");
}

#[test]
fn batches_that_make_no_sense_are_refused() {
    let fault = |steps: &[Step], gates: &[StepId]| Queue::new(steps, gates).unwrap_err();
    assert_eq!(
        fault(&[step(2, &[1])], &[]),
        BatchFault::Unknown { step: 2, need: 1 }
    );
    assert_eq!(
        fault(&[step(1, &[2]), step(2, &[1])], &[]),
        BatchFault::Backwards { step: 1, need: 2 }
    );
    assert_eq!(
        fault(&[step(1, &[1])], &[]),
        BatchFault::Backwards { step: 1, need: 1 }
    );
    assert_eq!(
        fault(&[step(1, &[]), step(1, &[])], &[]),
        BatchFault::Twice(1)
    );
    assert_eq!(fault(&[step(1, &[])], &[1]), BatchFault::Twice(1));
    let mut ends = step(2, &[]);
    ends.after_end_of = vec![3];
    assert_eq!(
        fault(&[ends], &[3]),
        BatchFault::Backwards { step: 2, need: 3 }
    );
    let limit = |ms, steps: &[StepId]| limited(step(2, &[1]), steps, ms, OnTimeout::Fail);
    assert_eq!(fault(&[limit(0, &[1])], &[1]), BatchFault::NoTime(2));
    assert_eq!(
        fault(&[limit(9, &[1, 3])], &[1, 3]),
        BatchFault::NoWait {
            step: 2,
            limited: 3
        }
    );
}
