//! Pages of the samples.

use super::*;
use crate::show::lists::typed;
use crate::show::samples;
use rts_controller_api::objects::Waiting;

fn scene() -> Scene {
    fn of<T: serde::de::DeserializeOwned>(kind: Kind) -> Vec<T> {
        typed(kind, &samples::values(kind)).unwrap()
    }
    Scene {
        now: samples::NOW,
        lacking: Vec::new(),
        systems: of(Kind::System),
        nodes: of(Kind::Node),
        components: of(Kind::Component),
        connectors: of(Kind::Connector),
        managers: of(Kind::Manager),
        events: of(Kind::Event),
    }
}

#[test]
fn every_kind_has_its_page() {
    let scene = scene();
    let mut text = String::new();
    for kind in Kind::ALL {
        let name = names(kind, &scene).remove(0);
        let pages = pages(kind, &name, &scene);
        assert_eq!(pages.len(), 1);
        text.push_str(&format!("# {kind:?}\n{}\n", pages[0]));
    }
    insta::assert_snapshot!(text);
    assert!(pages(Kind::Node, "nobody", &scene).is_empty());
}

#[test]
fn what_is_gone_is_told_by_its_events() {
    let mut scene = scene();
    scene.managers.clear();
    let page = pages(Kind::Manager, "hello.main", &scene).remove(0);
    assert!(page.contains("State:      not there"), "{page}");
    assert!(page.contains("ended with signal 9"), "{page}");
    assert!(pages(Kind::Manager, "hello.other", &scene).is_empty());
}

#[test]
fn a_component_that_does_not_run_says_why_and_when_it_is_tried_again() {
    let mut scene = scene();
    scene.systems[0].status.waiting_on = vec![
        Waiting {
            target: "module/SineSource@hello.main".to_owned(),
            reason: "LoadModule module/SineSource@hello.main: no such file".to_owned(),
            required: true,
            transient: false,
            tries: 3,
            next_try: Some(samples::NOW + jiff::SignedDuration::from_secs(4)),
        },
        Waiting {
            target: "component/Printer0".to_owned(),
            reason: "another one".to_owned(),
            required: true,
            transient: false,
            tries: 0,
            next_try: None,
        },
    ];
    let page = pages(Kind::Component, "Sine0", &scene).remove(0);
    let waits: Vec<_> = page
        .lines()
        .filter(|l| l.starts_with("Waits for"))
        .collect();
    assert_eq!(
        waits,
        [
            "Waits for:       module/SineSource@hello.main: LoadModule: no such file (tried 3 times, next try in 4s, at 22:13:24Z)"
        ]
    );
}

fn waits(target: &str, reason: &str) -> Waiting {
    Waiting {
        target: target.to_owned(),
        reason: reason.to_owned(),
        required: true,
        transient: false,
        tries: 0,
        next_try: None,
    }
}

fn page(kind: Kind, name: &str, scene: &Scene) -> String {
    pages(kind, name, scene).remove(0)
}

#[test]
fn a_component_that_is_not_there_shows_the_process_it_would_be_in() {
    let mut scene = scene();
    scene.components[0].status.pid = None;
    let manager = |scene: &Scene, says: &str| {
        let page = page(Kind::Component, "Sine0", scene);
        assert!(page.contains(&format!("Manager:         {says}\n")), "{page}");
    };
    manager(&scene, "main (pid 4711)");
    scene.managers[0].status.state = "Unresponsive".to_owned();
    manager(&scene, "main (pid 4711, Unresponsive)");
    scene.managers.clear();
    manager(&scene, "main (no process)");
}

