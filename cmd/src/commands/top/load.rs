//! What happened between two looks, per second.

use std::collections::{BTreeMap, BTreeSet};

use rts_controller_api::API_VERSION;
use rts_controller_api::objects::{Component, Connector, Manager};
use serde::Serialize;

use super::look::{Look, Seen};
use crate::commands::get::there_are;
use crate::error::CliError;

/// All that is shown. What is not known is null.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Load {
    /// [`API_VERSION`](rts_controller_api::API_VERSION).
    pub api_version: &'static str,
    /// `Top`.
    pub kind: &'static str,
    /// Seconds between the two looks.
    pub seconds: f64,
    /// Components, by name and node.
    pub components: Vec<ComponentLoad>,
    /// Connectors, by name and system.
    pub connectors: Vec<ConnectorLoad>,
    /// Manager processes, by name and node.
    pub managers: Vec<ManagerLoad>,
}

/// How fast a component runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ComponentLoad {
    /// Instance name.
    pub name: String,
    /// Node.
    pub node: String,
    /// System; empty without one.
    pub system: String,
    /// State.
    pub state: String,
    /// Rate that is configured, in Hz.
    #[serde(rename = "wantedHz")]
    pub wanted: Option<f64>,
    /// Cycles per second.
    #[serde(rename = "reachedHz")]
    pub reached: Option<f64>,
    /// Cycles per second that were not over when the next was due.
    #[serde(rename = "overrunsPerSecond")]
    pub overruns: Option<f64>,
    /// Half of the cycles took no longer, in nanoseconds.
    pub execution_ns: Option<u64>,
    /// 99 of 100 cycles took no longer.
    pub execution_p99_ns: Option<u64>,
    /// 99 of 100 cycles began no later.
    pub jitter_p99_ns: Option<u64>,
}

/// What goes over a connector.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ConnectorLoad {
    /// Name.
    pub name: String,
    /// System; empty without one.
    pub system: String,
    /// State.
    pub state: String,
    /// Samples sent per second.
    #[serde(rename = "samplesPerSecond")]
    pub samples: Option<f64>,
    /// Payload bytes sent per second.
    #[serde(rename = "bytesPerSecond")]
    pub bytes: Option<f64>,
    /// Samples dropped per second.
    #[serde(rename = "dropsPerSecond")]
    pub drops: Option<f64>,
    /// Jumps in the sequence per second.
    #[serde(rename = "gapsPerSecond")]
    pub gaps: Option<f64>,
    /// Half of the samples took no longer, in nanoseconds.
    pub median_ns: Option<u64>,
    /// 99 of 100 samples took no longer.
    pub p99_ns: Option<u64>,
    /// Transport.
    pub transport: String,
}

/// What a manager process uses.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ManagerLoad {
    /// Name.
    pub name: String,
    /// Node.
    pub node: String,
    /// System; empty without one.
    pub system: String,
    /// State.
    pub state: String,
    /// Process id.
    pub pid: u32,
    /// Processors that it keeps busy.
    pub cpu: Option<f64>,
    /// Resident memory in bytes.
    #[serde(rename = "memoryBytes")]
    pub memory: Option<u64>,
    /// Number of components.
    pub components: usize,
    /// Number of its ports that are looked at or written to.
    pub taps: usize,
}

/// What is wanted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Filter<'a> {
    /// Only what is on this node.
    pub node: Option<&'a str>,
    /// Only what belongs to this system.
    pub system: Option<&'a str>,
}

impl Filter<'_> {
    /// A name that nobody has is a slip of the pen.
    pub fn check(&self, look: &Look) -> Result<(), CliError> {
        let components = &look.components.items;
        let nodes: BTreeSet<&str> = components.iter().map(|c| c.status.node.as_str()).collect();
        let systems: BTreeSet<&str> = components.iter().map(|c| c.spec.system.as_str()).collect();
        for (kind, wanted, known) in [("node", self.node, nodes), ("system", self.system, systems)]
        {
            let known: Vec<&str> = known.into_iter().filter(|name| !name.is_empty()).collect();
            if let Some(wanted) = wanted.filter(|wanted| !known.contains(wanted)) {
                return Err(CliError::usage_help(
                    format!("{kind}/{wanted} has no components"),
                    there_are(&known),
                ));
            }
        }
        Ok(())
    }

    fn takes(&self, node: &str, system: &str) -> bool {
        self.node.is_none_or(|wanted| wanted == node)
            && self.system.is_none_or(|wanted| wanted == system)
    }
}

/// How a counter rose, per second. None without a time, and when it went back: it is another one by now.
pub fn rate(before: u64, now: u64, seconds: f64) -> Option<f64> {
    let risen = now.checked_sub(before)?;
    (seconds > 0.0).then(|| risen as f64 / seconds)
}

