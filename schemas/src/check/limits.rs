//! What a module says of a parameter's values, so that a wrong one is refused before anything starts.

use std::fmt;

use super::constraint::{self, Rule};
use super::value::{fits_type, needs_text};

/// The type and the constraint of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    value_type: String,
    rule: Rule,
}

/// Why a value is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// Code of the finding.
    pub code: &'static str,
    /// For people, as the end of a sentence.
    pub reason: String,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl Limits {
    /// Reads them, as an RTC Profile has them: `double` and `0<=x<=10`. An empty text limits nothing.
    ///
    /// # Errors
    /// Why the constraint is none, as the end of a sentence.
    pub fn read(value_type: &str, constraint: &str) -> Result<Self, String> {
        Ok(Self {
            value_type: value_type.trim().to_owned(),
            rule: constraint::parse(constraint)?,
        })
    }

    /// True when an empty text is no value: it stands for the default.
    pub fn needs_text(&self) -> bool {
        needs_text(&self.value_type)
    }

    /// Why a value is refused. An empty one is the component's to judge.
    pub fn problem(&self, value: &str) -> Option<Refusal> {
        if fits_type(&self.value_type, value) == Some(false) {
            return Some(Refusal {
                code: "bad-parameter-value",
                reason: format!("it is no `{}`", self.value_type),
            });
        }
        let fits = value.trim().is_empty() || self.rule.fits(value);
        (!fits).then(|| Refusal {
            code: "value-outside-constraint",
            reason: format!("allowed: {}", self.rule.text()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_keeps_to_its_type_and_its_constraint() {
        let problem = |value_type, constraint, value: &str| {
            let limits = Limits::read(value_type, constraint).unwrap();
            limits.problem(value).map(|refusal| refusal.to_string())
        };
        assert_eq!(problem("double", "0<=x<=1", "0.5"), None);
        assert_eq!(problem("", "", "anything"), None);
        assert_eq!(problem("int", "x>0", ""), None);
        assert_eq!(problem("int", "0<x<200", "0x7f"), None);
        let told = |text: &str| Some(text.to_owned());
        assert_eq!(
            problem("double", "0<=x<=1", "2"),
            told("allowed: 0 <= x <= 1")
        );
        assert_eq!(problem("int", "", "fast"), told("it is no `int`"));
        assert_eq!(
            problem("string", "(slow,fast)", "x"),
            told("allowed: (slow, fast)")
        );
        assert!(Limits::read("", "(a").unwrap_err().contains("never closed"));
    }
}
