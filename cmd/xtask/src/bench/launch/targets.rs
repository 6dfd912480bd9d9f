//! What the rows of a run are to be beside each other.

use crate::bench::goals::Goal;
use crate::bench::stats::Row;

/// All goals whose rows were measured.
pub fn goals(rows: &[Row]) -> Vec<Goal> {
    let row = |name: &str| rows.iter().find(|row| row.row == name);
    let each = |name: &str| row(name).map(|row| row.median_ms_per_component);
    let whole = |name: &str| row(name).map(|row| row.median_ms);
    let ratio = |a: &str, b: &str| Some(each(a)? / each(b)?);
    let least = |of: &str, than: &str, times: f64| {
        let said = format!("{of} is so many times as fast as {than}");
        Some(Goal::at_least(&said, ratio(than, of)?, times))
    };
    let most =
        |said: &str, reached: Option<f64>, limit: f64| Some(Goal::at_most(said, reached?, limit));
    let goals = [
        most(
            "agent-10-same, ms per component",
            each("agent-10-same"),
            0.5,
        ),
        most(
            "agent-10-separate / floor-spawn",
            ratio("agent-10-separate", "floor-spawn"),
            1.0,
        ),
        most(
            "system-10-one-process, ms",
            whole("system-10-one-process"),
            25.0,
        ),
        most(
            "system-10-ten-processes, ms",
            whole("system-10-ten-processes"),
            50.0,
        ),
        most(
            "system-10-one-process-teardown, ms",
            whole("system-10-one-process-teardown"),
            15.0,
        ),
        most(
            "system-10-ten-processes-teardown, ms",
            whole("system-10-ten-processes-teardown"),
            15.0,
        ),
        least("agent-10-same", "ssh-loop-10", 100.0),
        least("agent-10-separate", "ssh-loop-10", 100.0),
        least("ssh-fallback-10-kept", "ssh-loop-10", 10.0),
    ];
    goals.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn goals_are_judged_by_medians_and_only_where_both_rows_are_there() {
        let row = |name: &str, ms| Row::new(name, 10, vec![Duration::from_millis(ms)]);
        let rows = [
            row("agent-10-same", 4),
            row("ssh-loop-10", 7000),
            row("floor-spawn", 40),
        ];
        let found = goals(&rows);
        let met: Vec<bool> = found.iter().map(|goal| goal.met).collect();
        assert_eq!(met, [true, true], "{found:?}");
        assert_eq!(found[1].reached, 1750.0);
    }
}