/// The same for several counters of one thing: all of them began anew when one of them went back.
fn rates<const N: usize>(before: [u64; N], now: [u64; N], seconds: f64) -> [Option<f64>; N] {
    let mut rates = [None; N];
    for (at, (before, now)) in before.into_iter().zip(now).enumerate() {
        match rate(before, now, seconds) {
            None => return [None; N],
            known => rates[at] = known,
        }
    }
    rates
}

/// What happened between two looks.
pub fn load(before: &Look, now: &Look, filter: &Filter<'_>) -> Load {
    Load {
        api_version: API_VERSION,
        kind: "Top",
        seconds: seconds(&before.components, &now.components),
        components: components(&before.components, &now.components, filter),
        connectors: connectors(before, now, filter),
        managers: managers(&before.managers, &now.managers, filter),
    }
}

fn seconds<T>(before: &Seen<T>, now: &Seen<T>) -> f64 {
    now.at.saturating_duration_since(before.at).as_secs_f64()
}

fn components(
    before: &Seen<Component>,
    now: &Seen<Component>,
    filter: &Filter<'_>,
) -> Vec<ComponentLoad> {
    let seconds = seconds(before, now);
    // Another incarnation counts from 0.
    let earlier: BTreeMap<_, _> = before
        .items
        .iter()
        .map(|c| (c.status.incarnation.as_str(), c))
        .collect();
    let counters = |c: &Component| {
        let overruns = c.status.timing.as_ref().map_or(0, |t| t.overruns);
        [c.status.executions, overruns]
    };
    let wanted = now.items.iter();
    let wanted = wanted.filter(|c| filter.takes(&c.status.node, &c.spec.system));
    wanted
        .map(|c| {
            let status = &c.status;
            let known = (!status.incarnation.is_empty() && status.state != "Unknown").then_some(c);
            let former = known.and_then(|c| earlier.get(c.status.incarnation.as_str()));
            let [reached, overruns] = former.map_or([None; 2], |former| {
                rates(counters(former), counters(c), seconds)
            });
            let timing = status.timing.as_ref();
            let jitter = timing.and_then(|timing| timing.jitter.as_ref());
            ComponentLoad {
                name: c.metadata.name.clone(),
                node: status.node.clone(),
                system: c.spec.system.clone(),
                state: status.state.clone(),
                wanted: status.rate,
                reached,
                overruns,
                execution_ns: timing.map(|timing| timing.execution.median),
                execution_p99_ns: timing.map(|timing| timing.execution.p99),
                jitter_p99_ns: jitter.map(|jitter| jitter.p99),
            }
        })
        .collect()
}

fn connectors(before: &Look, now: &Look, filter: &Filter<'_>) -> Vec<ConnectorLoad> {
    let seconds = seconds(&before.connectors, &now.connectors);
    let key = |c: &Connector| (c.metadata.name.clone(), c.spec.system.clone());
    let earlier: BTreeMap<_, _> = before
        .connectors
        .items
        .iter()
        .map(|c| (key(c), c))
        .collect();
    let counters = |c: &Connector| {
        let status = &c.status;
        let received = status.samples_received;
        [
            status.samples_sent,
            status.bytes,
            status.drops,
            status.gaps,
            received,
        ]
    };
    let wanted = now.connectors.items.iter();
    let wanted = wanted.filter(|c| {
        let own = filter.system.is_none_or(|system| c.spec.system == system);
        own && filter
            .node
            .is_none_or(|node| is_on(c, node, &now.components.items))
    });
    wanted
        .map(|c| {
            let status = &c.status;
            let former = earlier.get(&key(c));
            let [samples, bytes, drops, gaps, _] = former.map_or([None; 5], |former| {
                rates(counters(former), counters(c), seconds)
            });
            ConnectorLoad {
                name: c.metadata.name.clone(),
                system: c.spec.system.clone(),
                state: status.state.clone(),
                samples,
                bytes,
                drops,
                gaps,
                median_ns: status.latency.map(|latency| latency.median_ns),
                p99_ns: status.latency.map(|latency| latency.p99_ns),
                transport: status.transport.clone(),
            }
        })
        .collect()
}

/// True when one of its ends is on that node.
fn is_on(connector: &Connector, node: &str, components: &[Component]) -> bool {
    let of = |end: &str, c: &Component| {
        let rest = end.strip_prefix(c.metadata.name.as_str());
        rest.is_some_and(|rest| rest.starts_with('.'))
    };
    let spec = &connector.spec;
    let there = components.iter().filter(|c| c.status.node == node);
    let mut own = there.filter(|c| c.spec.system == spec.system);
    own.any(|c| of(&spec.source, c) || of(&spec.target, c))
}

