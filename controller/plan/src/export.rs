//! Writes into a system what a person changed by hand in it while it ran.

use std::collections::BTreeMap;

use rts_schemas::system::{ComponentSpec, ConnectorSpec, PortKind, PortRef, SystemSpec};

use crate::plan::{Drift, DriftKind, FieldChange};

/// The system as it was desired, with those of its drifts that `which` names; and a note on each that no profile can
/// say. With all of them in, what runs is as desired, but for those notes.
pub fn with_drift(
    spec: &SystemSpec,
    drift: &[Drift],
    which: impl Fn(&Drift) -> bool,
) -> (SystemSpec, Vec<String>) {
    let mut spec = spec.clone();
    let mut notes = Vec::new();
    let own = drift.iter().filter(|drift| drift.system == spec.name);
    let own: Vec<&Drift> = own.filter(|drift| which(drift)).collect();
    let by_target: BTreeMap<&str, &Drift> = own.iter().map(|d| (d.target.as_str(), *d)).collect();
    for component in &mut spec.components {
        let target = crate::target::component(&component.instance);
        if let Some(drift) = by_target.get(target.as_str()) {
            notes.extend(change_component(component, drift));
        }
    }
    spec.connectors.retain_mut(|connector| {
        let target = crate::target::connector(&connector.name);
        let drift = by_target.get(target.as_str());
        if let Some(drift) = drift.filter(|drift| drift.kind == DriftKind::Changed) {
            notes.extend(change_connector(connector, drift));
        }
        drift.is_none_or(|drift| drift.kind != DriftKind::Missing)
    });
    for drift in own.iter().filter(|drift| drift.kind == DriftKind::Extra) {
        match made(&spec, drift) {
            Ok(connector) => spec.connectors.push(connector),
            Err(why) => notes.push(format!("{} {}, and {why}", drift.target, drift.reason)),
        }
    }
    (spec, notes)
}

/// Sets what was found; gives notes on what cannot be set.
fn change_component(component: &mut ComponentSpec, drift: &Drift) -> Vec<String> {
    let mut notes = Vec::new();
    for FieldChange { field, new, .. } in &drift.fields {
        let configuration = &mut component.configuration;
        if field == "configuration.active" {
            configuration.active.clone_from(new);
        } else if let Some(path) = field.strip_prefix("configuration.") {
            // A set's name may hold dots: one that is known already comes first.
            let known = configuration.sets.keys().filter_map(|set| {
                let name = path.strip_prefix(set.as_str())?.strip_prefix('.')?;
                Some((set.clone(), name))
            });
            let first = || {
                path.split_once('.')
                    .map(|(set, name)| (set.to_owned(), name))
            };
            let longest = known.max_by_key(|(set, _)| set.len());
            let Some((set, name)) = longest.or_else(first) else {
                continue;
            };
            let values = configuration.sets.entry(set).or_default();
            match new {
                Some(value) => drop(values.insert(name.to_owned(), value.clone())),
                None => drop(values.remove(name)),
            }
        } else if field == "state" {
            let (instance, state) = (&component.instance, new.as_deref().unwrap_or("not Active"));
            notes.push(format!(
                "component/{instance} is {state}, changed by hand: a profile cannot say so, it is written as one to be Active"
            ));
        }
    }
    notes
}

fn change_connector(connector: &mut ConnectorSpec, drift: &Drift) -> Vec<String> {
    let mut notes = Vec::new();
    for FieldChange { field, new, .. } in &drift.fields {
        if let Some(key) = field.strip_prefix("properties.") {
            match new {
                Some(value) => drop(connector.properties.insert(key.to_owned(), value.clone())),
                None => drop(connector.properties.remove(key)),
            }
        } else {
            let (target, found) = (&drift.target, new.as_deref().unwrap_or("none"));
            notes.push(format!(
                "{target} has {found} as its {field}, changed by hand: it is written as its name says"
            ));
        }
    }
    notes
}

/// The connector that a person made; `Err` says why a profile cannot hold it.
fn made(spec: &SystemSpec, drift: &Drift) -> Result<ConnectorSpec, String> {
    let found = |name: &str| {
        let field = drift.fields.iter().find(|field| field.field == name);
        field
            .and_then(|field| field.new.as_deref())
            .unwrap_or_default()
    };
    let source = end(spec, found("source"))?;
    let target = end(spec, found("target"))?;
    let properties = drift.fields.iter().filter_map(|field| {
        let key = field.field.strip_prefix("properties.")?;
        Some((key.to_owned(), field.new.clone()?))
    });
    let name = drift.target.strip_prefix("connector/");
    let name = name.unwrap_or(&drift.target).to_owned();
    if spec.connectors.iter().any(|other| other.name == name) {
        return Err("another connector has its name".to_owned());
    }
    Ok(ConnectorSpec {
        name,
        kind: PortKind::Data,
        data_type: data_type(spec, &source).or_else(|| data_type(spec, &target)),
        source,
        target,
        properties: properties.collect(),
    })
}

/// `Instance.port` of a component of the system. Instance names may hold dots: the longest that fits is meant.
fn end(spec: &SystemSpec, text: &str) -> Result<PortRef, String> {
    let instances = spec.components.iter().map(|c| c.instance.as_str());
    let ends = instances.filter_map(|instance| {
        let port = text.strip_prefix(instance)?.strip_prefix('.')?;
        Some((instance, port))
    });
    let end = ends.max_by_key(|(instance, _)| instance.len());
    let (instance, port) = end.ok_or_else(|| format!("{text} is not in the system"))?;
    Ok(PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    })
}

fn data_type(spec: &SystemSpec, end: &PortRef) -> Option<String> {
    let mut components = spec.components.iter();
    let component = components.find(|c| c.instance == end.instance)?;
    let port = component.ports.iter().find(|port| port.name == end.port)?;
    port.data_type.clone()
}