#[test]
fn a_manager_that_is_gone_tells_what_keeps_its_components() {
    let mut scene = scene();
    scene.managers.clear();
    scene.events.clear();
    let held = "its process was killed by signal 9 and rtsctl.restart is never";
    scene.systems[0].status.waiting_on = vec![
        waits("component/Printer0", "another one"),
        waits("component/Sine0", held),
    ];
    let page = page(Kind::Manager, "hello.main", &scene);
    insta::assert_snapshot!(page, @r"
    Name:       hello.main
    State:      not there
    Waits for:  component/Sine0: its process was killed by signal 9 and rtsctl.restart is never
    Components:
      NAME   TYPE        MANAGER  STATE   RESTARTS
      Sine0  SineSource  main     Active  0
    Events:
      none
    ");
}

#[test]
fn what_hangs_comes_with_a_way_to_end_it() {
    let mut scene = scene();
    scene.components[0].status.waiting_on = Some("has been in on_execute for 16 s".to_owned());
    let text = page(Kind::Component, "Sine0", &scene);
    let help: Vec<_> = text.lines().filter(|l| l.starts_with("Help")).collect();
    insta::assert_snapshot!(help.join("\n"), @"Help:            `kill -9 4711` ends its process, with Filter0 in it, and it is started again; rtsctl.onHang: restart has that done by itself");
    let text = page(Kind::System, "hello", &scene);
    assert!(text.contains("  Sine0: `kill -9 4711` ends"), "{text}");
    scene.components[0].status.waiting_on = Some("its module failed".to_owned());
    assert!(!page(Kind::Component, "Sine0", &scene).contains("Help:"));
}

#[test]
fn a_node_without_its_agent_comes_with_the_way_to_start_it() {
    let mut scene = scene();
    scene.lacking = vec!["local".to_owned()];
    let says = "the agent of node local does not run: `rtsctl up` starts it again";
    for (kind, name) in [
        (Kind::Node, "local"),
        (Kind::Component, "Sine0"),
        (Kind::System, "hello"),
    ] {
        let page = page(kind, name, &scene);
        assert_eq!(page.matches(says).count(), 1, "{page}");
    }
    scene.lacking.clear();
    scene.nodes[0].status.state = "Unknown".to_owned();
    let page = page(Kind::Node, "local", &scene);
    assert!(page.contains("start it again on its machine"), "{page}");
}

#[test]
fn a_reason_of_many_is_told_once() {
    let mut scene = scene();
    let why = "node local holds the ledger of another store";
    let all = ["A", "B", "C"].map(|name| waits(&format!("component/{name}"), why));
    let condition = rts_controller_api::objects::Condition {
        kind: "Synced".to_owned(),
        status: "False".to_owned(),
        reason: "Waiting".to_owned(),
        message: format!("component/A: {why}"),
        last_transition_time: samples::NOW,
        observed_generation: 2,
    };
    scene.systems[0].status.waiting_on = all.to_vec();
    scene.systems[0].status.conditions = vec![condition];
    let page = page(Kind::System, "hello", &scene);
    assert!(page.contains(&format!("component/A, component/B, component/C: {why}\n")));
    assert_eq!(page.matches(why).count(), 1, "{page}");

    scene.systems[0].status.waiting_on = vec![waits("component/Sine0", why)];
    scene.connectors[0].status.waiting_on = Some(format!("Sine0 is not there: {why}"));
    let page = pages(Kind::Component, "Sine0", &scene).remove(0);
    assert_eq!(page.matches(why).count(), 1, "{page}");
    assert!(
        page.contains("Sine0 is not there: as component/Sine0"),
        "{page}"
    );
}

#[test]
fn what_was_changed_by_hand_is_told_with_what_becomes_of_it() {
    let mut scene = scene();
    let (sine, wire) = ("component/Sine0", "connector/Sine0.out-Filter0.in");
    let set = "configuration.default.gain: 1.0 -> 5";
    scene.systems[0].status.drift = vec![
        format!("{sine} was changed by hand ({set}): is left so (rtsctl.drift: ignore)"),
        "C9 (ConsoleOut) was made by hand in manager hello.main on node local".to_owned(),
    ];
    scene.components[0].status.drift = true;
    scene.components[0].status.drift_fields = vec![set.to_owned()];
    scene.connectors[0].status.drift = true;
    scene.connectors[0].status.drift_fields = vec!["was disconnected by hand".to_owned()];
    let mut text = String::new();
    for (kind, name) in [
        (Kind::System, "hello"),
        (Kind::Component, "Sine0"),
        (Kind::Connector, wire.trim_start_matches("connector/")),
    ] {
        let page = page(kind, name, &scene);
        let drift = page.lines().filter(|l| l.starts_with("Drift"));
        drift.for_each(|line| text.push_str(&format!("{kind:?}  {line}\n")));
    }
    insta::assert_snapshot!(text, @r"
    System  Drift:     component/Sine0 was changed by hand (configuration.default.gain: 1.0 -> 5): is left so (rtsctl.drift: ignore)
    System  Drift:     C9 (ConsoleOut) was made by hand in manager hello.main on node local
    Component  Drift:           was changed by hand (configuration.default.gain: 1.0 -> 5): is left so (rtsctl.drift: ignore)
    Connector  Drift:      was disconnected by hand
    ");
}
