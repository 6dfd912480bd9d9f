//! Parameters of a component against what the profile itself says of them: `__constraints__`, `__widget__`, `__type__`.

use std::collections::{HashMap, HashSet};

use super::Check;
use super::constraint::{self, Rule};
use super::sink::Sink;
use super::value::fits_type;
use crate::diagnostic::Finding;
use crate::rts_profile::is_pseudo_set;
use crate::rts_profile::model::{Component, Property};
use crate::span::Text;
use crate::suggest;

/// What is said of one parameter.
#[derive(Default)]
struct Known<'a> {
    rule: Option<Rule>,
    data_type: Option<&'a Text>,
    widget: Option<&'a Text>,
    /// It has a constraint, which may be one that cannot be read.
    constrained: bool,
}

/// The pseudo sets that are read.
pub(super) const SETS: [&str; 3] = ["__constraints__", "__widget__", "__type__"];

pub(super) fn parameters<'a>(check: &mut Check<'a>, component: &'a Component) {
    let mut known: HashMap<&str, Known<'a>> = HashMap::new();
    let mut order: Vec<(&'static str, &'a Text)> = Vec::new();
    for kind in SETS {
        for (name, value) in entries(component, kind) {
            let parameter = known.entry(name.trimmed()).or_default();
            order.push((kind, name));
            match kind {
                "__constraints__" => {
                    parameter.constrained = true;
                    parameter.rule = rule(&mut check.sink, name.trimmed(), value);
                }
                "__widget__" => parameter.widget = Some(value),
                _ => parameter.data_type = Some(value),
            }
        }
    }
    if known.is_empty() {
        return;
    }
    let mut widgets: Vec<_> = known.iter().collect();
    widgets.sort_unstable_by_key(|(name, _)| **name);
    for (name, parameter) in widgets {
        if let Some(value) = parameter.widget {
            let rule = parameter.rule.as_ref();
            let silent = parameter.constrained && rule.is_none();
            widget(&mut check.sink, name, value, rule, silent);
        }
    }
    let names = values(check, component, &known);
    strangers(check, component, &order, &names);
}

/// The entries of a pseudo set.
pub(super) fn entries<'a>(component: &'a Component, kind: &str) -> Vec<(&'a Text, &'a Text)> {
    fn pair(property: &Property) -> Option<(&Text, &Text)> {
        Some((property.name.as_ref()?, property.value.as_ref()?))
    }
    let of_kind = |id: &Option<Text>| id.as_ref().is_some_and(|id| id.trimmed() == kind);
    let sets = component.configuration_sets.iter();
    let sets = sets.filter(|set| of_kind(&set.id));
    sets.flat_map(|set| set.data.iter().filter_map(pair))
        .collect()
}

/// The rule of a constraint's text; a fault in it is told.
pub(super) fn rule(sink: &mut Sink<'_>, parameter: &str, text: &Text) -> Option<Rule> {
    match constraint::parse(&text.value) {
        Ok(rule) => Some(rule),
        Err(fault) => {
            let message = format!(
                "the constraint `{}` of the parameter `{parameter}` cannot be read: {fault}",
                text.trimmed()
            );
            let help = "write `0 <= x <= 10`, `x > 0`, a choice `(a, b)`, or one for each item: `x < 1, x > 2`";
            sink.warning("bad-constraint", message, text.span, help);
            None
        }
    }
}

