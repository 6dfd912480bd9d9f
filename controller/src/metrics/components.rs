//! How execution contexts keep their time. Their counters begin with each component that is made.

use std::fmt::Write;

use rts_controller_api::objects::Component;
use rts_plan::observed::{DurationsObserved, TimingObserved};

use super::{escaped, family};

/// Label and value of a quantile.
type Quantile = (&'static str, fn(&DurationsObserved) -> u64);

const QUANTILES: [Quantile; 3] = [
    ("0.5", |durations| durations.median),
    ("0.99", |durations| durations.p99),
    ("1", |durations| durations.max),
];

/// Name, help and the durations of a gauge.
type Durations = (
    &'static str,
    &'static str,
    fn(&TimingObserved) -> Option<&DurationsObserved>,
);

const DURATIONS: [Durations; 2] = [
    (
        "rtsctl_component_execution_seconds",
        "How long cycles took.",
        |timing| Some(&timing.execution),
    ),
    (
        "rtsctl_component_jitter_seconds",
        "How late cycles of a periodic execution context began.",
        |timing| timing.jitter.as_ref(),
    ),
];

/// The families of all components that have run.
pub fn families(components: &[Component]) -> String {
    let mut out = String::new();
    let timed = components.iter().filter_map(|component| {
        let timing = component.status.timing.as_ref()?;
        Some((component, labels(component), timing))
    });
    let timed: Vec<_> = timed.collect();
    if timed.is_empty() {
        return out;
    }
    let name = "rtsctl_component_executions_total";
    family(&mut out, name, "Calls of on_execute.", "counter");
    for (component, labels, _) in &timed {
        let _ = writeln!(out, "{name}{{{labels}}} {}", component.status.executions);
    }
    let name = "rtsctl_component_overruns_total";
    let help = "Cycles that were not over when the next was due.";
    family(&mut out, name, help, "counter");
    for (_, labels, timing) in &timed {
        let _ = writeln!(out, "{name}{{{labels}}} {}", timing.overruns);
    }
    for (name, help, of) in DURATIONS {
        family(&mut out, name, help, "gauge");
        for (_, labels, timing) in &timed {
            let Some(durations) = of(timing) else {
                continue;
            };
            for (quantile, value) in QUANTILES {
                let seconds = value(durations) as f64 / 1e9;
                let _ = writeln!(out, "{name}{{{labels},quantile=\"{quantile}\"}} {seconds}");
            }
        }
    }
    out
}

fn labels(component: &Component) -> String {
    format!(
        "system=\"{}\",component=\"{}\",node=\"{}\"",
        escaped(&component.spec.system),
        escaped(&component.metadata.name),
        escaped(&component.status.node)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rts_controller_api::objects::{ComponentStatus, ComponentView, Kind, Metadata};

    #[test]
    fn each_component_that_has_run_has_its_times() {
        let durations = |median: u64| serde_json::json!({"count": 4, "median": median, "p99": 2 * median, "max": 3 * median, "buckets": []});
        let component = |name: &str, timing: serde_json::Value| Component {
            api_version: String::new(),
            kind: Kind::Component,
            metadata: Metadata {
                name: name.to_owned(),
                ..Metadata::default()
            },
            spec: ComponentView {
                system: "hello".to_owned(),
                ..ComponentView::default()
            },
            status: ComponentStatus {
                node: "local".to_owned(),
                executions: 7,
                timing: serde_json::from_value(timing).unwrap(),
                ..ComponentStatus::default()
            },
        };
        let periodic = serde_json::json!({"overruns": 2, "execution": durations(1_000), "jitter": durations(50_000)});
        let event_driven = serde_json::json!({"overruns": 0, "execution": durations(300)});
        let all = [
            component("a", periodic),
            component("b", event_driven),
            component("c", serde_json::Value::Null),
        ];
        assert_eq!(families(&all[2..]), "");
        insta::assert_snapshot!(families(&all));
    }
}
