//! What is added, field by field: a plan says it once, in its steps.

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::system::{
    Configuration, ConnectorSpec, ExecutionKind, OnDisconnect, Realtime, SharedExecutionContext,
};

use crate::plan::{Action, Change, FieldChange, Plan, Step, Work};

/// The changes with the fields of what is added too, as far as there are steps for it: of a component `type`, `node`,
/// `manager`, `rate`, `executionKind`, `executionContext`, `onDisconnect` and `configuration.…`, of a connector `dataType` and
/// `properties.…`, of a process `node`. All new; what is left to a default is not among them.
pub fn details(plan: &Plan) -> Vec<Change> {
    let adds = plan.changes.iter().filter(|c| is_bare(c));
    let wanted: BTreeMap<_, ()> = adds.map(|c| (key_of(c), ())).collect();
    let mut made = BTreeMap::new();
    for step in &plan.steps {
        let system = step.system.as_ref().map(|s| s.name.as_str());
        // An older controller does not say the node of a manager.
        let node = matches!(step.work, Work::StartManager { .. }).then_some(step.node.as_str());
        for node in BTreeSet::from([None, node]) {
            let key = (step.target.as_str(), system, node);
            if wanted.contains_key(&key)
                && let Some(fields) = fields(step)
            {
                made.insert(key, fields);
            }
        }
    }
    let filled = |change: &Change| {
        let mut filled = change.clone();
        if is_bare(change)
            && let Some(fields) = made.get(&key_of(change))
        {
            filled.fields.clone_from(fields);
        }
        filled
    };
    plan.changes.iter().map(filled).collect()
}

fn is_bare(change: &Change) -> bool {
    change.action == Action::Add && change.fields.is_empty()
}

fn key_of(change: &Change) -> (&str, Option<&str>, Option<&str>) {
    let (system, node) = (change.system.as_deref(), change.node.as_deref());
    (change.target.as_str(), system, node)
}

/// What a step makes; none for one that makes nothing that people name.
fn fields(step: &Step) -> Option<Vec<FieldChange>> {
    match &step.work {
        Work::StartManager { .. } => Some(vec![added("node", &step.node)]),
        Work::Create {
            manager,
            type_name,
            configuration,
            execution_kind,
            rate,
            execution_context,
            on_disconnect,
            stand_in,
            realtime,
            ..
        } => Some(component(&Made {
            node: &step.node,
            manager: &manager.name,
            type_name,
            configuration,
            execution_kind: *execution_kind,
            rate: *rate,
            execution_context: execution_context.as_ref(),
            on_disconnect: *on_disconnect,
            stand_in: stand_in.is_some(),
            realtime: realtime.clone(),
        })),
        Work::Connect { connector } => Some(self::connector(&connector.spec)),
        _ => None,
    }
}

/// What a component is made with.
pub(crate) struct Made<'a> {
    pub node: &'a str,
    pub manager: &'a str,
    pub type_name: &'a str,
    pub configuration: &'a Configuration,
    pub execution_kind: ExecutionKind,
    pub rate: Option<f64>,
    pub execution_context: Option<&'a SharedExecutionContext>,
    pub on_disconnect: OnDisconnect,
    pub stand_in: bool,
    pub realtime: Option<Realtime>,
}

/// The same as fields, all new.
pub(crate) fn component(made: &Made<'_>) -> Vec<FieldChange> {
    let mut fields = vec![
        added("type", made.type_name),
        added("node", made.node),
        added("manager", made.manager),
    ];
    if made.stand_in {
        fields.push(added("standIn", "true"));
    }
    if made.execution_kind != ExecutionKind::Periodic {
        fields.push(added("executionKind", format!("{:?}", made.execution_kind)));
    }
    if let Some(rate) = made.rate {
        fields.push(added("rate", rate.to_string()));
    }
    if let Some(shared) = made.execution_context {
        fields.push(added("executionContext", &shared.name));
        fields.push(added("executionContext.order", shared.order.to_string()));
    }
    if made.on_disconnect != OnDisconnect::Keep {
        fields.push(added("onDisconnect", made.on_disconnect.as_str()));
    }
    if let Some(realtime) = &made.realtime {
        let resources = resources(realtime).into_iter();
        fields.extend(resources.map(|(field, value)| added(field, value)));
    }
    if let Some(active) = &made.configuration.active {
        fields.push(added("configuration.active", active));
    }
    for (set, values) in &made.configuration.sets {
        for (name, value) in values {
            fields.push(added(format!("configuration.{set}.{name}"), value));
        }
    }
    fields
}

/// What an execution context is to have of its node, by the keys of an overlay. What is as usual is not said.
pub(crate) fn resources(asked: &Realtime) -> Vec<(&'static str, String)> {
    let all = [
        ("resources.cpus", asked.cpus.clone()),
        (
            "resources.realtimePriority",
            asked.priority.map(|priority| priority.to_string()),
        ),
        (
            "resources.lockMemory",
            asked.lock_memory.then(|| "true".to_owned()),
        ),
        (
            "resources.required",
            (!asked.required).then(|| "false".to_owned()),
        ),
    ];
    let said = all.into_iter();
    said.filter_map(|(field, value)| Some((field, value?)))
        .collect()
}

/// What a connector is made with.
pub(crate) fn connector(spec: &ConnectorSpec) -> Vec<FieldChange> {
    let data_type = spec.data_type.iter().map(|id| added("dataType", id));
    let properties = spec.properties.iter();
    let properties = properties.map(|(key, value)| added(format!("properties.{key}"), value));
    data_type.chain(properties).collect()
}

fn added(field: impl Into<String>, new: impl Into<String>) -> FieldChange {
    FieldChange {
        field: field.into(),
        old: None,
        new: Some(new.into()),
    }
}