fn managers(before: &Seen<Manager>, now: &Seen<Manager>, filter: &Filter<'_>) -> Vec<ManagerLoad> {
    let seconds = seconds(before, now);
    let earlier: BTreeMap<_, _> = before
        .items
        .iter()
        .map(|m| (m.status.incarnation.as_str(), m))
        .collect();
    let wanted = now.items.iter();
    let wanted = wanted.filter(|m| filter.takes(&m.status.node, &m.spec.system));
    wanted
        .map(|m| {
            let status = &m.status;
            let usage = status.activity.usage;
            let former = earlier.get(status.incarnation.as_str());
            let former = former.and_then(|former| former.status.activity.usage);
            let cpu = former.zip(usage).and_then(|(former, usage)| {
                let milliseconds = rate(former.cpu_ms, usage.cpu_ms, seconds)?;
                Some(milliseconds / 1000.0)
            });
            ManagerLoad {
                name: m.metadata.name.clone(),
                node: status.node.clone(),
                system: m.spec.system.clone(),
                state: status.state.clone(),
                pid: status.pid,
                cpu,
                memory: usage.map(|usage| usage.memory),
                components: status.components.len(),
                taps: status.activity.taps.len(),
            }
        })
        .collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::show::{lists::typed, samples};
    use proptest::prelude::*;
    use rts_controller_api::objects::Kind;
    use std::time::{Duration, Instant};

    fn look(at: Instant) -> Look {
        fn of<T: serde::de::DeserializeOwned>(kind: Kind, at: Instant) -> Seen<T> {
            Seen {
                at,
                items: typed(kind, &samples::values(kind)).unwrap(),
            }
        }
        let mut components: Seen<Component> = of(Kind::Component, at);
        for (number, component) in components.items.iter_mut().enumerate() {
            component.status.incarnation = format!("i{number}");
        }
        Look {
            components,
            connectors: of(Kind::Connector, at),
            managers: of(Kind::Manager, at),
        }
    }

    /// Two looks, 2 s apart.
    pub fn looks() -> (Look, Look) {
        let at = Instant::now();
        let (before, mut now) = (look(at), look(at + Duration::from_secs(2)));
        now.components.items[0].status.executions += 199;
        let status = &mut now.connectors.items[0].status;
        status.samples_sent += 200;
        status.samples_received += 199;
        status.bytes += 3200;
        status.drops += 1;
        let usage = now.managers.items[0]
            .status
            .activity
            .usage
            .as_mut()
            .unwrap();
        usage.cpu_ms += 500;
        (before, now)
    }

    #[test]
    fn rates_are_those_between_two_looks() {
        let (before, now) = looks();
        let load = load(&before, &now, &Filter::default());
        assert_eq!(load.seconds, 2.0);
        assert_eq!(load.components[0].reached, Some(99.5));
        assert_eq!(load.components[1].reached, Some(0.0));
        let connector = &load.connectors[0];
        assert_eq!(
            (
                connector.samples,
                connector.bytes,
                connector.drops,
                connector.gaps
            ),
            (Some(100.0), Some(1600.0), Some(0.5), Some(0.0))
        );
        assert_eq!(load.managers[0].cpu, Some(0.25));
    }

    #[test]
    fn what_began_anew_has_no_rate_yet() {
        let (before, mut now) = looks();
        // The same count, of another incarnation; a connection with fewer bytes; another process.
        now.components.items[0].status.incarnation = "other".to_owned();
        now.connectors.items[0].status.bytes = 16;
        now.managers.items[0].status.incarnation = "other".to_owned();
        let load = load(&before, &now, &Filter::default());
        assert_eq!(load.components[0].reached, None);
        assert_eq!(load.connectors[0].samples, None);
        assert_eq!(load.managers[0].cpu, None);
        assert!(load.managers[0].memory.is_some());
    }

    #[test]
    fn only_what_is_wanted_is_shown() {
        let (before, now) = looks();
        let names = |node, system| {
            let load = load(&before, &now, &Filter { node, system });
            let components = load.components.into_iter().map(|c| c.name);
            let connectors = load.connectors.into_iter().map(|c| c.name);
            components.chain(connectors).collect::<Vec<_>>()
        };
        assert_eq!(names(Some("local"), None).len(), 4);
        assert!(names(Some("arm"), None).is_empty());
        assert_eq!(
            names(None, Some("hello")),
            ["Sine0", "Printer0", "Sine0.out-Filter0.in"]
        );
        let filter = Filter {
            system: Some("helo"),
            ..Filter::default()
        };
        let error = filter.check(&now).unwrap_err();
        assert_eq!(error.line(), "system/helo has no components");
        assert_eq!(error.help().unwrap(), "there are: hello");
    }

    proptest! {
        /// Whatever the counters do, nothing is shown that did not happen.
        #[test]
        fn a_rate_is_what_happened_or_is_not_known(
            before: u64, now: u64, seconds in prop_oneof![Just(0.0), 0.001..1e6],
        ) {
            match rate(before, now, seconds) {
                Some(rate) => {
                    prop_assert!(now >= before && seconds > 0.0 && rate.is_finite());
                    let risen = (now - before) as f64;
                    prop_assert!((rate * seconds - risen).abs() <= risen * 1e-9);
                }
                None => prop_assert!(now < before || seconds == 0.0),
            }
        }
    }
}
