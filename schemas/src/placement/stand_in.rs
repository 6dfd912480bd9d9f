//! `standIn`: a plain word says when there is one, a mapping also how it behaves.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::{StandInSettings, Values};
use crate::span::{Span, Text};
use crate::system::{StandIn, StandInSpec};
use crate::yaml::{self, Node};
use crate::yaml_type::{Definitions, Faults, Leaf, Map, Row, Setting, YamlType};

/// What is said of a stand-in, in either form.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StandInSetting(pub StandInSettings);

impl StandInSetting {
    /// Lays it over what was said before.
    pub(super) fn lay(&self, onto: &mut StandInSpec) {
        let said = &self.0;
        said.when.lay_some(&mut onto.when);
        said.startup_time.lay_some(&mut onto.startup_time_ms);
        said.fail.lay_some(&mut onto.fail);
        said.crash_after.lay_some(&mut onto.crash_after_ms);
        data(&said.data, &mut onto.data);
    }

    /// What has to be said to get it.
    pub(super) fn of(spec: &StandInSpec) -> Self {
        Self(StandInSettings {
            when: Setting::some(spec.when),
            startup_time: Setting::some(spec.startup_time_ms),
            fail: Setting::some(spec.fail),
            crash_after: Setting::some(spec.crash_after_ms),
            data: said_of(&spec.data),
        })
    }

    /// Everything but when.
    fn behaviour(&self) -> StandInSettings {
        StandInSettings {
            when: Setting::Silent,
            ..self.0.clone()
        }
    }
}

/// Port by port.
fn data(said: &Setting<Map<Values>>, onto: &mut BTreeMap<String, Vec<Vec<String>>>) {
    let ports = match said {
        Setting::Silent => return,
        Setting::Removed(_) => return onto.clear(),
        Setting::Said(ports, _) => ports,
    };
    for (port, said) in ports.iter() {
        match said {
            Setting::Silent => {}
            Setting::Removed(_) => {
                onto.remove(port.trimmed());
            }
            Setting::Said(values, _) => {
                onto.insert(port.trimmed().to_owned(), values.0.clone());
            }
        }
    }
}

fn said_of(data: &BTreeMap<String, Vec<Vec<String>>>) -> Setting<Map<Values>> {
    let ports = data.iter().map(|(port, values)| {
        let values = Setting::said(Values(values.clone()));
        (Text::new(port.as_str(), Span::default()), values)
    });
    Setting::some((!data.is_empty()).then(|| Map(ports.collect())))
}

impl YamlType for StandInSetting {
    fn schema(definitions: &mut Definitions) -> Value {
        let word = StandIn::schema(definitions);
        let mut choices = word["anyOf"].as_array().cloned().unwrap_or_default();
        choices.push(StandInSettings::schema(definitions));
        json!({"anyOf": choices})
    }

    fn read(node: &Node, key: &str, faults: &mut Faults) -> Option<Self> {
        if matches!(node.value, yaml::Value::Mapping(_)) {
            return StandInSettings::read(node, key, faults).map(Self);
        }
        let when = <StandIn as YamlType>::read(node, key, faults)?;
        Some(Self(StandInSettings {
            when: Setting::Said(when, node.span),
            ..StandInSettings::default()
        }))
    }

    fn write(&self) -> Value {
        match &self.0.when {
            Setting::Said(when, _) if self.behaviour() == StandInSettings::default() => {
                YamlType::write(when)
            }
            _ => self.0.write(),
        }
    }

    fn rows(path: &str, doc: &str, rows: &mut Vec<Row>) {
        <StandIn as YamlType>::rows(path, doc, rows);
        let mut own = Vec::new();
        StandInSettings::rows(path, "", &mut own);
        rows.extend(own.into_iter().skip(1));
    }

    fn leaves(&self, path: &[&str], span: Span, leaves: &mut Vec<Leaf>) {
        match &self.0.when {
            Setting::Silent => {}
            Setting::Removed(span) => leaves.push(Leaf {
                path: path.iter().map(|part| (*part).to_owned()).collect(),
                span: *span,
                value: Value::Null,
            }),
            Setting::Said(when, span) => when.leaves(path, *span, leaves),
        }
        self.behaviour().leaves(path, span, leaves);
    }
}
