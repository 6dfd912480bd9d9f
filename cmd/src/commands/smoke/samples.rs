//! Every data connector carries samples: its receiver reads them through its in-port, each with a higher number than the
//! one before.

use std::collections::BTreeMap;

use rts_controller_api::objects::Connector;
use rts_schemas::system::PortKind;

use super::context::{Context, PAUSE};
use super::failure::{Failure, Verdict};
use super::snapshot::{Snapshot, instance};
use crate::local::plural;

/// Least number of samples that a connector must carry.
const LEAST: u64 = 3;
/// Most connectors that a message names.
const NAMED: usize = 5;

/// What was received on each connector at the first look.
#[derive(Debug, Default)]
pub struct Flow {
    first: BTreeMap<String, u64>,
}

impl Flow {
    /// Connectors that do not carry samples yet, of those that must.
    fn lacking<'s>(&mut self, snapshot: &'s Snapshot) -> Vec<&'s Connector> {
        let must = snapshot.connectors.iter().filter(|c| expected(snapshot, c));
        must.filter(|connector| !self.carries(connector)).collect()
    }

    fn carries(&mut self, connector: &Connector) -> bool {
        let name = &connector.metadata.name;
        let received = connector.status.samples_received;
        let first = *self.first.entry(name.clone()).or_insert(received);
        connector.status.state == "Connected"
            && received >= LEAST
            && received > first
            && received <= connector.status.samples_sent
    }
}

/// Waits until they do.
pub async fn check(context: &mut Context<'_>) -> Verdict {
    let count = flows(context, Flow::default()).await?;
    let undetermined = context.last.connectors.iter();
    let undetermined = undetermined.filter(|c| c.status.undetermined).count();
    let not_made = match undetermined {
        0 => String::new(),
        count => format!("; not made, as their ports are undetermined: {count}"),
    };
    Ok(match count {
        0 => format!("there is no data connector{not_made}"),
        1 => format!("1 data connector carries samples{not_made}"),
        count => format!("{count} data connectors carry samples{not_made}"),
    })
}

/// Waits until all data connectors carry samples; gives their number.
pub async fn flows(context: &mut Context<'_>, mut flow: Flow) -> Result<usize, Failure> {
    loop {
        context.well().await?;
        let late = context.late();
        let snapshot = context.look().await?;
        let lacking = flow.lacking(snapshot);
        if lacking.is_empty() {
            let must = snapshot.connectors.iter().filter(|c| expected(snapshot, c));
            return Ok(must.count());
        }
        if late {
            return Err(silent(&lacking));
        }
        tokio::time::sleep(PAUSE).await;
    }
}

/// A data connector between components that both run, or must.
fn expected(snapshot: &Snapshot, connector: &Connector) -> bool {
    let runs = |end: &str| {
        let component = snapshot.component(instance(end));
        component.is_some_and(|c| c.spec.required || c.status.state == "Active")
    };
    let ConnectorEnds { source, target } = ends(connector);
    let made = connector.spec.kind == PortKind::Data && !connector.status.undetermined;
    made && runs(source) && runs(target)
}

struct ConnectorEnds<'a> {
    source: &'a str,
    target: &'a str,
}

fn ends(connector: &Connector) -> ConnectorEnds<'_> {
    ConnectorEnds {
        source: &connector.spec.source,
        target: &connector.spec.target,
    }
}

/// Which connectors are silent, and how far their samples come.
fn silent(lacking: &[&Connector]) -> Failure {
    let count = plural("data connector", lacking.len());
    let names = lacking.iter().take(NAMED).map(|c| c.metadata.name.as_str());
    let names: Vec<_> = names.collect();
    let more = if lacking.len() > NAMED { ", …" } else { "" };
    let mut failure = Failure::late(format!(
        "without samples in time: {count}: {}{more}",
        names.join(", ")
    ));
    for connector in lacking {
        let status = &connector.status;
        let waits = status.waiting_on.as_deref().unwrap_or_default();
        let line = format!(
            "connector/{}: {}, {} sent, {} received {waits}",
            connector.metadata.name, status.state, status.samples_sent, status.samples_received
        );
        failure.details.push(line.trim_end().to_owned());
        // Who sends nothing, or who does not read it.
        let ConnectorEnds { source, target } = ends(connector);
        let end = if status.samples_sent == 0 {
            source
        } else {
            target
        };
        failure = failure.of([instance(end).to_owned()]);
    }
    failure
}
