//! Minimum, median and 95th percentile of a row, as table and as JSON.

use std::time::Duration;

use anyhow::Result;
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
    /// Components of a run.
    pub components: u32,
    /// Median of whole runs, milliseconds.
    pub median_ms: f64,
}

/// Something that is measured in turns with others.
pub trait Turn {
    /// Names of the rows that it gives, and the components of a run.
    fn rows(&self) -> (&[String], u32);
    /// One run: a time for each row.
    fn run(&mut self) -> Result<Vec<Duration>>;
}

/// Lets all take turns, so that what else the machine does hits them alike. The first round is not counted.
pub fn take_turns(all: &mut [impl Turn], runs: u32) -> Result<Vec<Row>> {
    let rows = all.iter().map(|turn| vec![Vec::new(); turn.rows().0.len()]);
    let mut times: Vec<Vec<Vec<Duration>>> = rows.collect();
    for run in 0..=runs {
        for (turn, times) in all.iter_mut().zip(&mut times) {
            let took = turn.run()?;
            if run > 0 {
                let rows = times.iter_mut().zip(took);
                rows.for_each(|(row, time)| row.push(time));
            }
        }
    }
    let rows = all.iter().zip(times).flat_map(|(turn, times)| {
        let (names, components) = turn.rows();
        let rows = names.iter().zip(times);
        rows.map(move |(name, runs)| Row::new(name, components, runs))
    });
    Ok(rows.collect())
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
            components,
            median_ms: at(0.5) * f64::from(components),
        }
    }
}

/// Prints rows as a table, or as `{"rows": […]}`.
pub fn print(rows: &[Row], json: bool) -> Result<()> {
    if json {
        println!(
            "{}",
            serde_json::to_string_pretty(&serde_json::json!({ "rows": rows }))?
        );
        return Ok(());
    }
    // Of rows of one component each, the whole is the same.
    let whole = rows.iter().any(|row| row.components > 1);
    let last = |text: String| if whole { text } else { String::new() };
    let width = rows.iter().map(|row| row.row.len()).fold(26, usize::max);
    println!(
        "{:<width$} {:>5} {:>10} {:>10} {:>10}{}   (ms per component{})",
        "ROW",
        "RUNS",
        "MIN",
        "MEDIAN",
        "P95",
        last(format!(" {:>10}", "WHOLE")),
        last(", and median of the whole run".to_owned()),
    );
    for row in rows {
        println!(
            "{:<width$} {:>5} {:>10.3} {:>10.3} {:>10.3}{}",
            row.row,
            row.n,
            row.min,
            row.median_ms_per_component,
            row.p95,
            last(format!(" {:>10.2}", row.median_ms)),
        );
    }
    Ok(())
}
