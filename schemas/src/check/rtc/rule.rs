//! The elements of a constraint → its rule.

use super::super::constraint::{Comparison, Rule, number};
use crate::rtc_profile::forms::{self, Constraint, ConstraintUnit, Constraints};
use crate::span::{Span, Text};

/// What is wrong, as the end of a sentence, and where.
type Fault = (String, Span);

/// Reads a constraint.
pub(in crate::check) fn rule_of(constraint: &Constraint) -> Result<Rule, Fault> {
    if let Some(unit) = &constraint.unit {
        return rule_of_unit(unit);
    }
    if let Some(list) = &constraint.list {
        return all(list).map(Rule::List);
    }
    if let Some(hash) = &constraint.hash {
        let named = hash.constraints.iter().filter_map(|constraint| {
            let key = constraint.unit.as_ref()?.key.as_ref()?.trimmed().to_owned();
            Some(rule_of(constraint).map(|rule| (key, rule)))
        });
        return named.collect::<Result<_, _>>().map(Rule::Named);
    }
    Ok(Rule::Anything)
}

fn all(several: &Constraints) -> Result<Vec<Rule>, Fault> {
    several.constraints.iter().map(rule_of).collect()
}

fn rule_of_unit(unit: &ConstraintUnit) -> Result<Rule, Fault> {
    if let Some(several) = &unit.and {
        return all(several).map(ordered);
    }
    if let Some(several) = &unit.or {
        return all(several).map(Rule::Either);
    }
    if let Some(several) = &unit.not {
        let rule = all(several).map(Rule::Either)?;
        return Ok(Rule::Not(Box::new(rule)));
    }
    if let Some(between) = &unit.is_between {
        let least = literal(between.lower_boundary.as_ref(), between.span, true)?;
        let most = literal(between.upper_boundary.as_ref(), between.span, true)?;
        if let (Some(low), Some(high)) = (number(&least), number(&most))
            && low > high
        {
            let fault = format!("allows no value: {least} is more than {most}");
            return Err((fault, between.span));
        }
        return Ok(Rule::All(vec![
            Rule::Is(Comparison::GreaterOrEqual, least),
            Rule::Is(Comparison::LessOrEqual, most),
        ]));
    }
    let comparisons = [
        (&unit.is_equal_to, Comparison::Equal),
        (&unit.is_less_than, Comparison::Less),
        (&unit.is_greater_than, Comparison::Greater),
        (&unit.is_less_than_or_equal_to, Comparison::LessOrEqual),
        (
            &unit.is_greater_than_or_equal_to,
            Comparison::GreaterOrEqual,
        ),
    ];
    for (found, comparison) in comparisons {
        if let Some(found) = found {
            let text = compared(found, comparison != Comparison::Equal)?;
            return Ok(Rule::Is(comparison, text));
        }
    }
    match &unit.is_not_equal_to {
        Some(found) => {
            let equal = Rule::Is(Comparison::Equal, compared(found, false)?);
            Ok(Rule::Not(Box::new(equal)))
        }
        // A pattern, nothing at all, or something that no schema has.
        None => Ok(Rule::Anything),
    }
}

/// A lower bound goes before an upper one, as people write a range.
fn ordered(mut rules: Vec<Rule>) -> Rule {
    let is_upper = |rule: &Rule| {
        matches!(
            rule,
            Rule::Is(Comparison::Less | Comparison::LessOrEqual, _)
        )
    };
    if let [first, second] = rules.as_mut_slice()
        && is_upper(first)
        && !is_upper(second)
    {
        rules.swap(0, 1);
    }
    Rule::All(rules)
}

fn compared(comparison: &forms::Comparison, numeric: bool) -> Result<String, Fault> {
    literal(comparison.literal.as_ref(), comparison.span, numeric)
}

fn literal(text: Option<&Text>, span: Span, numeric: bool) -> Result<String, Fault> {
    let Some(text) = text.filter(|text| !text.trimmed().is_empty()) else {
        return Err(("compares with nothing".to_owned(), span));
    };
    if numeric && number(text.trimmed()).is_none() {
        let fault = format!("compares with `{}`, which is no number", text.trimmed());
        return Err((fault, text.span));
    }
    Ok(text.trimmed().to_owned())
}
