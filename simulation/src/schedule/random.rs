//! The schedule of a seed.

use std::time::Duration;

use jiff::SignedDuration;
use rts_agent_api::messages::Act;
use rts_schemas::system::{PortRef, SystemSpec};

use super::{Deed, Named, Schedule, What};
use crate::faults::{Fault, Misbehaviour, Timed, When};
use crate::seed::{Seed, Stream};
use crate::workload::{Change, NODES, TYPES, change, random};

/// Names of systems, and what the names of their components begin with.
const SYSTEMS: [(&str, char); 2] = [("alpha", 'A'), ("beta", 'B')];
/// Most changes and faults of a run.
const MOST: (u64, u64) = (6, 7);

const MISBEHAVIOURS: [Misbehaviour; 13] = [
    Misbehaviour::CrashAtOnce,
    Misbehaviour::CrashLater,
    Misbehaviour::HangInitialize,
    Misbehaviour::HangActivate,
    Misbehaviour::HangExecute,
    Misbehaviour::HangDeactivate,
    Misbehaviour::HangFinalize,
    Misbehaviour::ErrorInitialize,
    Misbehaviour::ErrorActivate,
    Misbehaviour::ErrorExecute,
    Misbehaviour::Panic,
    Misbehaviour::IgnoreDeactivate,
    Misbehaviour::SlowActivate,
];

pub(super) fn schedule(seed: Seed) -> Schedule {
    let shape = seed.stream("schedule");
    let nodes = shape.between(1, NODES.len() as u64) as usize;
    let count = shape.between(1, SYSTEMS.len() as u64) as usize;
    let quiet = Duration::from_millis(shape.between(8_000, 40_000));
    let (deeds, faults) = (shape.between(0, MOST.0), shape.between(0, MOST.1));
    let names = SYSTEMS.iter().take(count);
    let systems: Vec<SystemSpec> = names
        .map(|(name, letter)| {
            let stream = seed.stream(&format!("schedule/{name}"));
            random(&stream, name, *letter, nodes)
        })
        .collect();
    let plan = Plan {
        seed,
        nodes,
        systems: &systems,
        quiet,
    };
    Schedule {
        seed: seed.0,
        nodes,
        deeds: plan.deeds(deeds),
        faults: (0..faults).map(|n| plan.fault(n)).collect(),
        systems,
        quiet,
    }
}

struct Plan<'a> {
    seed: Seed,
    nodes: usize,
    systems: &'a [SystemSpec],
    quiet: Duration,
}

fn millis(stream: &Stream, low: u64, high: u64) -> Duration {
    Duration::from_millis(stream.between(low, high))
}

fn one_of(stream: &Stream, all: &[&str]) -> String {
    stream
        .pick(all)
        .map_or_else(String::new, |s| (*s).to_owned())
}

