//! Pages of the samples.

use super::*;
use crate::show::lists::typed;
use crate::show::samples;

fn scene() -> Scene {
    fn of<T: serde::de::DeserializeOwned>(kind: Kind) -> Vec<T> {
        typed(kind, &samples::values(kind)).unwrap()
    }
    Scene {
        now: samples::NOW,
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
            "Waits for:   module/SineSource@hello.main: LoadModule: no such file (tried 3 times, next try in 4s, at 22:13:24Z)"
        ]
    );
}
