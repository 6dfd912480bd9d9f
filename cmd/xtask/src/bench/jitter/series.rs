//! One series: the component is deployed with an overlay, runs, and is asked.

use std::thread::sleep;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::RATE;
use crate::bench::stack::Stack;

/// Name of the component.
const NAME: &str = "Tick0";
/// Type of the component: a sine a cycle, which no port sends to anyone.
const TYPE: &str = "SineSource";

/// How a series went.
pub enum Measured {
    /// Its times.
    Timing(Timing),
    /// The machine does not permit it.
    Refused(String),
}

/// What `status.timing` of a component has.
#[derive(Debug, Deserialize)]
pub struct Timing {
    /// Cycles that were not over when the next was due.
    pub overruns: u64,
    /// How late they began.
    pub jitter: Durations,
}

/// Nanoseconds.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Durations {
    /// How many.
    pub count: u64,
    /// Half are below.
    pub median: u64,
    /// 99 of 100 are below.
    pub p99: u64,
    /// 999 of 1000 are below.
    pub p999: u64,
    /// The longest.
    pub max: u64,
    /// How many are below each power of two and not below half of it.
    pub buckets: Vec<(u64, u64)>,
}

impl Durations {
    /// Of all that were measured.
    pub fn of(mut all: Vec<u64>) -> Self {
        all.sort_unstable();
        let at = |share: f64| {
            let last = all.len().saturating_sub(1) as f64;
            all.get((last * share) as usize)
                .copied()
                .unwrap_or_default()
        };
        let (median, p99, p999, max) = (at(0.5), at(0.99), at(0.999), at(1.0));
        let mut buckets: Vec<(u64, u64)> = Vec::new();
        for below in all
            .iter()
            .map(|ns| (ns | 1).saturating_add(1).next_power_of_two())
        {
            match buckets.last_mut() {
                Some((last, count)) if *last == below => *count += 1,
                _ => buckets.push((below, 1)),
            }
        }
        Self {
            count: all.len() as u64,
            median,
            p99,
            p999,
            max,
            buckets,
        }
    }
}

/// A row of the table.
#[derive(Debug, Serialize)]
pub struct Row {
    /// How it was scheduled, and with what load.
    pub series: String,
    /// `component`, or `floor`.
    pub of: &'static str,
    /// Cycles that were not over when the next was due.
    pub overruns: u64,
    /// How late they began.
    pub jitter: Durations,
}

impl Row {
    /// Of what was measured.
    pub fn of(series: &str, of: &'static str, timing: Timing) -> Self {
        Self {
            series: series.to_owned(),
            of,
            overruns: timing.overruns,
            jitter: timing.jitter,
        }
    }
}

/// Deploys the component and lets it run for so long.
pub fn measure(
    stack: &Stack,
    cpu: usize,
    priority: Option<u8>,
    length: Duration,
) -> Result<Measured> {
    let write = |name: &str, text: String| -> Result<String> {
        let file = stack.folder.path().join(name);
        std::fs::write(&file, text)?;
        Ok(file.to_string_lossy().into_owned())
    };
    let system = write("tick.xml", profile())?;
    let overlay = write("overlay.yaml", overlay(cpu, priority))?;
    if let Err(error) = stack.rtsctl(&["apply", "-f", &system, "-f", &overlay]) {
        let refused = priority.is_some() && format!("{error:#}").contains("SCHED_FIFO");
        ensure!(refused, "{error:#}");
        return Ok(Measured::Refused(format!("{error:#}")));
    }
    sleep(length);
    let text = stack.output(&["get", "component", NAME, "-o", "json"])?;
    let object: Value = serde_json::from_str(&text)?;
    let status = find(&object).with_context(|| format!("no times of {NAME} in {text}"))?;
    let timing = serde_json::from_value(status["timing"].clone())?;
    let scheduler = status["realtime"]["scheduler"].as_str().unwrap_or_default();
    ensure!(
        (scheduler == "SCHED_FIFO") == priority.is_some(),
        "{NAME} is on {scheduler}"
    );
    Ok(Measured::Timing(timing))
}

/// The status with times, of an object or in a list of them.
fn find(value: &Value) -> Option<&Value> {
    let objects = value["items"]
        .as_array()
        .map_or(std::slice::from_ref(value), Vec::as_slice);
    let status = objects.iter().map(|object| &object["status"]);
    status
        .into_iter()
        .find(|status| status["timing"].is_object())
}

fn profile() -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:rtsctl:tick:1.0" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00" rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts">
<rts:Components rts:id="RTC:rtsctl:example:{TYPE}:1.0" rts:instanceName="{NAME}" rts:pathUri="localhost/{NAME}.rtc" rts:compositeType="None" rts:isRequired="true">
<rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="{RATE}"/>
</rts:Components>
</rts:RtsProfile>
"#
    )
}

fn overlay(cpu: usize, priority: Option<u8>) -> String {
    let priority = priority.map_or_else(String::new, |priority| {
        format!("realtimePriority: {priority}, lockMemory: true, ")
    });
    format!(
        "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n    {NAME}: {{ resources: {{ {priority}cpus: {cpu} }} }}\n"
    )
}

/// Prints the table, in microseconds.
pub fn print(rows: &[Row]) {
    println!(
        "{:<12} {:<10} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}   (microseconds late)",
        "SERIES", "OF", "CYCLES", "MEDIAN", "P99", "P99.9", "MAX", "OVERRUNS"
    );
    for row in rows {
        let jitter = &row.jitter;
        let us = |nanoseconds: u64| nanoseconds as f64 / 1e3;
        println!(
            "{:<12} {:<10} {:>8} {:>9.1} {:>9.1} {:>9.1} {:>9.1} {:>9}",
            row.series,
            row.of,
            jitter.count,
            us(jitter.median),
            us(jitter.p99),
            us(jitter.p999),
            us(jitter.max),
            row.overruns
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_what_was_measured() {
        let found = Durations::of((1..=1000).collect());
        assert_eq!((found.count, found.median, found.max), (1000, 500, 1000));
        assert_eq!((found.p99, found.p999), (990, 999));
        let total: u64 = found.buckets.iter().map(|(_, count)| count).sum();
        assert_eq!(total, 1000);
        // 512 to 1000 are below 1024.
        assert_eq!(found.buckets.last(), Some(&(1024, 489)));
        assert_eq!(Durations::of(Vec::new()).max, 0);
    }
}
