use std::time::Duration;

use jiff::SignedDuration;
use proptest::prelude::*;

use super::*;
use crate::faults::{Fault, Timed, When};
use crate::words::print::MISBEHAVIOURS;

fn names() -> Names {
    let set = |all: &[&str]| all.iter().map(|n| (*n).to_owned()).collect();
    Names {
        nodes: set(&["node1", "node2"]),
        managers: [("hello.main".to_owned(), set(&["node1"]))].into(),
        instances: set(&["Printer0", "Sine0"]),
        types: [("Printer".to_owned(), set(&["node1", "node2"]))].into(),
    }
}

fn read(text: &str) -> String {
    let settled = parse(text).and_then(|faults| settle(text, faults, &names()));
    match settled {
        Ok(faults) => print_all(&faults).join("; "),
        Err(error) => format!("ERROR {error}"),
    }
}

#[test]
fn what_can_be_said_is_understood() {
    let said = [
        "agent node2 drops at step 5 for 10s",
        "agent node2 drops",
        "agent node2 crashes at 2.5s for 3s",
        "controller crashes at step 3 for 5s",
        "controller cannot reach node1",
        "node1 cannot reach node2 from 200ms for 1m",
        "node node2 reboots at 4s for 10s",
        "node node2 reboots",
        "manager hello.main dies at step 4",
        "manager hello.main hangs on node1 at 3s",
        "manager any dies on node2",
        "module Printer fails",
        "module Printer fails on node1 for 5s",
        "component Printer0 misbehaves error-activate",
        "component Printer0 misbehaves hang-execute at 2s for 3s",
        "network loses 10% delays 200ms from 0s for 30s",
        "network doubles 0.5%",
        "disk of node1 fails at 3s for 5s",
        "disk of controller is slow 500ms",
        "clock of node1 jumps -1h at 3s",
        "managers on node1 fail to start for 5s",
        "agent node1 crashes after 7 calls",
        "usurper appears at 9s",
    ];
    let read: Vec<String> = said
        .iter()
        .map(|t| format!("{t}\n    {}", read(t)))
        .collect();
    insta::assert_snapshot!(read.join("\n"));
}

#[test]
fn what_cannot_is_named_with_its_place() {
    let said = [
        "",
        "agnet node2 drops",
        "agent node3 drops",
        "agent node2 crashs",
        "agent node2 crashes at stp 3",
        "agent node2 crashes at step three",
        "agent node2 crashes for 3",
        "agent node2 crashes for 3s for 4s",
        "manager hello.main dies for 3s",
        "manager hello.mian dies",
        "manager hello.main dies on node2",
        "manager any dies",
        "module Pinter fails",
        "component Printer0 misbehaves error-activated",
        "component Priner0 misbehaves panic",
        "network",
        "network loses 101%",
        "clock of node1 jumps 1",
        "clock of node1 jumps 1s at 2s sharp",
        "disk of \"node1 fails",
        "node1 reboots",
    ];
    let read: Vec<String> = said
        .iter()
        .map(|t| format!("{t}\n    {}", read(t)))
        .collect();
    insta::assert_snapshot!(read.join("\n"));
}

#[test]
fn every_kind_is_in_the_grammar() {
    let (_, said) = parse::FIRST.split_last().unwrap();
    for word in said {
        let begin = format!("  {word} ");
        assert!(
            GRAMMAR.contains(&begin) || GRAMMAR.contains(&format!(", {word} ")),
            "{word}"
        );
    }
}

fn name() -> impl Strategy<Value = String> {
    prop_oneof![
        "[A-Za-z][A-Za-z0-9_.]{0,8}",
        Just("any".to_owned()),
        Just("controller".to_owned()),
        Just("disk".to_owned()),
        ".{0,6}",
    ]
}

fn duration() -> impl Strategy<Value = Duration> {
    prop_oneof![
        (0_u64..10_000).prop_map(Duration::from_secs),
        (0_u64..10_000_000).prop_map(Duration::from_millis),
        (0_u64..10_000_000_000).prop_map(Duration::from_nanos),
    ]
}

fn lasts() -> impl Strategy<Value = Option<Duration>> {
    prop::option::of(duration())
}

fn by() -> impl Strategy<Value = SignedDuration> {
    (duration(), any::<bool>()).prop_map(|(by, back)| {
        let by = SignedDuration::try_from(by).unwrap();
        if back { -by } else { by }
    })
}

