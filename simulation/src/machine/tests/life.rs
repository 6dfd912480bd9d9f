//! The life cycle of components and of a process.

use super::*;

#[tokio::test(start_paused = true)]
async fn a_component_lives_from_its_creation_to_the_shutdown() {
    let bench = bench();
    let (mut caller, family) = bench.start("m").await;
    assert_eq!(caller.hello.incarnation, "m");
    assert_eq!(caller.hello.pid, family.pid());
    insta::assert_snapshot!(caller.refused(create("A")).await, @"NotFound: the type `Relay` is not loaded");
    caller.ok(load()).await;
    caller.ok(create("A")).await;
    insta::assert_snapshot!(caller.refused(RequestBody::Reset { instance: "B".to_owned() }).await, @"NotFound: there is no component `B` in the manager m");
    caller.ok(activate("A")).await;
    sleep(Duration::from_secs(2)).await;
    let info = caller.component("A").await;
    assert_eq!((info.state.as_str(), info.rate), ("Active", 10.0));
    assert!((19..=21).contains(&info.executions), "{}", info.executions);
    let inventory = caller.inventory().await;
    assert_eq!(inventory.opened["Relay"], "as told");
    caller.ok(deactivate("A")).await;
    let before = caller.component("A").await.executions;
    sleep(Duration::from_secs(2)).await;
    assert_eq!(caller.component("A").await.executions, before);
    caller.ok(activate("A")).await;
    caller.ok(RequestBody::Shutdown).await;
    sleep(Duration::from_secs(1)).await;
    assert!(family.has_ended());
    insta::assert_snapshot!(bench.story(), @r"
    m started
    A created
    A Inactive -> Active: Asked
    A Active -> Inactive: Asked
    A Inactive -> Active: Asked
    A Active -> Inactive: Asked
    A deleted: Asked
    m ended: Asked
    ");
    let left = bench.machine.left_over();
    assert_eq!(left.folders, [folder("m")], "the agent removes it");
    bench.grip.remove_folder(&folder("m")).await;
    assert!(bench.machine.left_over().is_empty());
}

#[tokio::test(start_paused = true)]
async fn values_are_configured_and_marks_are_kept_and_forgotten() {
    let bench = bench();
    let (mut caller, _family) = bench.start_with("m", &["A"]).await;
    let configure = |name: &str, by_hand: Option<&str>| RequestBody::Configure {
        instance: "A".to_owned(),
        sets: [(
            "default".to_owned(),
            [(name.to_owned(), "7".to_owned())].into(),
        )]
        .into(),
        active: None,
        rate: Some(20.0),
        on_disconnect: Some("stop".to_owned()),
        order: None,
        by_hand: by_hand.map(str::to_owned),
    };
    insta::assert_snapshot!(caller.refused(configure("pain", None)).await, @"Invalid: A: there is no parameter `pain`");
    caller.ok(configure("gain", Some("mark"))).await;
    let info = caller.component("A").await;
    assert_eq!(
        (info.sets["default"]["gain"].as_str(), info.rate),
        ("7", 20.0)
    );
    assert_eq!(info.on_disconnect.as_deref(), Some("stop"));
    let marks = info.by_hand.unwrap();
    assert_eq!(marks.configured.as_deref(), Some("mark"));
    let forget = |mark: &str| RequestBody::Forget {
        instance: "A".to_owned(),
        by_hand: ByHandInfo {
            configured: Some(mark.to_owned()),
            ..Default::default()
        },
        connectors: Default::default(),
    };
    caller.ok(forget("another")).await;
    assert!(
        caller
            .component("A")
            .await
            .by_hand
            .unwrap()
            .configured
            .is_some()
    );
    caller.ok(forget("mark")).await;
    assert!(
        caller
            .component("A")
            .await
            .by_hand
            .unwrap()
            .configured
            .is_none()
    );
    caller.ok(configure("gain", Some("mark"))).await;
    caller.ok(configure("gain", None)).await;
    assert!(
        caller
            .component("A")
            .await
            .by_hand
            .unwrap()
            .configured
            .is_none()
    );
}

#[tokio::test(start_paused = true)]
async fn a_module_that_fails_or_has_changed_is_not_loaded() {
    let bench = bench();
    let (mut caller, _family) = bench.start("m").await;
    bench.machine.fail_module("Relay", true);
    insta::assert_snapshot!(caller.refused(load()).await, @"LoadFailed: type Relay: /simulated/modules/librelay.so cannot be opened (simulated)");
    bench.machine.fail_module("Relay", false);
    caller.ok(load()).await;
    let new = SimModule::new("Relay").version(2);
    bench.machine.replace_module("Relay", &new);
    let found = bench.grip.resolve("Relay").await.unwrap();
    assert_eq!(found.module.unwrap().digest, new);
    insta::assert_snapshot!(caller.refused(load()).await, @"LoadFailed: type Relay: /simulated/modules/librelay.so has changed since this manager opened it, and code that is loaded cannot be exchanged; restart this manager");
    caller.ok(create("A")).await;
    let unload = RequestBody::UnloadModule {
        type_name: "Relay".to_owned(),
    };
    insta::assert_snapshot!(caller.refused(unload.clone()).await, @"Conflict: the type Relay is used by A; delete it first");
    caller.ok(delete("A")).await;
    caller.ok(unload).await;
    let inventory = caller.inventory().await;
    assert!(inventory.modules.is_empty() && inventory.opened.contains_key("Relay"));
}

#[tokio::test(start_paused = true)]
async fn one_that_cannot_start_says_why_in_its_log() {
    let bench = bench();
    bench.machine.fail_to_start(true);
    let start = start("m", "m");
    bench.grip.make_folder(&start.folder).await.unwrap();
    let launched = bench.grip.launch(&start).await;
    let launched = launched.map_err(|e| e.to_string()).unwrap();
    let exit = timeout(LONG, launched.exit).await.unwrap();
    assert_eq!(exit, Exit::Code(1));
    let log = bench.grip.log_end(&start, launched.log_start, 5).await;
    assert_eq!(log, "ERROR it cannot start (simulated)\n");
    insta::assert_snapshot!(bench.story(), @r"
    m started
    m/- blemished: it cannot start
    m ended: Fault
    ");
}
