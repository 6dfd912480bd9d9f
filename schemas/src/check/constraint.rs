//! Constraints of parameters: which values fit, whether they come as text (`0<=x<=10`) or as elements of an RTC Profile.

mod parse;

pub(super) use parse::parse;

use super::value::integer;

/// Which values are allowed.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rule {
    /// A comparison with a number or text.
    Is(Comparison, String),
    /// All of them hold.
    All(Vec<Rule>),
    /// At least one of them holds.
    Either(Vec<Rule>),
    /// It does not hold.
    Not(Box<Rule>),
    /// For the items of a list, one after the other; the last also for all further ones.
    List(Vec<Rule>),
    /// For named items.
    Named(Vec<(String, Rule)>),
    /// Nothing that can be judged here.
    Anything,
}

/// How a value compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Comparison {
    /// `x < 1`
    Less,
    /// `x <= 1`
    LessOrEqual,
    /// `x > 1`
    Greater,
    /// `x >= 1`
    GreaterOrEqual,
    /// `1`
    Equal,
}

impl Comparison {
    /// The same with its sides changed: `1 < x` is `x > 1`.
    fn turned(self) -> Self {
        match self {
            Self::Less => Self::Greater,
            Self::LessOrEqual => Self::GreaterOrEqual,
            Self::Greater => Self::Less,
            Self::GreaterOrEqual => Self::LessOrEqual,
            Self::Equal => Self::Equal,
        }
    }

    fn sign(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
            Self::Equal => "=",
        }
    }

    fn holds(self, value: &str, bound: &str) -> bool {
        match (number(value), number(bound)) {
            (Some(value), Some(bound)) => match self {
                Self::Less => value < bound,
                Self::LessOrEqual => value <= bound,
                Self::Greater => value > bound,
                Self::GreaterOrEqual => value >= bound,
                Self::Equal => value == bound,
            },
            (None, Some(_)) => false,
            // Texts have no order that a file could mean.
            (_, None) => self != Self::Equal || value == bound,
        }
    }
}

pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    let real = text.parse().ok();
    real.or_else(|| integer(text).map(|whole| whole as f64))
        .filter(|n: &f64| n.is_finite())
}

/// Items of a list, without blanks around them.
pub(super) fn items(value: &str) -> impl Iterator<Item = &str> {
    value.split(',').map(str::trim)
}

impl Rule {
    /// True when a value, or each item of a list, is allowed.
    pub(super) fn fits(&self, value: &str) -> bool {
        let value = value.trim();
        match self {
            Self::List(rules) => items(value)
                .enumerate()
                .all(|(at, item)| rules.get(at).or(rules.last()).is_none_or(|r| r.one(item))),
            rule => rule.one(value) || value.contains(',') && items(value).all(|i| rule.one(i)),
        }
    }

    fn one(&self, value: &str) -> bool {
        match self {
            Self::Is(comparison, bound) => comparison.holds(value, bound),
            Self::All(rules) => rules.iter().all(|rule| rule.one(value)),
            Self::Either(rules) => rules.iter().any(|rule| rule.one(value)),
            Self::Not(rule) => !rule.one(value),
            Self::Named(rules) => named(rules, value),
            Self::List(_) | Self::Anything => true,
        }
    }

    /// True for a choice of values.
    pub(super) fn is_choice(&self) -> bool {
        let is_value = |rule: &Rule| matches!(rule, Self::Is(Comparison::Equal, _));
        matches!(self, Self::Either(rules) if rules.iter().all(is_value))
    }

    /// True when it has a least and a greatest value.
    pub(super) fn is_range(&self) -> bool {
        let mut rules = match self {
            Self::All(rules) => rules.iter(),
            Self::List(rules) | Self::Either(rules) => return rules.iter().all(Self::is_range),
            Self::Named(rules) => return rules.iter().all(|(_, rule)| rule.is_range()),
            _ => return false,
        };
        let has = |rule: &Rule, one, other| matches!(rule, Self::Is(comparison, _) if [one, other].contains(comparison));
        let all = rules.clone();
        rules.any(|r| has(r, Comparison::Less, Comparison::LessOrEqual))
            && all
                .into_iter()
                .any(|r| has(r, Comparison::Greater, Comparison::GreaterOrEqual))
    }