impl Plan<'_> {
    /// Each system is applied once, early; then come changes.
    fn deeds(&self, more: u64) -> Vec<Deed> {
        let mut deeds = Vec::new();
        for (nth, system) in self.systems.iter().enumerate() {
            let stream = self.seed.stream(&format!("schedule/first/{nth}"));
            deeds.push(Deed {
                name: format!("d{nth}"),
                at: millis(&stream, 0, 3_000),
                what: What::Apply {
                    system: system.name.clone(),
                    change: Change::None,
                },
            });
        }
        for nth in 0..more {
            let stream = self.seed.stream(&format!("schedule/deed/{nth}"));
            let at = self.time(&stream, 3_000);
            let name = format!("d{}", nth + self.systems.len() as u64);
            let what = self.deed(&stream, nth);
            deeds.push(Deed { name, at, what });
        }
        deeds.sort_by_key(|deed| deed.at);
        deeds
    }

    fn time(&self, stream: &Stream, from: u64) -> Duration {
        let until = u64::try_from(self.quiet.as_millis()).unwrap_or(u64::MAX);
        millis(stream, from, until)
    }

    fn system(&self, stream: &Stream) -> &SystemSpec {
        // There is always one.
        stream.pick(self.systems).unwrap_or(&self.systems[0])
    }

    fn instance(&self, stream: &Stream) -> String {
        let all = &self.system(stream).components;
        stream
            .pick(all)
            .map_or_else(String::new, |c| c.instance.clone())
    }

    fn node(&self, stream: &Stream) -> String {
        one_of(stream, &NODES[..self.nodes])
    }

    fn deed(&self, stream: &Stream, nth: u64) -> What {
        let system = self.system(stream);
        let change = change(stream, system, self.nodes);
        let type_name = one_of(stream, &TYPES);
        let act = self.act(stream);
        let version = u32::try_from(nth).unwrap_or(0) + 2;
        let system = system.name.clone();
        match stream.between(0, 11) {
            0..=6 => What::Apply { system, change },
            7 | 8 => What::Delete { system },
            9 => What::Module { type_name, version },
            _ => What::Act(act),
        }
    }

    fn act(&self, stream: &Stream) -> Act {
        let spec = self.system(stream);
        let connector = stream.pick(&spec.connectors).cloned();
        let instance = self.instance(stream);
        let target = self.instance(stream);
        let port = |instance: &str, port: &str| PortRef {
            instance: instance.to_owned(),
            port: port.to_owned(),
        };
        match (stream.between(0, 5), connector) {
            (0, _) => Act::Activate { instance },
            (1, _) => Act::Deactivate { instance },
            (2, _) => Act::Reset { instance },
            (3, Some(connector)) => Act::Disconnect {
                instance: connector.source.instance,
                connector: connector.name,
            },
            (4, _) => Act::Connect {
                source: port(&instance, "out"),
                target: port(&target, "in"),
                name: None,
                properties: [].into(),
            },
            _ => Act::Configure {
                instance,
                set: None,
                values: [("gain".to_owned(), "77".to_owned())].into(),
                active: None,
            },
        }
    }

    fn fault(&self, nth: u64) -> Named {
        let stream = self.seed.stream(&format!("schedule/fault/{nth}"));
        let when = if stream.chance(0.3) {
            When::Step(u32::try_from(stream.between(1, 40)).unwrap_or(1))
        } else {
            When::At(self.time(&stream, 0))
        };
        let fault = self.kind(&stream);
        Named {
            name: format!("f{nth}"),
            fault: Timed { when, fault },
        }
    }

    /// Every value is drawn, whatever the kind: the draws of one do not depend on those of another.
    fn kind(&self, stream: &Stream) -> Fault {
        let node = self.node(stream);
        let host = if stream.chance(0.5) {
            "controller".to_owned()
        } else {
            node.clone()
        };
        let calls = if stream.chance(0.3) {
            0
        } else {
            stream.between(1, 60)
        };
        let (down, lasts) = (millis(stream, 100, 12_000), millis(stream, 500, 15_000));
        let delay = millis(stream, 5, 1_500);
        let (lost, doubled) = (stream.between(0, 300), stream.between(0, 300));
        let outward = stream.chance(0.5);
        let seconds = stream.between(0, 8_000) as i64 - 4_000;
        let how = stream
            .pick(&MISBEHAVIOURS)
            .copied()
            .unwrap_or(Misbehaviour::Panic);
        let instance = self.instance(stream);
        let type_name = one_of(stream, &TYPES);
        let controller = "controller".to_owned();
        match stream.between(0, 27) {
            0..=6 => Fault::Crash {
                host,
                calls,
                down: Some(down),
            },
            7 | 8 => Fault::Reboot { node, down },
            9..=11 => {
                let (from, to) = if outward {
                    (controller, node)
                } else {
                    (node, controller)
                };
                Fault::Cut {
                    from,
                    to,
                    lasts: Some(lasts),
                }
            }
            12..=14 => Fault::Weather {
                lost: u32::try_from(lost).unwrap_or(0),
                doubled: u32::try_from(doubled).unwrap_or(0),
                delay,
                lasts,
            },
            15 | 16 => Fault::DiskFails { host, lasts },
            17 => Fault::DiskSlow { host, delay, lasts },
            18 => Fault::ClockJumps {
                host,
                by: SignedDuration::from_secs(seconds),
            },
            19 | 20 => Fault::ManagerDies {
                node,
                manager: None,
            },
            21 => Fault::ManagerHangs {
                node,
                manager: None,
            },
            22 => Fault::ManagersFailToStart { node, lasts },
            23 => Fault::ModuleFails {
                node,
                type_name,
                lasts: Some(lasts),
            },
            24..=26 => Fault::Misbehaves {
                instance,
                how,
                lasts: Some(lasts),
            },
            _ => Fault::Usurper,
        }
    }
}
