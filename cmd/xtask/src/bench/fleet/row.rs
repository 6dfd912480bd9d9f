//! A row of the table of fleets.

use std::time::Duration;

use serde::Serialize;

use crate::bench::process::Memory;

/// One run of an action.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Until the command returned.
    pub took: Duration,
    /// Processor time of the controller meanwhile.
    pub cpu: Duration,
    /// Memory of the controller afterwards.
    pub memory: Memory,
}

/// An action on a fleet.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// `fleet-NODES-COMPONENTS-ACTION`.
    pub row: String,
    /// Runs.
    pub n: usize,
    /// Nodes.
    pub nodes: u32,
    /// Components.
    pub components: u32,
    /// What was done.
    pub action: String,
    /// Median, milliseconds per component.
    pub median_ms_per_component: f64,
    /// Minimum, milliseconds per component.
    pub min: f64,
    /// 95th percentile, milliseconds per component.
    pub p95: f64,
    /// Median of the whole, milliseconds.
    pub median_ms: f64,
    /// Processor time of the controller, median, seconds.
    pub controller_cpu_s: f64,
    /// Memory of the controller afterwards, most of the runs, bytes.
    pub controller_pss_bytes: u64,
    /// The same resident, shared or not.
    pub controller_rss_bytes: u64,
}

impl Row {
    /// Of these runs.
    pub fn new(nodes: u32, components: u32, action: &str, samples: Vec<Sample>) -> Self {
        let sorted = |of: fn(&Sample) -> Duration| {
            let mut all: Vec<f64> = samples.iter().map(|s| of(s).as_secs_f64()).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let at = |all: &[f64], share: f64| {
            let last = all.len().saturating_sub(1) as f64;
            let place = (last * share).round() as usize;
            all.get(place).copied().unwrap_or(f64::NAN)
        };
        let (took, cpu) = (sorted(|s| s.took), sorted(|s| s.cpu));
        let each = |seconds: f64| seconds * 1e3 / f64::from(components);
        let most = |of: fn(&Memory) -> u64| samples.iter().map(|s| of(&s.memory)).max();
        Self {
            row: format!("fleet-{nodes}-{components}-{action}"),
            n: samples.len(),
            nodes,
            components,
            action: action.to_owned(),
            median_ms_per_component: each(at(&took, 0.5)),
            min: each(at(&took, 0.0)),
            p95: each(at(&took, 0.95)),
            median_ms: at(&took, 0.5) * 1e3,
            controller_cpu_s: at(&cpu, 0.5),
            controller_pss_bytes: most(|m| m.pss).unwrap_or_default(),
            controller_rss_bytes: most(|m| m.rss).unwrap_or_default(),
        }
    }
}

/// Prints rows as a table.
pub fn print(rows: &[Row]) {
    println!(
        "{:>6} {:>10} {:<11} {:>4} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9} {:>9}",
        "NODES",
        "COMPONENTS",
        "ACTION",
        "RUNS",
        "MIN MS",
        "MEDIAN MS",
        "P95 MS",
        "MS/COMP",
        "CPU MS",
        "CPU/COMP",
        "PSS MB"
    );
    for row in rows {
        let whole = |each: f64| each * f64::from(row.components);
        let cpu = row.controller_cpu_s * 1e3;
        println!(
            "{:>6} {:>10} {:<11} {:>4} {:>10.1} {:>10.1} {:>10.1} {:>10.3} {:>10.1} {:>9.3} {:>9.1}",
            row.nodes,
            row.components,
            row.action,
            row.n,
            whole(row.min),
            row.median_ms,
            whole(row.p95),
            row.median_ms_per_component,
            cpu,
            cpu / f64::from(row.components),
            row.controller_pss_bytes as f64 / 1e6
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_what_a_component_costs() {
        let sample = |ms| Sample {
            took: Duration::from_millis(ms),
            cpu: Duration::from_millis(ms / 2),
            memory: Memory {
                pss: ms,
                rss: 2 * ms,
            },
        };
        let row = Row::new(
            10,
            100,
            "apply",
            vec![sample(300), sample(100), sample(200)],
        );
        assert_eq!(row.row, "fleet-10-100-apply");
        assert_eq!(
            (row.min, row.median_ms_per_component, row.p95),
            (1.0, 2.0, 3.0)
        );
        assert_eq!((row.controller_cpu_s, row.controller_pss_bytes), (0.1, 300));
    }
}
