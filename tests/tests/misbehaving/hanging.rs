//! Callbacks that do not return.

use std::time::{Duration, Instant};

use rts_tests::alive;
use serde_json::Value;

use super::lab::*;

#[test]
fn what_hangs_is_told() {
    let cases = [
        // Fault, exit code of the apply, state, callback.
        "hang-initialize 5 Created on_initialize",
        "hang-activate 5 Inactive on_activated",
        "hang-execute 0 Active on_execute",
        "hang-state-update 0 Active on_state_update",
        "hang-abort 0|5 Error on_aborting",
        "hang-error 0|5 Error on_error",
    ];
    all(&cases, |[fault, code, state, callback]| {
        let lab = Lab::new(fault, PATIENCE);
        lab.apply(code);
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        let component = lab.until(state, &format!("has been in {callback} for"));
        assert_eq!(component["status"]["restarts"], 0, "it is reported only");
        lab.event("Hangs", callback);
        let system = lab.stack.named("systems", "misbehaving");
        assert_eq!(system["status"]["healthy"], false, "{fault}");
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        // Not asked first, so that the test does not wait for what hangs; the daemons and all else end at once.
        lab.stack.leaves_nothing();
        assert!(family(&lab.stack).is_empty());
    });
}

#[test]
fn what_hangs_is_replaced_as_often_as_its_policy_allows() {
    let cases = [
        "hang-initialize 5 startTimeout",
        "hang-activate 5 startTimeout",
        "hang-execute 0|5 livenessTimeout",
    ];
    all(&cases, |[fault, code, limit]| {
        let lab = Lab::new(fault, ONCE);
        lab.apply(code);
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        let component = lab.until("Unknown", "restartLimit 1");
        assert_eq!(component["status"]["restarts"], 1);
        lab.event("ManagerExpired", limit);
        lab.event("NotRestarted", "restartLimit 1");
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        lab.ends_within(SOON);
    });
}

#[test]
fn a_teardown_ends_whatever_a_component_does_then() {
    let cases = [
        // Fault, seconds, event.
        "ignore-deactivate 6 ComponentError on_deactivated: told to fail on_deactivated",
        "hang-deactivate 19 DeactivateFailed has been in on_deactivated for 1",
        "hang-shutdown 19 DeleteFailed has been in on_shutdown for 1",
        "hang-finalize 19 DeleteFailed has been in on_finalize for 1",
    ];
    all(&cases, |[fault, seconds, event, text]| {
        let lab = Lab::new(fault, &[]);
        lab.apply("0");
        let process = lab.stack.witness().of(BAD).pid;
        let begun = Instant::now();
        lab.stack.expect(0, &["teardown", "misbehaving", "--yes"]);
        let took = begun.elapsed().as_secs_f64();
        assert!(took < f64::from(number(seconds)), "{fault}: {took} s");
        assert!(!alive(process), "{fault}");
        lab.event(event, text);
        assert_eq!(lab.stack.get("systems").len(), 0);
        lab.stack.leaves_nothing();
        assert!(family(&lab.stack).is_empty());
    });
}

#[test]
fn a_teardown_waits_no_longer_than_the_policy_of_what_hangs() {
    let cases = ["hang-execute", "hang-deactivate", "hang-finalize"];
    all(&cases, |[fault]| {
        let policies = [&PATIENCE[1..], &[("onHang", "restart")]].concat();
        let mut lab = Lab::new(fault, &policies);
        // A second after it is Active, at which the teardown is asked for.
        lab.set(fault, &[("after", "1")]);
        lab.apply("0");
        let process = lab.stack.witness().of(BAD).pid;
        std::thread::sleep(Duration::from_secs(1));
        lab.ends_within(SOON);
        assert!(!alive(process), "{fault}");
        assert!(family(&lab.stack).is_empty());
    });
}

#[test]
fn a_reset_that_hangs_is_no_longer_waited_for_than_its_policy_allows() {
    let policies = [ONCE, &[("resetOnError", "true")]].concat();
    let lab = Lab::new("hang-reset", &policies);
    lab.apply("0|5");
    let begun = Instant::now();
    lab.stack
        .until("components", "its process is replaced", |all| {
            let is = |c: &Value| c["metadata"]["name"] == BAD && c["status"]["restarts"] == 1;
            all.iter().any(is)
        });
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(8), "{took:?}");
    lab.event("ManagerExpired", "on_reset for longer than 1 s");
    lab.event("ResetFailed", "has been in on_reset for longer than 1 s");
    lab.ends_within(SOON);
}

#[test]
fn what_needs_two_seconds_to_activate_is_waited_for() {
    let lab = Lab::new("slow-activate", &[]);
    let begun = Instant::now();
    lab.apply("0");
    assert!(begun.elapsed() >= Duration::from_secs(2));
    lab.ends_within(SOON);
    // Longer than it may take: told, and good in the end.
    let lab = Lab::new("slow-activate", &[("startTimeout", "1s")]);
    let said = lab.apply("5");
    assert!(said.err.contains("on_activated for 1"), "{said:#?}");
    let bystanders = lab.bystanders();
    lab.stack
        .until("systems", "it is Active in the end", |systems| {
            systems[0]["status"]["healthy"] == true
        });
    bystanders.goes_on_undisturbed(&lab.stack);
    lab.ends_within(SOON);
}
