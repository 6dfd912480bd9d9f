//! The text of a constraint → its rule.

use super::{Comparison, Rule, items, number};

/// Longest constraint that is read.
const LONGEST: usize = 4096;

/// Reads `x<1`, `0<=x<=1`, `(a,b)`, `x<1,x>2` or `{key: x<1}`; the variable may have any name.
///
/// # Errors
/// Why it is none of these, as the end of a sentence.
pub(in crate::check) fn parse(text: &str) -> Result<Rule, String> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(Rule::Anything);
    }
    if text.len() > LONGEST {
        return Err(format!("it has more than {LONGEST} bytes"));
    }
    if let Some(rest) = text.strip_prefix('{') {
        let inner = rest.strip_suffix('}').ok_or("`{` is never closed")?;
        let named: Result<Vec<_>, String> = items(inner).map(named).collect();
        return named.map(Rule::Named);
    }
    if let Some(rest) = text.strip_prefix('(') {
        let inner = rest.strip_suffix(')').ok_or("`(` is never closed")?;
        return choice(inner);
    }
    if !text.contains(',') {
        let rule = one(text)?;
        return match &rule {
            Rule::Is(Comparison::Equal, word) if number(word).is_none() => {
                Err(format!("`{word}` is no comparison"))
            }
            _ => Ok(rule),
        };
    }
    let rules: Result<Vec<Rule>, String> = items(text).map(one).collect();
    let rules = rules?;
    let is_word =
        |rule: &Rule| matches!(rule, Rule::Is(Comparison::Equal, word) if number(word).is_none());
    if rules.iter().all(is_word) {
        return Err(format!("a choice stands in parentheses: `({text})`"));
    }
    Ok(Rule::List(rules))
}

fn named(item: &str) -> Result<(String, Rule), String> {
    let (key, rule) = item
        .split_once(':')
        .ok_or_else(|| format!("`{item}` has no `key:`"))?;
    Ok((key.trim().to_owned(), one(rule.trim())?))
}

fn choice(inner: &str) -> Result<Rule, String> {
    if inner.contains(['(', ')']) {
        return Err("parentheses stand inside parentheses".to_owned());
    }
    let values = items(inner).map(|value| match value {
        "" => Err("a value of the choice is empty".to_owned()),
        value => Ok(Rule::Is(Comparison::Equal, value.to_owned())),
    });
    values.collect::<Result<Vec<_>, _>>().map(Rule::Either)
}

/// A comparison, two of them around one variable, or a plain value.
fn one(text: &str) -> Result<Rule, String> {
    let (first, rest) = match split(text) {
        None if text.is_empty() => return Err("a part of it is empty".to_owned()),
        None => return Ok(Rule::Is(Comparison::Equal, text.to_owned())),
        Some((left, comparison, rest)) => ((left, comparison), rest),
    };
    let (left, comparison) = first;
    match split(rest) {
        None => single(left, comparison, rest),
        Some((middle, second, right)) if split(right).is_none() => {
            double(left, comparison, middle, second, right)
        }
        Some(_) => Err("it has more than two comparisons".to_owned()),
    }
}

fn single(left: &str, comparison: Comparison, right: &str) -> Result<Rule, String> {
    match (number(left), number(right)) {
        (None, Some(_)) if is_variable(left) => Ok(Rule::Is(comparison, right.to_owned())),
        (Some(_), None) if is_variable(right) => Ok(Rule::Is(comparison.turned(), left.to_owned())),
        (None, None) if comparison == Comparison::Equal && is_variable(left) => {
            Ok(Rule::Is(comparison, right.to_owned()))
        }
        _ => Err(format!(
            "`{left} {} {right}` does not compare a variable with a number",
            comparison.sign()
        )),
    }
}

fn double(
    left: &str,
    first: Comparison,
    middle: &str,
    second: Comparison,
    right: &str,
) -> Result<Rule, String> {
    let (Some(from), Some(to)) = (number(left), number(right)) else {
        return Err("both of its bounds must be numbers".to_owned());
    };
    if !is_variable(middle) {
        return Err(format!("`{middle}` between its bounds is no variable"));
    }
    let up = |c| matches!(c, Comparison::Less | Comparison::LessOrEqual);
    let down = |c| matches!(c, Comparison::Greater | Comparison::GreaterOrEqual);
    let (low, high) = match (first, second) {
        (a, b) if up(a) && up(b) => (
            Rule::Is(first.turned(), left.to_owned()),
            Rule::Is(second, right.to_owned()),
        ),
        (a, b) if down(a) && down(b) => (
            Rule::Is(second, right.to_owned()),
            Rule::Is(first.turned(), left.to_owned()),
        ),
        _ => return Err("its two comparisons point in different directions".to_owned()),
    };
    let empty = if up(first) { from > to } else { from < to };
    if empty {
        return Err("no value is between its bounds".to_owned());
    }
    Ok(Rule::All(vec![low, high]))
}

fn is_variable(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_alphanumeric() || c == '_')
}

/// What stands before the first sign of comparison, the sign, and the rest.
fn split(text: &str) -> Option<(&str, Comparison, &str)> {
    let at = text.find(['<', '>', '='])?;
    let (left, rest) = text.split_at(at);
    let signs = [
        ("<=", Comparison::LessOrEqual),
        (">=", Comparison::GreaterOrEqual),
        ("==", Comparison::Equal),
        ("<", Comparison::Less),
        (">", Comparison::Greater),
        ("=", Comparison::Equal),
    ];
    let (sign, comparison) = signs.into_iter().find(|(sign, _)| rest.starts_with(sign))?;
    Some((left.trim(), comparison, rest[sign.len()..].trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_told() {
        let all = [
            "(0,1",
            "(0,,1)",
            "((0))",
            "{a}",
            "{a: 1",
            "event, continuous",
            "conf_constraint",
            "0 < x > 1",
            "5 < x < 1",
            "0 < x < 1 < 2",
            "a < b",
            "1 < 2",
            "x <",
            "0 < 1 < 2",
            "x < 1, ",
        ];
        let told: Vec<String> = all
            .iter()
            .map(|text| format!("{text}: {}", parse(text).unwrap_err()))
            .collect();
        insta::assert_snapshot!(told.join("\n"), @r"
        (0,1: `(` is never closed
        (0,,1): a value of the choice is empty
        ((0)): parentheses stand inside parentheses
        {a}: `a` has no `key:`
        {a: 1: `{` is never closed
        event, continuous: a choice stands in parentheses: `(event, continuous)`
        conf_constraint: `conf_constraint` is no comparison
        0 < x > 1: its two comparisons point in different directions
        5 < x < 1: no value is between its bounds
        0 < x < 1 < 2: it has more than two comparisons
        a < b: `a < b` does not compare a variable with a number
        1 < 2: `1 < 2` does not compare a variable with a number
        x <: `x < ` does not compare a variable with a number
        0 < 1 < 2: `1` between its bounds is no variable
        x < 1, : a part of it is empty
        ");
    }
}
