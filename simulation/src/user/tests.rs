use std::fmt::Write;
use std::time::Duration;

use rts_controller::simulator::{Parts, Scenario, ScenarioNode, Simulator, Stop};
use rts_controller::store::State;
use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::simulate::{Simulated, SimulatedEvent};
use rts_schemas::system::SystemSpec;

use super::UserSimulator;
use super::play::HONESTLY;

fn hello() -> SystemSpec {
    let bytes = include_bytes!("../../../manifests/hello/system.xml");
    let loaded = rts_schemas::rts_profile::load("hello.xml", bytes, None, &[]);
    loaded.unwrap().0
}

fn scenario(faults: &[&str]) -> Scenario {
    let set = |all: &[&str]| all.iter().map(|n| (*n).to_owned()).collect();
    let parts = Parts {
        managers: set(&["hello.main"]),
        instances: set(&["Sine0", "Filter0", "Printer0"]),
        types: set(&["SineSource", "LowPassFilter", "Printer"]),
    };
    Scenario {
        before: State {
            cluster_uid: "simulation".to_owned(),
            epoch: 1,
            ..State::default()
        },
        request: ApplyRequest::of(hello()),
        local_node: "local".to_owned(),
        nodes: vec![ScenarioNode {
            name: "local".to_owned(),
            aliases: Vec::new(),
            parts,
            modules: None,
        }],
        faults: faults.iter().map(|f| (*f).to_owned()).collect(),
        seed: 1,
        limit: Duration::from_secs(300),
        notes: Vec::new(),
        stop: Stop::default(),
    }
}

fn text(result: &Simulated) -> String {
    let mut text = String::new();
    for event in &result.events {
        let step = event.step.map_or(String::new(), |step| step.to_string());
        let (object, reason, message) = (&event.object, &event.reason, &event.message);
        writeln!(
            text,
            "{:>8} {step:>3} {object} {reason}: {message}",
            event.at_ms
        )
        .unwrap();
    }
    write!(text, "{:#?}\n{:#?}", result.notes, result.end).unwrap();
    text
}

fn play(faults: &[&str]) -> Simulated {
    UserSimulator.simulate(&scenario(faults)).unwrap()
}

/// Whether these happened, one after the other.
fn told(result: &Simulated, reasons: &[&str]) {
    let mut events = result.events.iter();
    for reason in reasons {
        let found = events.any(|event| event.reason == *reason);
        assert!(
            found,
            "{reason} is missing in its place in\n{}",
            text(result)
        );
    }
}

fn undone<'a>(result: &'a Simulated, object: &str) -> &'a str {
    let mut undone = result.end.undone.iter();
    let found = undone.find(|undone| undone.object == object);
    found.map_or("", |undone| undone.reason.as_str())
}

#[test]
fn without_faults_it_converges_step_by_step() {
    let result = play(&[]);
    assert!(result.end.converged, "{}", text(&result));
    told(
        &result,
        &[
            "Applied",
            "StartManager",
            "ProcessStarted",
            "Create",
            "Created",
            "Activated",
        ],
    );
    for step in &result.plan.steps {
        let begun = |e: &&SimulatedEvent| e.step == Some(step.id) && e.reason == step.work.kind();
        let begins = result.events.iter().filter(begun).count();
        assert_eq!(begins, 1, "step {}\n{}", step.id, text(&result));
    }
    assert!(result.end.undone.is_empty());
    assert_eq!(result.notes, [HONESTLY]);
    assert!(
        result
            .end
            .components
            .iter()
            .all(|c| c.state == "Active" && c.restarts == 0)
    );
    assert!(result.end.converged_ms.is_some_and(|ms| ms < 2_000));
}

#[test]
fn the_same_seed_shows_the_same() {
    let faults = [
        "manager hello.main dies at step 13",
        "network loses 10% delays 50ms for 5s",
    ];
    assert_eq!(play(&faults), play(&faults));
    let mut other = scenario(&faults);
    other.seed = 2;
    let other = UserSimulator.simulate(&other).unwrap();
    assert_ne!(other.events, play(&faults).events);
}

#[test]
fn a_manager_that_dies_is_brought_back() {
    let result = play(&["manager hello.main dies at 3s"]);
    assert!(result.end.converged, "{}", text(&result));
    told(
        &result,
        &[
            "Activated",
            "Fault",
            "ProcessEnded",
            "BackOff",
            "ProcessStarted",
            "Activated",
        ],
    );
    let restarts: Vec<u32> = result.end.components.iter().map(|c| c.restarts).collect();
    assert_eq!(restarts, [1, 0, 1], "{}", text(&result));
}

#[test]
fn an_agent_that_drops_for_a_while_is_noticed_and_found_again() {
    let result = play(&["agent local drops at step 10 for 10s"]);
    assert!(result.end.converged, "{}", text(&result));
    assert_eq!(result.faults, ["agent local drops at step 10 for 10s"]);
    told(
        &result,
        &["Create", "Fault", "NodeUnknown", "FaultOver", "NodeReady"],
    );
    let struck = result.events.iter().find(|e| e.reason == "Fault").unwrap();
    let tenth = result.events.iter().find(|e| e.step == Some(10)).unwrap();
    assert_eq!(struck.at_ms, tenth.at_ms, "as soon as the step has begun");
    assert!(result.end.converged_ms.unwrap() > 10_000);
}

