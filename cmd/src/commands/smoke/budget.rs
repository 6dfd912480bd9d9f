//! How long a check may take.

use std::str::FromStr;
use std::time::Duration;

use super::check::Check;
use crate::commands::duration;

/// `apply=2s`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    check: Check,
    limit: Duration,
}

impl FromStr for Budget {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((name, time)) = text.split_once('=') else {
            return Err("write CHECK=TIME, as in `apply=2s`".to_owned());
        };
        let found = Check::ALL.into_iter().find(|check| check.name() == name);
        let check = found.ok_or_else(|| {
            let names = Check::ALL.map(Check::name).join(", ");
            format!("{name:?} is no check; there are: {names}")
        })?;
        let limit = duration(time)?;
        Ok(Self { check, limit })
    }
}

/// All of them; of one check the last one counts.
#[derive(Debug, Clone, Default)]
pub struct Budgets(pub Vec<Budget>);

impl Budgets {
    /// How long a check may take, if that was said.
    pub fn of(&self, check: Check) -> Option<Duration> {
        let mut own = self.0.iter().rev();
        let budget = own.find(|budget| budget.check == check)?;
        Some(budget.limit)
    }

    /// What is wrong with the time that a check took.
    pub fn exceeded(&self, check: Check, took: Duration) -> Option<String> {
        let limit = self.of(check).filter(|limit| took > *limit)?;
        let (took, limit) = (took.as_secs_f64(), limit.as_secs_f64());
        Some(format!("took {took:.2} s, and its budget is {limit} s"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_name_a_check_and_a_time() {
        let budgets = ["apply=2s", "total=250ms", "apply=3s"].map(|text| text.parse().unwrap());
        let budgets = Budgets(budgets.to_vec());
        assert_eq!(budgets.of(Check::Apply), Some(Duration::from_secs(3)));
        assert_eq!(budgets.of(Check::Heal), None);
        assert_eq!(budgets.exceeded(Check::Apply, Duration::from_secs(3)), None);
        let late = budgets.exceeded(Check::Total, Duration::from_millis(260));
        assert_eq!(late.unwrap(), "took 0.26 s, and its budget is 0.25 s");
        for wrong in ["apply", "apply=", "apply=0s", "aply=2s", "=2s"] {
            assert!(wrong.parse::<Budget>().is_err(), "{wrong}");
        }
        let error = "aply=2s".parse::<Budget>().unwrap_err();
        assert!(error.contains("there are: start, apply"), "{error}");
    }
}
