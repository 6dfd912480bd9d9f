//! Errors, panics and crashes.

use super::lab::*;

#[test]
fn what_fails_or_panics_is_told() {
    let cases = [
        // Fault, exit code of the apply, state, event, reason.
        "error-initialize 5 Unknown CreateFailed told to fail on_initialize",
        "error-startup 5 Unknown CreateFailed told to fail on_startup",
        "sulk 5 Unknown CreateFailed there is no fault `sulk`; there are none, crash-at-once",
        "error-activate 5 Error ComponentError told to fail on_activated",
        "error-execute 0|5 Error ComponentError told to fail on_execute",
        "panic 0|5 Error ComponentError told to panic in on_execute",
    ];
    all(&cases, |[fault, code, state, event, reason]| {
        let lab = Lab::new(fault, &[]);
        let said = lab.apply(code);
        assert_eq!(said.err.contains(reason), said.code == 5, "{said:#?}");
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        let component = lab.until(state, reason);
        assert_eq!(component["status"]["restarts"], 0, "nothing ended");
        lab.event(event, reason);
        let system = lab.stack.named("systems", "misbehaving");
        assert_eq!(system["status"]["healthy"], false, "{fault}");
        let diff = ["diff", &lab.file, "-f", &lab.overlay];
        lab.stack.expect(1, &diff);
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        lab.ends_within(SOON);
    });
}

#[test]
fn what_crashes_is_made_again_as_its_policy_says() {
    let cases = [
        // Fault, policy, exit code of the apply, restarts, why it stays away.
        "crash-at-once restart never 5 0 ended by signal 6",
        "crash-at-once restartLimit 1 5 0 restartLimit 1",
        "crash-later restartLimit 1 0|5 1 restartLimit 1",
        "exit restart on-failure 0|5 0 on-failure",
    ];
    all(&cases, |[fault, key, value, code, restarts, why]| {
        let mut lab = Lab::new(fault, &[(key, value)]);
        lab.set(fault, &[("after", "0.5")]);
        lab.apply(code);
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        let component = lab.until("Unknown", why);
        assert_eq!(component["status"]["restarts"], number(restarts), "{fault}");
        lab.event("ManagerDied", "ended unexpectedly");
        lab.event("NotRestarted", why);
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        lab.ends_within(SOON);
    });
}

#[test]
fn what_crashes_again_and_again_comes_back_each_time() {
    let cases = ["crash-later 0 signal 6", "exit 3 exit status 3"];
    all(&cases, |[fault, exit_code, exit]| {
        let mut lab = Lab::new(fault, &[("restart", "on-failure")]);
        lab.set(fault, &[("after", "0.3"), ("exit_code", exit_code)]);
        lab.apply("0|5");
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        lab.stack.until("components", "it came back twice", |all| {
            all.iter().any(|c| {
                c["metadata"]["name"] == BAD && c["status"]["restarts"].as_u64() >= Some(2)
            })
        });
        lab.event("ManagerDied", exit);
        lab.event("BackOff", "its process ended by itself");
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        // Mended, it stays.
        lab.set("none", &[("after", "0.3")]);
        lab.apply("0|5");
        lab.stack.until_seen("samples go all the way", |now| {
            let end = &now.of("Sink0").info.bindings[0];
            now.all_active(5) && end.connected && end.samples_received > 3
        });
        lab.ends_within(SOON);
    });
}

#[test]
fn a_rate_that_it_refuses_leads_to_error() {
    let lab = Lab::new("error-rate-changed", &[]);
    lab.apply("0");
    let text = std::fs::read_to_string(&lab.file).expect("the profile");
    let begin = format!(r#"rts:instanceName="{BAD}""#);
    let own = text.find(&begin).expect("the component");
    let (before, own) = text.split_at(own);
    let changed = format!(
        "{before}{}",
        own.replacen(r#"rts:rate="100.0""#, r#"rts:rate="50.0""#, 1)
    );
    assert_ne!(changed, text, "it has a rate");
    std::fs::write(&lab.file, changed).expect("the profile is written");
    let said = lab.apply("5");
    assert!(
        said.err.contains("told to fail on_rate_changed"),
        "{said:#?}"
    );
    lab.until("Error", "told to fail on_rate_changed");
    lab.event("ComponentError", "told to fail on_rate_changed");
    assert_eq!(lab.stack.witness().of(BAD).info.rate, 50.0);
    // The same again does not pass for well.
    lab.apply("5");
    lab.ends_within(SOON);
}