/// A widget's text, and whether its constraint is one that it can show. `silent`: there is one, and it cannot be read.
pub(super) fn widget(
    sink: &mut Sink<'_>,
    parameter: &str,
    text: &Text,
    rule: Option<&Rule>,
    silent: bool,
) {
    const KNOWN: [&str; 6] = [
        "text",
        "slider",
        "spin",
        "radio",
        "checkbox",
        "ordered_list",
    ];
    let lower = text.trimmed().to_ascii_lowercase();
    let (name, step) = match lower.split_once('.') {
        Some((name, step)) => (name, step),
        None => (lower.as_str(), ""),
    };
    if name.is_empty() {
        return;
    }
    if !KNOWN.contains(&name) {
        let message = format!(
            "`{}` of the parameter `{parameter}` is no widget",
            text.trimmed()
        );
        let help = suggest::advice(name, "widgets", &KNOWN);
        return sink.warning("bad-widget", message, text.span, help);
    }
    let stepped = matches!(name, "slider" | "spin");
    let is_step = stepped && constraint::number(step).is_some_and(|step| step > 0.0);
    if !step.is_empty() && !is_step {
        let message = format!(
            "`{}` of the parameter `{parameter}` has no number above 0 as its step",
            text.trimmed()
        );
        let help = "write `slider.0.1` or `spin.5`; the others take no step";
        return sink.warning("bad-widget", message, text.span, help);
    }
    let (fits, what, needs) = match name {
        "slider" | "spin" => (rule.is_some_and(Rule::is_range), "range", "`0 <= x <= 10`"),
        "radio" | "checkbox" | "ordered_list" => {
            (rule.is_some_and(Rule::is_choice), "choice", "`(a, b)`")
        }
        _ => return,
    };
    if !fits && !silent {
        let message = format!("the {name} of the parameter `{parameter}` has no {what} to show");
        let help = format!("add a constraint such as {needs}; editors show a text box instead");
        sink.warning("bad-widget", message, text.span, help);
    }
}

/// Checks every value; gives the names of all parameters.
fn values<'a>(
    check: &mut Check<'a>,
    component: &'a Component,
    known: &HashMap<&str, Known<'_>>,
) -> HashSet<&'a str> {
    let mut names = HashSet::new();
    let sets = component.configuration_sets.iter();
    let real = sets.filter(|set| {
        !set.id
            .as_ref()
            .is_some_and(|id| is_pseudo_set(id.trimmed()))
    });
    for parameter in real.flat_map(|set| &set.data) {
        let (Some(name), Some(value)) = (&parameter.name, &parameter.value) else {
            continue;
        };
        names.insert(name.trimmed());
        let Some(known) = known.get(name.trimmed()) else {
            continue;
        };
        let what = format!("the parameter `{}`", name.trimmed());
        let data_type = known.data_type.map(|text| text.value.as_str());
        if let Some(finding) = fault(&what, &value.value, data_type, known.rule.as_ref()) {
            check.sink.push(finding, value.span);
        }
    }
    names
}

/// What is wrong with the value of `what` (the parameter `gain`): it is none of its type, or outside its constraint.
pub(super) fn fault(
    what: &str,
    value: &str,
    data_type: Option<&str>,
    rule: Option<&Rule>,
) -> Option<Finding> {
    let value_told = value.trim();
    if let Some(data_type) = data_type
        && fits_type(data_type, value) == Some(false)
    {
        let data_type = data_type.trim();
        let message = format!("`{value_told}` of {what} is no value of its type `{data_type}`");
        let help = format!("write a value of the type `{data_type}`");
        return Some(Finding::warning("bad-parameter-value", message).help(help));
    }
    let rule = rule.filter(|rule| !value_told.is_empty() && !rule.fits(value))?;
    let message = format!("`{value_told}` of {what} is outside its constraint");
    let help = format!("allowed: {}", rule.text());
    Some(Finding::warning("value-outside-constraint", message).help(help))
}

/// Names in pseudo sets that no set has as a parameter.
fn strangers(
    check: &mut Check<'_>,
    component: &Component,
    order: &[(&str, &Text)],
    names: &HashSet<&str>,
) {
    if names.is_empty() {
        return;
    }
    let instance = component.instance_name.as_ref().map_or("", Text::trimmed);
    let mut listed: Vec<&str> = Vec::new();
    for (kind, name) in order.iter().filter(|(_, n)| !names.contains(n.trimmed())) {
        if check.sink.is_full() {
            return;
        }
        if listed.is_empty() {
            listed = names.iter().copied().collect();
            listed.sort_unstable();
        }
        let message = format!(
            "`{kind}` speaks of `{}`, which is no parameter of component `{instance}`",
            name.trimmed()
        );
        let help = suggest::advice(name.trimmed(), "parameters", &listed);
        check.warning("unknown-parameter", message, name.span, help);
    }
}
