//! How stories are told.

use std::time::Duration;

use jiff::SignedDuration;
use rts_schemas::system::{Condition, ConnectorSpec, PortKind, PortRef, SystemSpec};
use rts_simulation::faults::{Fault, Timed, When};
use rts_simulation::run::{Options, Outcome, run};
use rts_simulation::schedule::{Deed, Named, Schedule, What};
use rts_simulation::workload::Change;

/// A node beside the controller's own.
pub const NODE: &str = "node1";
/// The host of the controller.
pub const CONTROLLER: &str = "controller";

pub fn seconds(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

/// A system `alpha` on the controller's node and on `node1`: on each a chain of two, in a process each.
pub fn alpha() -> SystemSpec {
    let component = |instance: &str, node: &str| {
        serde_json::from_value(serde_json::json!({
            "instance": instance,
            "type": "Filter",
            "configuration": {"sets": {"default": {"gain": "7"}}},
            "placement": {"node": node, "isolated": true},
        }))
        .unwrap()
    };
    SystemSpec {
        composites: Vec::new(),
        name: "alpha".to_owned(),
        full_id: "RTSystem:sim:alpha:1.0".to_owned(),
        components: vec![
            component("A0", "local"),
            component("A1", "local"),
            component("B0", NODE),
            component("B1", NODE),
        ],
        connectors: vec![connector("A0", "A1"), connector("B0", "B1")],
        orders: rts_schemas::system::Orders::default(),
    }
}

/// The same with one component on `node1`, which no apply needs any more once that has left.
pub fn lone() -> SystemSpec {
    rts_simulation::workload::without(&alpha(), "B1")
}

/// From the out-port of a component to the in-port of another.
pub fn connector(source: &str, target: &str) -> ConnectorSpec {
    ConnectorSpec {
        name: format!("{source}.out-{target}.in"),
        kind: PortKind::Data,
        source: port(source, "out"),
        target: port(target, "in"),
        data_type: None,
        properties: [].into(),
    }
}

fn port(instance: &str, port: &str) -> PortRef {
    PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    }
}

/// One after the other, as they are named.
pub fn sequence(names: &[&str]) -> Vec<Condition> {
    let numbered = names.iter().zip(1..);
    numbered
        .map(|(name, sequence)| Condition {
            target: (*name).to_owned(),
            sequence,
            wait: None,
        })
        .collect()
}

/// A story that is being written. Times are seconds of the run.
pub struct Play(Schedule);

impl Play {
    /// On three nodes: the controller's own, `node1` and `node2`. After so many seconds everything is mended.
    pub fn until(quiet: f64) -> Self {
        Self(Schedule {
            seed: 1,
            nodes: 3,
            systems: Vec::new(),
            deeds: Vec::new(),
            faults: Vec::new(),
            quiet: seconds(quiet),
        })
    }

    pub fn seed(mut self, seed: u64) -> Self {
        self.0.seed = seed;
        self
    }

    pub fn apply(mut self, at: f64, spec: SystemSpec) -> Self {
        let system = spec.name.clone();
        self.0.systems.push(spec);
        let change = Change::None;
        self.user(at, What::Apply { system, change })
    }

    pub fn change(self, at: f64, change: Change) -> Self {
        let system = "alpha".to_owned();
        self.user(at, What::Apply { system, change })
    }

    pub fn delete(self, at: f64) -> Self {
        let system = "alpha".to_owned();
        self.user(at, What::Delete { system })
    }

    fn user(mut self, at: f64, what: What) -> Self {
        let name = format!("d{}", self.0.deeds.len());
        let at = seconds(at);
        self.0.deeds.push(Deed { name, at, what });
        self
    }

    pub fn strike(self, at: f64, fault: Fault) -> Self {
        self.when(When::At(seconds(at)), fault)
    }

    pub fn at_step(self, step: u32, fault: Fault) -> Self {
        self.when(When::Step(step), fault)
    }

    fn when(mut self, when: When, fault: Fault) -> Self {
        let name = format!("f{}", self.0.faults.len());
        let fault = Timed { when, fault };
        self.0.faults.push(Named { name, fault });
        self
    }

    /// Nothing passes between the controller and a node.
    pub fn pull_cable(self, at: f64, node: &str, lasts: f64) -> Self {
        let cut = |from: &str, to: &str| Fault::Cut {
            from: from.to_owned(),
            to: to.to_owned(),
            lasts: Some(seconds(lasts)),
        };
        let (out, back) = (cut(CONTROLLER, node), cut(node, CONTROLLER));
        self.strike(at, out).strike(at, back)
    }

    pub fn crash(self, at: f64, host: &str, down: f64) -> Self {
        self.strike(at, crash(host, down))
    }

    /// Plays it. Every invariant must hold in it, from the begin to the last thing that is taken down.
    pub fn play(self) -> Story {
        let options = Options {
            trace: true,
            log: true,
        };
        let outcome = run(&self.0, options).unwrap();
        let story = Story(outcome);
        if let Some(violation) = &story.0.violation {
            panic!("{violation}\n{}", story.shown());
        }
        story
    }
}

pub fn crash(host: &str, down: f64) -> Fault {
    Fault::Crash {
        host: host.to_owned(),
        calls: 0,
        down: Some(seconds(down)),
    }
}

/// The wall clock of a host is set.
pub fn clock_jumps(host: &str, hours: i64) -> Fault {
    Fault::ClockJumps {
        host: host.to_owned(),
        by: SignedDuration::from_hours(hours),
    }
}

/// A story that was played.
pub struct Story(Outcome);

impl Story {
    /// Times of the lines that have all these words.
    pub fn times(&self, words: &[&str]) -> Vec<f64> {
        let lines = self.0.text.iter();
        let found = lines.filter(|line| words.iter().all(|word| line.contains(word)));
        let time = |line: &String| line.split_whitespace().next().unwrap().parse().unwrap();
        found.map(time).collect()
    }

    /// Time of the only such line.
    pub fn only(&self, words: &[&str]) -> f64 {
        match self.times(words)[..] {
            [time] => time,
            ref times => panic!("{words:?} is found at {times:?}\n{}", self.shown()),
        }
    }

    /// Time of the first such line from a time on.
    pub fn first(&self, from: f64, words: &[&str]) -> f64 {
        let times = self.times(words).into_iter();
        let first = times.filter(|time| *time >= from).reduce(f64::min);
        first.unwrap_or_else(|| panic!("there is no {words:?} after {from} s\n{}", self.shown()))
    }

    /// Time from which on everything was as desired, the last time.
    pub fn settled(&self) -> f64 {
        self.only(&["everything is as desired"])
    }

    /// Asserts that there is such a line neither before `until` nor before `from`.
    pub fn never(&self, from: f64, until: f64, words: &[&str]) {
        let mut times = self.times(words).into_iter();
        let found = times.find(|time| (from..until).contains(time));
        assert!(found.is_none(), "{words:?} at {found:?}\n{}", self.shown());
    }

    fn shown(&self) -> String {
        self.0.text.join("\n")
    }
}
