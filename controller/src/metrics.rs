//! Numbers for `/metrics`, in the Prometheus text format.

pub mod components;
pub mod connectors;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Counters of this start of the program.
#[derive(Debug, Default)]
pub struct Metrics {
    inner: Mutex<Counters>,
}

#[derive(Debug, Default)]
struct Counters {
    reconciles: u64,
    seconds: f64,
    steps: BTreeMap<(&'static str, &'static str), u64>,
}

impl Metrics {
    /// One round of the reconcile loop ended.
    pub fn reconciled(&self, took: Duration) {
        let mut inner = self.inner();
        inner.reconciles += 1;
        inner.seconds += took.as_secs_f64();
    }

    /// A step ended: kind, and `succeeded`, `failed` or `skipped`.
    pub fn step(&self, kind: &'static str, result: &'static str) {
        *self.inner().steps.entry((kind, result)).or_default() += 1;
    }

    /// Rounds of the reconcile loop so far.
    pub fn reconciles(&self) -> u64 {
        self.inner().reconciles
    }

    /// The page. `gauges` are name, help, and label text → value.
    pub fn page(&self, gauges: &[Gauge]) -> String {
        let mut out = String::new();
        for gauge in gauges {
            family(&mut out, gauge.name, gauge.help, "gauge");
            for (labels, value) in &gauge.values {
                let _ = writeln!(out, "{}{labels} {value}", gauge.name);
            }
        }
        let inner = self.inner();
        let name = "rtsctl_reconcile_duration_seconds";
        family(
            &mut out,
            name,
            "Time of a round of the reconcile loop.",
            "summary",
        );
        let _ = writeln!(out, "{name}_sum {}", inner.seconds);
        let _ = writeln!(out, "{name}_count {}", inner.reconciles);
        let name = "rtsctl_steps_total";
        family(&mut out, name, "Steps by kind and result.", "counter");
        for ((kind, result), count) in &inner.steps {
            let _ = writeln!(out, "{name}{{kind=\"{kind}\",result=\"{result}\"}} {count}");
        }
        out
    }

    fn inner(&self) -> MutexGuard<'_, Counters> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A number that is counted when the page is asked for.
#[derive(Debug)]
pub struct Gauge {
    /// Name.
    pub name: &'static str,
    /// One line.
    pub help: &'static str,
    /// Labels (`{state="Ready"}`) → value.
    pub values: BTreeMap<String, usize>,
}

impl Gauge {
    /// A number per state.
    pub fn by_state(
        name: &'static str,
        help: &'static str,
        states: impl IntoIterator<Item = String>,
    ) -> Self {
        let mut values = BTreeMap::new();
        for state in states {
            let state: String = state.chars().filter(char::is_ascii_alphanumeric).collect();
            *values.entry(format!("{{state=\"{state}\"}}")).or_default() += 1;
        }
        Self { name, help, values }
    }
}

/// Text as it stands in a label.
fn escaped(text: &str) -> String {
    text.replace('\\', r"\\")
        .replace('"', "\\\"")
        .replace('\n', r"\n")
}

fn family(out: &mut String, name: &str, help: &str, kind: &str) {
    let _ = writeln!(out, "# HELP {name} {help}\n# TYPE {name} {kind}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_prometheus_text() {
        let metrics = Metrics::default();
        metrics.reconciled(Duration::from_millis(250));
        metrics.step("Create", "succeeded");
        let states = ["Ready", "Ready", "Unknown"].map(str::to_owned);
        let gauge = Gauge::by_state("rtsctl_nodes", "Nodes by state.", states);
        insta::assert_snapshot!(metrics.page(&[gauge]), @r#"
        # HELP rtsctl_nodes Nodes by state.
        # TYPE rtsctl_nodes gauge
        rtsctl_nodes{state="Ready"} 2
        rtsctl_nodes{state="Unknown"} 1
        # HELP rtsctl_reconcile_duration_seconds Time of a round of the reconcile loop.
        # TYPE rtsctl_reconcile_duration_seconds summary
        rtsctl_reconcile_duration_seconds_sum 0.25
        rtsctl_reconcile_duration_seconds_count 1
        # HELP rtsctl_steps_total Steps by kind and result.
        # TYPE rtsctl_steps_total counter
        rtsctl_steps_total{kind="Create",result="succeeded"} 1
        "#);
    }
}