    /// As it is written in a file.
    pub(super) fn text(&self) -> String {
        let list = |rules: &[Rule], between: &str| {
            let texts: Vec<String> = rules.iter().take(20).map(Rule::text).collect();
            let more = if rules.len() > 20 { between } else { "" };
            let dots = if rules.len() > 20 { "…" } else { "" };
            format!("{}{more}{dots}", texts.join(between))
        };
        match self {
            Self::Is(Comparison::Equal, value) => value.clone(),
            Self::Is(comparison, bound) => format!("x {} {bound}", comparison.sign()),
            Self::All(rules) => match rules.as_slice() {
                [Self::Is(low, least), Self::Is(high, most)] => {
                    let signs = (low.turned().sign(), high.sign());
                    format!("{least} {} x {} {most}", signs.0, signs.1)
                }
                rules => list(rules, " and "),
            },
            Self::Either(rules) if self.is_choice() => format!("({})", list(rules, ", ")),
            Self::Either(rules) => list(rules, " or "),
            Self::Not(rule) => format!("not {}", rule.text()),
            Self::List(rules) => list(rules, ", "),
            Self::Named(rules) => {
                let pair = |(key, rule): &(String, Rule)| format!("{key}: {}", rule.text());
                let pairs: Vec<String> = rules.iter().take(20).map(pair).collect();
                format!("{{{}}}", pairs.join(", "))
            }
            Self::Anything => "anything".to_owned(),
        }
    }
}

/// `{key: value, …}`, with or without braces; of any other text nothing is said.
fn named(rules: &[(String, Rule)], value: &str) -> bool {
    let inner = value.trim_start_matches('{').trim_end_matches('}');
    items(inner).all(|item| {
        let Some((key, value)) = item.split_once(':') else {
            return true;
        };
        let rule = rules.iter().find(|(name, _)| name == key.trim());
        rule.is_none_or(|(_, rule)| rule.one(value.trim()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fits(constraint: &str, value: &str) -> bool {
        parse(constraint).unwrap().fits(value)
    }

    #[test]
    fn values_are_compared_as_numbers_or_as_texts() {
        let right = [
            ("0<=x<=1.0", "1"),
            ("0 < x < 3.14", "3"),
            ("x>=0", "1e3"),
            ("10 > x", "9.5"),
            ("(0, 1)", "1.0"),
            ("(true,false)", "false"),
            ("(a,b,c)", "c,a"),
            ("x<10, x>10", "9, 11, 12"),
            ("0<=x<=1", "0.5,0.7"),
            ("{k: x<5, l: 3}", "{k: 4, l: 3}"),
            ("{k: x<5}", "anything"),
            ("", "anything"),
            ("100", "100.0"),
        ];
        for (constraint, value) in right {
            assert!(fits(constraint, value), "{constraint} {value}");
        }
        let wrong = [
            ("0<=x<=1.0", "1.1"),
            ("0<=x<=1.0", "one"),
            ("0<=x<=1.0", "0.5,2"),
            ("(0, 1)", "2"),
            ("(true,false)", "maybe"),
            ("x<10, x>10", "9, 9"),
            ("{k: x<5}", "k: 6"),
        ];
        for (constraint, value) in wrong {
            assert!(!fits(constraint, value), "{constraint} {value}");
        }
    }

    #[test]
    fn a_rule_is_told_as_it_is_written() {
        for text in [
            "0 <= x <= 1.0",
            "x > 0",
            "(a, b)",
            "x < 1, x > 2",
            "{k: x < 1}",
            "100",
        ] {
            assert_eq!(parse(text).unwrap().text(), text);
        }
        assert!(parse("0<=x<=1").unwrap().is_range());
        assert!(!parse("0<=x").unwrap().is_range());
        assert!(parse("(0,1)").unwrap().is_choice());
    }
}
