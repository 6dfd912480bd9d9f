//! Numbers of connectors. Their counters begin with each connection.

use std::fmt::Write;

use rts_controller_api::objects::{Connector, ConnectorStatus};
use rts_plan::observed::Latency;
use rts_schemas::system::PortKind;

use super::{escaped, family};

/// Name, help and value of a counter.
type Counter = (&'static str, &'static str, fn(&ConnectorStatus) -> u64);

const COUNTERS: [Counter; 5] = [
    (
        "rtsctl_connector_samples_sent_total",
        "Samples written to a connector.",
        |status| status.samples_sent,
    ),
    (
        "rtsctl_connector_samples_received_total",
        "Samples read at the in-port.",
        |status| status.samples_received,
    ),
    (
        "rtsctl_connector_sent_bytes_total",
        "Payload written to a connector.",
        |status| status.bytes,
    ),
    (
        "rtsctl_connector_drops_total",
        "Samples that found no room at one of the ends.",
        |status| status.drops,
    ),
    (
        "rtsctl_connector_gaps_total",
        "Jumps in the sequence that the reader saw.",
        |status| status.gaps,
    ),
];

/// Label and value of a quantile of the latency.
type Quantile = (&'static str, fn(&Latency) -> u64);

const QUANTILES: [Quantile; 2] = [
    ("0.5", |latency| latency.median_ns),
    ("0.99", |latency| latency.p99_ns),
];

/// The families of all data connectors.
pub fn families(connectors: &[Connector]) -> String {
    let data = |connector: &&Connector| connector.spec.kind == PortKind::Data;
    let connectors: Vec<&Connector> = connectors.iter().filter(data).collect();
    let mut out = String::new();
    if connectors.is_empty() {
        return out;
    }
    for (name, help, value) in COUNTERS {
        family(&mut out, name, help, "counter");
        for connector in &connectors {
            let (labels, value) = (labels(connector), value(&connector.status));
            let _ = writeln!(out, "{name}{{{labels}}} {value}");
        }
    }
    let name = "rtsctl_connector_latency_seconds";
    let help = "Time from the write to the read of samples, over the whole connection.";
    family(&mut out, name, help, "gauge");
    for connector in connectors {
        let Some(latency) = &connector.status.latency else {
            continue;
        };
        let labels = labels(connector);
        for (quantile, value) in QUANTILES {
            let seconds = value(latency) as f64 / 1e9;
            let _ = writeln!(out, "{name}{{{labels},quantile=\"{quantile}\"}} {seconds}");
        }
    }
    out
}

fn labels(connector: &Connector) -> String {
    format!(
        "system=\"{}\",connector=\"{}\"",
        escaped(&connector.spec.system),
        escaped(&connector.metadata.name)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rts_controller_api::objects::{ConnectorView, Kind, Metadata};

    #[test]
    fn each_connector_has_its_counters_and_its_latency() {
        let connector = |name: &str, latency| Connector {
            api_version: String::new(),
            kind: Kind::Connector,
            metadata: Metadata {
                name: name.to_owned(),
                ..Metadata::default()
            },
            spec: ConnectorView {
                system: "hello".to_owned(),
                kind: PortKind::Data,
                source: String::new(),
                target: String::new(),
                data_type: None,
                properties: Default::default(),
            },
            status: ConnectorStatus {
                samples_sent: 5,
                samples_received: 3,
                bytes: 80,
                drops: 2,
                gaps: 1,
                latency,
                ..ConnectorStatus::default()
            },
        };
        let latency = Latency {
            count: 3,
            min_ns: 900,
            median_ns: 1_023,
            p99_ns: 2_047,
            max_ns: 2_000_000,
        };
        let all = [connector("a\"b", Some(latency)), connector("c", None)];
        assert_eq!(families(&[]), "");
        insta::assert_snapshot!(families(&all));
    }
}
