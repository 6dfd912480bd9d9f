//! Components that misbehave.

use crate::faults::Misbehaviour;

use super::*;

#[tokio::test(start_paused = true)]
async fn a_hang_is_answered_in_time_shown_and_ends_with_what_misbehaves() {
    let bench = bench();
    let (mut caller, _) = bench.start_with("m", &["A"]).await;
    let misbehave = |how| bench.machine.misbehave("A", how);
    misbehave(Some(Misbehaviour::HangDeactivate));
    let begin = Instant::now();
    insta::assert_snapshot!(caller.refused(deactivate("A")).await, @"Deadline: A has been in on_deactivated for 10.0 s");
    assert!(begin.elapsed() < Duration::from_secs(11));
    let info = caller.component("A").await;
    assert_eq!(info.busy.unwrap().callback, "on_deactivated");
    assert_eq!(info.state, "Active");
    misbehave(None);
    sleep(Duration::from_secs(1)).await;
    let info = caller.component("A").await;
    assert_eq!((info.state.as_str(), info.busy), ("Inactive", None));
    insta::assert_snapshot!(caller.pushed.join("\n"), @"component/A : is Inactive, after its request's deadline");
    misbehave(Some(Misbehaviour::HangFinalize));
    // It hangs, and the process ends in time all the same.
    caller.ok(RequestBody::Shutdown).await;
    sleep(Duration::from_secs(1)).await;
    insta::assert_snapshot!(bench.story(), @r"
    m started
    A created
    A Inactive -> Active: Asked
    m/A blemished: on_deactivated does not return
    A Active -> Inactive: Asked
    m/A blemished: on_finalize does not return
    A deleted: Died
    m ended: Asked
    ");
}

#[tokio::test(start_paused = true)]
async fn a_component_can_take_its_process_down() {
    let bench = bench();
    bench
        .machine
        .misbehave("A", Some(Misbehaviour::CrashAtOnce));
    let (mut caller, _) = bench.start("m").await;
    caller.ok(load()).await;
    assert_eq!(caller.call_within(create("A"), 10).await, None);
    insta::assert_snapshot!(bench.story(), @r"
    m started
    m/A blemished: on_initialize crashes
    m/- blemished: A crashes in it
    m ended: Fault
    ");
    bench.machine.misbehave("A", Some(Misbehaviour::CrashLater));
    bench.grip.bury(&folder("m"), None).await.unwrap();
    let (mut caller, family) = bench.start_with("m", &["B", "A"]).await;
    assert_eq!(caller.component("A").await.state, "Active");
    sleep(Duration::from_secs(4)).await;
    assert!(family.has_ended());
    insta::assert_snapshot!(bench.story(), @r"
    m started
    B created
    B Inactive -> Active: Asked
    A created
    A Inactive -> Active: Asked
    m/A blemished: on_execute crashes
    m/- blemished: A crashes in it
    A deleted: Died
    B deleted: Died
    m ended: Fault
    ");
}

#[tokio::test(start_paused = true)]
async fn each_way_to_misbehave_does_what_it_says() {
    use Misbehaviour as M;
    let mut text = String::new();
    for how in [
        M::HangInitialize,
        M::HangActivate,
        M::HangExecute,
        M::ErrorInitialize,
        M::ErrorActivate,
        M::ErrorExecute,
        M::Panic,
        M::IgnoreDeactivate,
        M::SlowActivate,
    ] {
        let bench = bench();
        bench.machine.misbehave("A", Some(how));
        let (mut caller, _) = bench.start("m").await;
        caller.ok(load()).await;
        text += &format!("{how:?}\n");
        for request in [create("A"), activate("A")] {
            if let Err(failure) = caller.call(request).await {
                text += &format!("  {:?}: {}\n", failure.code, failure.message);
            }
        }
        sleep(Duration::from_secs(4)).await;
        let components = caller.inventory().await.components;
        let state = components.first().map_or("none", |c| c.state.as_str());
        let busy = components.first().and_then(|c| c.busy.clone());
        let busy = busy.map_or(String::new(), |busy| format!(" in {}", busy.callback));
        text += &format!("  {state}{busy}\n");
        if let Err(failure) = caller.call(deactivate("A")).await {
            text += &format!("  {:?}: {}\n", failure.code, failure.message);
        }
        let story = bench.story();
        assert!(story.contains("m/A blemished"), "{story}");
    }
    insta::assert_snapshot!(text);
}
