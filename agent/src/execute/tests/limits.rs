//! Steps that wait for the end of others, or for a limited time.

use rts_plan::plan::{Limit, OnTimeout};

use super::*;

pub(super) fn limited(mut step: Step, steps: &[StepId], ms: u32, then: OnTimeout) -> Step {
    let steps = steps.to_vec();
    step.limits.push(Limit { steps, ms, then });
    step
}

#[tokio::test(start_paused = true)]
async fn who_waits_for_an_end_goes_on_however_it_ends() {
    let hands = Pretend::new(&[(1, 30, false), (3, 20, true)]);
    let mut steps = vec![
        step(1, &[]),
        step(2, &[1]),
        step(3, &[]),
        step(5, &[]),
        step(6, &[]),
        step(7, &[]),
    ];
    // Behind a step that fails, behind one that is skipped, and behind gates that end in both ways.
    steps[3].after_end_of = vec![1, 3];
    steps[4].after_end_of = vec![2];
    steps[5].after_end_of = vec![4];
    let mut last = step(9, &[]);
    last.after_end_of = vec![8];
    steps.push(last);
    let mut gated = batch(steps);
    gated.gates = vec![4, 8];
    let report = GateReport {
        started: vec![4],
        succeeded: vec![8],
        failed: vec![4],
    };
    let began = GateReport {
        started: vec![4, 8],
        succeeded: Vec::new(),
        failed: Vec::new(),
    };
    let said = vec![(40, Word::Gates(began)), (50, Word::Gates(report))];
    insta::assert_snapshot!(transcript(gated, &hands, said).await, @r"
    0 1 started
    0 3 started
    20 3 succeeded
    30 1 failed: Activate component/C1: it would not
    30 2 skipped Some(1): step 1 failed
    30 5 started
    30 6 started
    40 5 succeeded
    40 6 succeeded
    50 7 started
    50 9 started
    60 7 succeeded
    60 9 succeeded
    60 end
    ");
}

#[tokio::test(start_paused = true)]
async fn a_step_that_waited_for_as_long_as_it_may_fails_and_what_needs_it_is_skipped() {
    let hands = Pretend::new(&[(1, 100, true), (2, 5_000, true), (3, 5_000, true)]);
    // The time runs from 100 ms on, when the step without a limit has ended.
    let waits = limited(step(4, &[1, 2]), &[2], 500, OnTimeout::Fail);
    let mut others = step(6, &[1, 3]);
    others.after_end_of = vec![2];
    let others = limited(others, &[2, 3], 50, OnTimeout::Fail);
    let steps = vec![
        step(1, &[]),
        step(2, &[]),
        step(3, &[]),
        waits,
        step(5, &[4]),
        others,
    ];
    insta::assert_snapshot!(transcript(batch(steps), &hands, vec![]).await, @r"
    0 1 started
    0 2 started
    0 3 started
    100 1 succeeded
    150 6 failed: Activate component/C6: waited 50 ms for Activate component/C2 and Activate component/C3 (Preceding time-out of the profile), which have not ended
    600 4 failed: Activate component/C4: waited 500 ms for Activate component/C2 (Preceding time-out of the profile), which has not ended
    600 5 skipped Some(4): step 4 failed
    5000 2 succeeded
    5000 3 succeeded
    5000 end
    ");
}

#[tokio::test(start_paused = true)]
async fn a_step_that_goes_on_does_so_after_its_time_and_without_what_failed() {
    let hands = Pretend::new(&[(1, 20, false), (2, 5_000, true), (3, 50, false)]);
    let after = |id, needs: &[StepId], ms| limited(step(id, needs), needs, ms, OnTimeout::GoOn);
    let steps = vec![
        step(1, &[]),
        step(2, &[]),
        step(3, &[]),
        after(4, &[1], 500),
        after(5, &[2], 500),
        after(6, &[3, 2], 200),
        // One that fails too late to matter.
        after(7, &[3], 40),
    ];
    insta::assert_snapshot!(transcript(batch(steps), &hands, vec![]).await, @r"
    0 1 started
    0 2 started
    0 3 started
    20 1 failed: Activate component/C1: it would not
    20 4 started
    30 4 succeeded
    40 7 started
    50 3 failed: Activate component/C3: it would not
    50 7 succeeded
    200 6 started
    210 6 succeeded
    500 5 started
    510 5 succeeded
    5000 2 succeeded
    5000 end
    ");
}

#[tokio::test(start_paused = true)]
async fn what_is_waited_for_with_a_limit_and_fails_is_a_failure_as_without() {
    let hands = Pretend::new(&[(1, 20, false)]);
    let after = limited(step(2, &[1]), &[1], 500, OnTimeout::Fail);
    insta::assert_snapshot!(transcript(batch(vec![step(1, &[]), after]), &hands, vec![]).await, @r"
    0 1 started
    20 1 failed: Activate component/C1: it would not
    20 2 skipped Some(1): step 1 failed
    20 end
    ");
}

#[tokio::test(start_paused = true)]
async fn limits_run_side_by_side_and_the_wait_time_comes_after_them() {
    let hands = Pretend::new(&[(1, 10, true), (2, 900, true), (3, 900, true)]);
    let mut after = step(4, &[1, 2, 3]);
    after = limited(after, &[2], 100, OnTimeout::GoOn);
    after = limited(after, &[3], 300, OnTimeout::GoOn);
    after.wait_ms = 50;
    let mut gated = limited(step(6, &[5]), &[5], 250, OnTimeout::Fail);
    gated.after_start_of = vec![5];
    let mut asks = limited(step(7, &[]), &[5], 250, OnTimeout::Fail);
    asks.after_start_of = vec![5];
    let mut batch = batch(vec![
        step(1, &[]),
        step(2, &[]),
        step(3, &[]),
        after,
        gated,
        asks,
    ]);
    batch.gates = vec![5];
    insta::assert_snapshot!(transcript(batch, &hands, vec![]).await, @r"
    0 1 started
    0 2 started
    0 3 started
    10 1 succeeded
    250 6 failed: Activate component/C6: waited 250 ms for step 5 of another node (Preceding time-out of the profile), which has not ended
    250 7 failed: Activate component/C7: waited 250 ms for step 5 of another node (Preceding time-out of the profile), which has not started
    360 4 started
    370 4 succeeded
    900 2 succeeded
    900 3 succeeded
    900 end
    ");
}

#[tokio::test(start_paused = true)]
async fn what_ends_in_time_costs_nothing_and_a_cancelled_wait_does_not_fail() {
    let hands = Pretend::new(&[(1, 100, true), (2, 300, true)]);
    let steps = vec![
        step(1, &[]),
        step(2, &[]),
        limited(step(3, &[1]), &[1], 101, OnTimeout::Fail),
        limited(step(4, &[2]), &[2], 250, OnTimeout::Fail),
    ];
    let said = vec![(200, Word::Cancel("replaced".to_owned()))];
    insta::assert_snapshot!(transcript(batch(steps), &hands, said).await, @r"
    0 1 started
    0 2 started
    100 1 succeeded
    100 3 started
    110 3 succeeded
    200 4 skipped None: replaced
    300 2 succeeded
    300 end
    ");
}
