//! How an execution context keeps its time, in a few lines.

use rts_controller_api::objects::ComponentStatus;
use rts_plan::observed::{DurationsObserved, RealtimeObserved};

/// Lines of a component's page.
pub fn lines(status: &ComponentStatus) -> Vec<(&'static str, String)> {
    let mut lines = status.realtime.as_ref().map_or(Vec::new(), realtime);
    let Some(timing) = &status.timing else {
        return lines;
    };
    if let Some(reached) = timing.reached {
        lines.push(("Rate reached", format!("{reached} Hz")));
    }
    lines.push(("Execution time", durations(&timing.execution)));
    if let Some(jitter) = &timing.jitter {
        lines.push(("Jitter", durations(jitter)));
        lines.push(("Overruns", timing.overruns.to_string()));
    }
    lines
}

/// What it has of its node, and what it was denied.
fn realtime(found: &RealtimeObserved) -> Vec<(&'static str, String)> {
    let priority = match found.priority {
        0 => String::new(),
        priority => format!(" {priority}"),
    };
    let locked = if found.memory_locked { "" } else { "not " };
    let (scheduler, cpus) = (&found.scheduler, &found.cpus);
    let had = format!("{scheduler}{priority}, processors {cpus}, memory {locked}locked");
    let denied = found.denied.iter().cloned();
    let denied = denied.map(|why| ("Not permitted", why));
    [("Scheduling", had)].into_iter().chain(denied).collect()
}

fn durations(durations: &DurationsObserved) -> String {
    let [median, p99, max] = [durations.median, durations.p99, durations.max].map(short);
    format!("median {median}, 99 % below {p99}, at most {max}")
}

/// A duration with three digits.
pub fn short(nanoseconds: u64) -> String {
    let (value, unit) = match nanoseconds {
        0..1_000 => return format!("{nanoseconds} ns"),
        1_000..1_000_000 => (nanoseconds as f64 / 1e3, "µs"),
        1_000_000..1_000_000_000 => (nanoseconds as f64 / 1e6, "ms"),
        _ => (nanoseconds as f64 / 1e9, "s"),
    };
    let digits = match value {
        ..10.0 => 2,
        10.0..100.0 => 1,
        _ => 0,
    };
    format!("{value:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn durations_have_three_digits() {
        let told = [0, 999, 1_000, 12_345, 123_456, 9_876_543, 1_500_000_000].map(short);
        assert_eq!(
            told,
            [
                "0 ns", "999 ns", "1.00 µs", "12.3 µs", "123 µs", "9.88 ms", "1.50 s"
            ]
        );
    }
}