fn of_hosts() -> impl Strategy<Value = Fault> {
    prop_oneof![
        (name(), any::<u64>(), lasts()).prop_map(|(host, calls, down)| Fault::Crash {
            host,
            calls,
            down
        }),
        (name(), duration()).prop_map(|(node, down)| Fault::Reboot { node, down }),
        (name(), name(), lasts()).prop_map(|(from, to, lasts)| Fault::Cut { from, to, lasts }),
        (0_u32..=1000, 0_u32..=1000, duration(), duration()).prop_map(
            |(lost, doubled, delay, lasts)| Fault::Weather {
                lost,
                doubled,
                delay,
                lasts
            }
        ),
        (name(), duration()).prop_map(|(host, lasts)| Fault::DiskFails { host, lasts }),
        (name(), duration(), duration()).prop_map(|(host, delay, lasts)| Fault::DiskSlow {
            host,
            delay,
            lasts
        }),
        (name(), by()).prop_map(|(host, by)| Fault::ClockJumps { host, by }),
        Just(Fault::Usurper),
    ]
}

fn of_processes() -> impl Strategy<Value = Fault> {
    let manager = || prop::option::of(name());
    prop_oneof![
        (name(), manager()).prop_map(|(node, manager)| Fault::ManagerDies { node, manager }),
        (name(), manager()).prop_map(|(node, manager)| Fault::ManagerHangs { node, manager }),
        (name(), duration()).prop_map(|(node, lasts)| Fault::ManagersFailToStart { node, lasts }),
        (name(), name(), lasts()).prop_map(|(node, type_name, lasts)| Fault::ModuleFails {
            node,
            type_name,
            lasts
        }),
        (name(), 0..MISBEHAVIOURS.len(), lasts()).prop_map(|(instance, how, lasts)| {
            let how = MISBEHAVIOURS[how].1;
            Fault::Misbehaves {
                instance,
                how,
                lasts,
            }
        }),
    ]
}

fn timed() -> impl Strategy<Value = Timed> {
    let when = prop_oneof![
        duration().prop_map(When::At),
        any::<u32>().prop_map(When::Step)
    ];
    let fault = prop_oneof![of_hosts(), of_processes()];
    (when, fault).prop_map(|(when, fault)| Timed { when, fault })
}

proptest! {
    #[test]
    fn what_is_printed_is_read_as_the_same(fault in timed()) {
        let text = print(&fault);
        prop_assert_eq!(parse(&text).unwrap(), vec![fault], "{}", text);
    }

    #[test]
    fn faults_in_a_row_are_read_as_the_same(faults in prop::collection::vec(timed(), 0..4)) {
        let texts = print_all(&faults);
        let read: Result<Vec<_>, _> = texts.iter().map(|text| parse(text)).collect();
        prop_assert_eq!(read.unwrap().concat(), faults);
    }

    #[test]
    fn nothing_makes_it_panic(text in ".{0,60}") {
        let _ = parse(&text).and_then(|faults| settle(&text, faults, &names()));
    }

    #[test]
    fn words_in_any_order_do_not_make_it_panic(words in prop::collection::vec(0..WORDS.len(), 0..9)) {
        let text = words.iter().map(|at| WORDS[*at]).collect::<Vec<_>>().join(" ");
        if let Ok(faults) = parse(&text) {
            let again: Vec<Timed> = print_all(&faults).iter().flat_map(|t| parse(t).unwrap()).collect();
            prop_assert_eq!(again, faults);
        }
    }
}

const WORDS: [&str; 32] = [
    "agent",
    "controller",
    "node",
    "manager",
    "managers",
    "module",
    "component",
    "network",
    "disk",
    "clock",
    "usurper",
    "drops",
    "crashes",
    "cannot",
    "reach",
    "reboots",
    "dies",
    "hangs",
    "on",
    "fail",
    "to",
    "start",
    "misbehaves",
    "panic",
    "loses",
    "5%",
    "of",
    "fails",
    "at",
    "step",
    "3",
    "10s",
];

#[test]
fn the_help_names_every_way_to_misbehave() {
    for (name, _) in MISBEHAVIOURS {
        let (verb, rest) = name.split_once('-').unwrap_or((name, ""));
        let says = |line: &str| line.contains(&format!(" {verb}")) && line.contains(rest);
        assert!(GRAMMAR.lines().any(says), "{name}");
    }
}
