//! Parameters of an RTC Profile: names, types, defaults, constraints, widgets.

use std::collections::HashSet;

use super::super::parameters::{fault, widget};
use super::super::sink::{Sink, said};
use super::rule_of;
use crate::rtc_profile::forms::{Configuration, ConfigurationSet};
use crate::span::Text;

pub(super) fn parameters(sink: &mut Sink<'_>, set: &ConfigurationSet) {
    let mut seen = HashSet::new();
    for parameter in &set.configurations {
        let Some(name) = said(&parameter.name) else {
            sink.error(
                "missing-attribute",
                "a parameter has no name".to_owned(),
                parameter.span,
                "add `name`",
            );
            continue;
        };
        if !seen.insert(name.trimmed()) {
            let message = format!("the parameter `{}` stands twice", name.trimmed());
            let help = "give each its own name";
            sink.warning("duplicate-parameter", message, name.span, help);
        }
        self::parameter(sink, parameter, name.trimmed());
    }
}

fn parameter(sink: &mut Sink<'_>, parameter: &Configuration, name: &str) {
    let mut silent = false;
    let mut rule = None;
    if let Some(constraint) = parameter.constraint.as_deref() {
        match rule_of(constraint) {
            Ok(found) => rule = Some(found),
            Err((fault, span)) => {
                silent = true;
                let message = format!("the constraint of the parameter `{name}` {fault}");
                let help = "compare with a number, or list the values with `Or`";
                let span = if span.is_unknown() {
                    parameter.span
                } else {
                    span
                };
                sink.warning("bad-constraint", message, span, help);
            }
        }
    }
    let shown = parameter.properties.iter().filter(|property| {
        let name = property.name.as_ref().map_or("", Text::trimmed);
        name == "__widget__"
    });
    for text in shown.filter_map(|property| property.value.as_ref()) {
        widget(sink, name, text, rule.as_ref(), silent);
    }
    let Some(value) = &parameter.default_value else {
        return;
    };
    let what = format!("the parameter `{name}`");
    let data_type = said(&parameter.data_type).map(|text| text.value.as_str());
    if let Some(finding) = fault(&what, &value.value, data_type, rule.as_ref()) {
        sink.push(finding, value.span);
    }
}
