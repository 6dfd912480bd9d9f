//! Simulations that are asked for: what the simulator is given, one at a time, and whatever it does.

use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use crate::fleet::served::{Served, problem, serve};
use crate::fleet::{Cluster, FakeFleet, systems};
use rts_controller::simulator::{Scenario, Simulator};
use rts_controller::store::MemoryStore;
use rts_controller_api::Problem;
use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::simulate::{SimulateRequest, Simulated, SimulatedEnd};

type Play = Box<dyn Fn(&Scenario) -> Result<Simulated, Problem> + Send>;

/// Does what a test says.
struct Fake {
    seen: Arc<Mutex<Option<Scenario>>>,
    play: Mutex<Play>,
}

impl Simulator for Fake {
    fn simulate(&self, scenario: &Scenario) -> Result<Simulated, Problem> {
        *self.seen.lock().unwrap() = Some(scenario.clone());
        let play = self.play.lock().unwrap_or_else(|e| e.into_inner());
        play(scenario)
    }
}

fn nothing(scenario: &Scenario) -> Simulated {
    Simulated {
        never_came: Vec::new(),
        seed: scenario.seed,
        faults: scenario.faults.clone(),
        notes: scenario.notes.clone(),
        plan: Default::default(),
        events: Vec::new(),
        omitted: 0,
        end: SimulatedEnd {
            converged: true,
            converged_ms: Some(1),
            simulated_ms: 1,
            systems: Vec::new(),
            components: Vec::new(),
            undone: Vec::new(),
        },
    }
}

async fn served(
    play: impl Fn(&Scenario) -> Result<Simulated, Problem> + Send + 'static,
) -> (Served, Arc<Mutex<Option<Scenario>>>) {
    let fleet = FakeFleet::default();
    fleet.add("local", &["SineSource", "LowPassFilter", "Printer"]);
    let seen = Arc::default();
    let simulator = Fake {
        seen: Arc::clone(&seen),
        play: Mutex::new(Box::new(play)),
    };
    let store = MemoryStore::new("cluster");
    let mut cluster = Cluster::simulated_by(fleet, store, Arc::new(simulator));
    cluster.join("local", "s1");
    (serve(cluster).await, seen)
}

fn request(faults: &[&str]) -> SimulateRequest {
    SimulateRequest {
        faults: faults.iter().map(|f| (*f).to_owned()).collect(),
        ..SimulateRequest::of(ApplyRequest::of(systems::hello()))
    }
}

const PATIENCE: Duration = Duration::from_secs(10);

#[tokio::test]
async fn the_simulator_is_given_all_that_there_is_and_nothing_changes() {
    let (served, seen) = served(|scenario| Ok(nothing(scenario))).await;
    let asked = request(&["x"]);
    let simulate = || served.controller.simulate(&asked, PATIENCE);
    let answer = simulate().await.unwrap();
    assert_eq!((answer.seed, answer.faults), (1, vec!["x".to_owned()]));
    assert_eq!(answer.notes, Vec::<String>::new());
    let scenario = seen.lock().unwrap().take().unwrap();
    assert_eq!(scenario.request.spec, systems::hello());
    assert!(scenario.before.systems.is_empty());
    assert_eq!(scenario.limit, Duration::from_secs(300));
    let nodes: Vec<_> = scenario.nodes.iter().map(|n| n.name.as_str()).collect();
    assert_eq!(nodes, ["local"]);
    assert_eq!(scenario.nodes[0].modules.as_ref().unwrap().len(), 3);
    assert!(served.cluster.stored().systems.is_empty());

    served.cluster.apply(systems::hello()).await;
    served.until_converged("hello").await;
    let stored = served.cluster.stored();
    served.cluster.fleet.agent("local").kill("hello.main");
    served.cluster.fleet.agent("local").silence(true);
    tokio::time::sleep(Duration::from_secs(5)).await;
    let answer = simulate().await;
    // An apply would be refused, and so is a simulation of it.
    assert_eq!(problem(answer).status, 503);
    assert_eq!(served.cluster.stored(), stored);
}

#[tokio::test]
async fn one_at_a_time_and_the_one_is_told_when_nobody_waits() {
    let (tell, told) = mpsc::channel();
    let (served, _) = served(move |scenario| {
        tell.send("begun").unwrap();
        while !scenario.stop.is_stopped() {
            std::thread::sleep(Duration::from_millis(5));
        }
        tell.send("stopped").unwrap();
        Ok(nothing(scenario))
    })
    .await;
    let controller = served.controller.clone();
    let first = tokio::spawn(async move { controller.simulate(&request(&[]), PATIENCE).await });
    let told = tokio::task::spawn_blocking(move || {
        assert_eq!(told.recv_timeout(PATIENCE).unwrap(), "begun");
        told
    });
    let told = told.await.unwrap();
    let busy = problem(served.controller.simulate(&request(&[]), PATIENCE).await);
    assert_eq!((busy.status, busy.code.as_str()), (503, "simulation-busy"));
    first.abort();
    let stopped = tokio::task::spawn_blocking(move || told.recv_timeout(PATIENCE));
    assert_eq!(stopped.await.unwrap().unwrap(), "stopped");
}

#[tokio::test]
async fn a_panic_is_an_answer_and_the_next_one_is_played() {
    let (served, _) = served(|scenario| match scenario.faults.len() {
        0 => Ok(nothing(scenario)),
        _ => panic!("nobody thought of that"),
    })
    .await;
    let failed = served.controller.simulate(&request(&["x"]), PATIENCE).await;
    let failed = problem(failed);
    assert_eq!(failed.status, 500);
    assert!(failed.detail.contains("seed 1: nobody thought of that"));
    let next = served.controller.simulate(&request(&[]), PATIENCE).await;
    assert!(next.unwrap().end.converged);
}

#[tokio::test]
async fn bounds_are_kept_before_anything_is_asked() {
    let (served, seen) = served(|scenario| Ok(nothing(scenario))).await;
    let many = vec!["x"; 101];
    let long = "x".repeat(501);
    let mut slow = request(&[]);
    slow.limit_seconds = Some(3601);
    let bad = [
        (request(&many), "bad-fault"),
        (request(&[&long]), "bad-fault"),
        (slow, "bad-limit"),
    ];
    for (request, code) in bad {
        let refused = problem(served.controller.simulate(&request, PATIENCE).await);
        assert_eq!((refused.status, refused.code.as_str()), (422, code));
    }
    assert!(seen.lock().unwrap().is_none());
}