#[test]
fn a_controller_that_crashes_goes_on_and_one_that_stays_away_is_said() {
    let result = play(&["controller crashes at step 10 for 5s"]);
    assert!(result.end.converged, "{}", text(&result));
    told(&result, &["Fault", "ProgramCrashed", "ProgramStarted"]);
    let mut gone = scenario(&["controller crashes at step 10"]);
    gone.limit = Duration::from_secs(30);
    let result = UserSimulator.simulate(&gone).unwrap();
    assert!(!result.end.converged);
    assert!(undone(&result, "controller").starts_with("it is down"));
    assert!(result.end.simulated_ms >= 30_000);
}

#[test]
fn what_cannot_come_up_is_left_undone_with_the_reason() {
    let mut scenario = scenario(&["component Printer0 misbehaves error-activate"]);
    scenario.limit = Duration::from_secs(60);
    let result = UserSimulator.simulate(&scenario).unwrap();
    assert!(!result.end.converged, "{}", text(&result));
    told(&result, &["Fault", "Activate", "Error", "ActivateFailed"]);
    assert!(undone(&result, "component/Printer0").contains("on_activated returned RTC_ERROR"));
    assert!(undone(&result, "component/Sine0").contains("waits for Filter0"));
}

#[test]
fn every_fault_can_strike_and_pass() {
    let faults = [
        "agent local crashes at 3s for 3s",
        "controller cannot reach local at 3s for 2s",
        "node local reboots at 3s for 10s",
        "managers on local fail to start for 5s",
        "module Printer fails for 5s",
        "component Sine0 misbehaves crash-later for 5s",
        "network loses 5% doubles 5% delays 20ms for 30s",
        "disk of local fails for 5s",
        "disk of local is slow 100ms for 5s",
        "disk of controller fails at 1s for 5s",
        "disk of controller is slow 100ms for 5s",
        "clock of local jumps -1h at 3s",
        "clock of controller jumps +1h at 3s",
    ];
    for fault in faults {
        let result = play(&[fault]);
        assert!(result.end.converged, "{fault}\n{}", text(&result));
        told(&result, &["Fault"]);
        assert!(
            result.never_came.is_empty(),
            "{fault}: {:?}",
            result.never_came
        );
    }
    let hangs = play(&["manager hello.main hangs at 3s"]);
    assert!(!hangs.end.converged);
    assert!(undone(&hangs, "component/Sine0").contains("does not answer"));
}

#[test]
fn faults_that_are_not_understood_are_refused_all_at_once() {
    let refused = |faults: &[&str]| {
        let problem = UserSimulator.simulate(&scenario(faults)).unwrap_err();
        assert_eq!((problem.status, problem.code.as_str()), (422, "bad-fault"));
        problem
    };
    let problem = refused(&["agent mars drops", "agent local dorps", "agent local drops"]);
    assert_eq!(problem.errors.len(), 2);
    assert!(
        problem.errors[0]
            .detail
            .contains("(local), found `mars` at character 7")
    );
    assert!(problem.errors[1].detail.contains("did you mean drops?"));
    let problem = refused(&["agent local drops at step 17"]);
    assert!(
        problem.detail.contains("the plan has only 16 steps"),
        "{}",
        problem.detail
    );
    refused(&["usurper appears"]);
}

#[test]
fn it_ends_when_nobody_waits() {
    let scenario = scenario(&[]);
    scenario.stop.stop();
    assert_eq!(
        UserSimulator.simulate(&scenario).unwrap_err().code,
        "stopped"
    );
}

/// hello as it is stored once it was applied to a node with those modules.
fn stored() -> Scenario {
    let mut scenario = scenario(&[]);
    let record = rts_controller::store::SystemRecord {
        uid: "u".to_owned(),
        generation: 3,
        index: 3,
        spec: hello().into(),
        digests: [("Printer".to_owned(), "old".to_owned())].into(),
        nodes: ["local".to_owned()].into(),
        created: jiff::Timestamp::UNIX_EPOCH,
        deleted: None,
        forgotten: [].into(),
        places: ["Sine0", "Filter0", "Printer0"]
            .map(|c| (c.to_owned(), "local".to_owned()))
            .into(),
        left: [].into(),
        stand_ins: [].into(),
    };
    scenario.before.systems = [("hello".to_owned(), record.into())].into();
    scenario
}

#[test]
fn what_is_stored_runs_before_the_change_comes() {
    let mut scenario = stored();
    // The module file of Printer is another one today: it is loaded into a new process.
    let result = UserSimulator.simulate(&scenario).unwrap();
    assert!(result.end.converged, "{}", text(&result));
    assert_eq!(result.plan.restarts.len(), 1, "{:#?}", result.plan.restarts);
    assert_eq!(
        result.events[0].reason, "Applied",
        "nothing of before is told"
    );
    assert!(result.end.components.iter().all(|c| c.restarts == 0));
    scenario.faults = vec!["node local reboots at step 2 for 6s".to_owned()];
    let result = UserSimulator.simulate(&scenario).unwrap();
    assert!(result.end.converged, "{}", text(&result));
}

#[test]
fn where_nothing_is_to_be_done_faults_come_at_once() {
    // As a first apply would store it.
    let mut scenario = stored();
    for record in scenario.before.systems.values_mut() {
        let digest = |name: &str| (name.to_owned(), crate::SimModule::new(name).digest);
        std::sync::Arc::make_mut(record).digests = ["SineSource", "LowPassFilter", "Printer"]
            .map(digest)
            .into();
    }
    scenario.faults = vec!["manager hello.main dies".to_owned()];
    let result = UserSimulator.simulate(&scenario).unwrap();
    assert!(result.plan.steps.is_empty(), "{:#?}", result.plan);
    assert!(
        result.end.converged && result.never_came.is_empty(),
        "{}",
        text(&result)
    );
    let restarts = result.end.components.iter().filter(|c| c.restarts == 1);
    assert_eq!(restarts.count(), 2);
}
