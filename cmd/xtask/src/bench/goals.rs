//! What the figures of a run are to be, and whether they are.

use serde::Serialize;

/// A goal beside what was reached.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Goal {
    /// What is compared.
    pub goal: String,
    /// What was reached.
    pub reached: f64,
    /// `at most` or `at least`.
    pub kind: &'static str,
    /// The limit.
    pub limit: f64,
    /// Whether it is within it.
    pub met: bool,
}

impl Goal {
    /// Something that is to be small.
    pub fn at_most(goal: &str, reached: f64, limit: f64) -> Self {
        Self {
            goal: goal.to_owned(),
            reached,
            kind: "at most",
            limit,
            met: reached <= limit,
        }
    }

    /// Something that is to be large.
    pub fn at_least(goal: &str, reached: f64, limit: f64) -> Self {
        Self {
            goal: goal.to_owned(),
            reached,
            kind: "at least",
            limit,
            met: reached >= limit,
        }
    }
}

/// Prints goals as a table.
pub fn print(goals: &[Goal]) {
    print!("{}", table(goals));
}

fn table(goals: &[Goal]) -> String {
    let width = goals.iter().map(|goal| goal.goal.chars().count());
    let width = width.fold(4, usize::max);
    let mut text = format!("{:<width$} {:>10} {:>16}\n", "GOAL", "REACHED", "IS TO BE");
    for goal in goals {
        let limit = format!("{} {}", goal.kind, goal.limit);
        let met = if goal.met { "met" } else { "MISSED" };
        text.push_str(&format!(
            "{:<width$} {:>10.3} {limit:>16}  {met}\n",
            goal.goal, goal.reached
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missed_is_said() {
        let goals = [
            Goal::at_most("a start, ms", 20.0, 50.0),
            Goal::at_least("as fast as SSH", 80.0, 100.0),
            Goal::at_most("exactly the limit", 1.0, 1.0),
            Goal::at_most("nothing was measured", f64::NAN, 1.0),
        ];
        let lines = "\
GOAL                    REACHED         IS TO BE
a start, ms              20.000       at most 50  met
as fast as SSH           80.000     at least 100  MISSED
exactly the limit         1.000        at most 1  met
nothing was measured        NaN        at most 1  MISSED
";
        assert_eq!(table(&goals), lines);
    }
}
