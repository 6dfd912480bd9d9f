//! Minimum, median and 95th percentile of a row, as table and as JSON.

use std::time::Duration;

use serde::Serialize;

/// One row of a benchmark.
#[derive(Debug, Serialize)]
pub struct Row {
    /// Name of the row.
    pub row: String,
    /// Number of runs.
    pub n: usize,
    /// Median, milliseconds per component.
    pub median_ms_per_component: f64,
    /// Minimum, milliseconds per component.
    pub min: f64,
    /// 95th percentile, milliseconds per component.
    pub p95: f64,
}

impl Row {
    /// A row from the times of whole runs, each of which launched `components`. `runs` is not empty.
    pub fn new(name: &str, components: u32, mut runs: Vec<Duration>) -> Self {
        runs.sort();
        let per_component = |run: Duration| run.as_secs_f64() * 1e3 / f64::from(components);
        let at =
            |share: f64| per_component(runs[((runs.len() - 1) as f64 * share).round() as usize]);
        Self {
            row: name.to_owned(),
            n: runs.len(),
            median_ms_per_component: at(0.5),
            min: at(0.0),
            p95: at(0.95),
        }
    }
}

/// Prints rows as a table, or as `{"rows": […]}`.
pub fn print(rows: &[Row], json: bool) -> anyhow::Result<()> {
    if json {
        println!(
            "{}",
            serde_json::to_string_pretty(&serde_json::json!({ "rows": rows }))?
        );
        return Ok(());
    }
    println!(
        "{:<26} {:>5} {:>10} {:>10} {:>10}   (ms per component)",
        "ROW", "RUNS", "MIN", "MEDIAN", "P95"
    );
    for row in rows {
        println!(
            "{:<26} {:>5} {:>10.3} {:>10.3} {:>10.3}",
            row.row, row.n, row.min, row.median_ms_per_component, row.p95
        );
    }
    Ok(())
}
