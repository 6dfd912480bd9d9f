//! Whose logs are meant, and on which nodes they are.

use std::collections::BTreeSet;

use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Component, Kind, Node, System};
use serde::de::DeserializeOwned;

use super::Args;
use crate::commands::get::{absent, there_are};
use crate::error::CliError;

/// A component on a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// Node.
    pub node: String,
    /// Instance name.
    pub instance: String,
}

/// The components that are meant.
pub async fn find(args: &Args, controller: &Controller) -> Result<Vec<Target>, CliError> {
    let mut components: Vec<Component> = list(controller, Kind::Component).await?;
    // Nothing of a composite itself runs.
    components.retain(|component| component.spec.composite.is_none());
    if let Some(system) = &args.system {
        return of_system(system, args, &components, controller).await;
    }
    let nodes: Vec<Node> = list(controller, Kind::Node).await?;
    let mut targets: Vec<Target> = Vec::new();
    for name in &args.names {
        let node = match &args.node {
            Some(node) => node.clone(),
            None => place(name, &components, &nodes)?,
        };
        let target = Target {
            node,
            instance: name.clone(),
        };
        if !targets.contains(&target) {
            targets.push(target);
        }
    }
    Ok(targets)
}

async fn of_system(
    system: &str,
    args: &Args,
    components: &[Component],
    controller: &Controller,
) -> Result<Vec<Target>, CliError> {
    let on = |node: &str| args.node.as_deref().is_none_or(|wanted| wanted == node);
    let own = components
        .iter()
        .filter(|c| c.spec.system == system && on(&c.status.node));
    let targets: Vec<_> = own
        .map(|c| Target {
            node: c.status.node.clone(),
            instance: c.metadata.name.clone(),
        })
        .collect();
    if targets.is_empty() {
        let systems: Vec<System> = list(controller, Kind::System).await?;
        let names: Vec<_> = systems.into_iter().map(|s| s.metadata.name).collect();
        let message = if names.iter().any(|name| name == system) {
            format!("system/{system} has no components there")
        } else {
            format!("system/{system} is not there")
        };
        return Err(CliError::usage_help(message, there_are(&names)));
    }
    Ok(targets)
}

/// The node of a component, or the only node: the log of one that is gone may still be there.
fn place(name: &str, components: &[Component], nodes: &[Node]) -> Result<String, CliError> {
    let own = components.iter().filter(|c| c.metadata.name == name);
    let places: BTreeSet<_> = own.map(|c| c.status.node.as_str()).collect();
    let places: Vec<_> = places.into_iter().collect();
    match (places.as_slice(), nodes) {
        ([node], _) => Ok((*node).to_owned()),
        ([], [only]) => Ok(only.metadata.name.clone()),
        ([], _) => Err(not_there(name, components)),
        (several, _) => Err(CliError::usage_help(
            format!(
                "component/{name} is on several nodes: {}",
                several.join(", ")
            ),
            "name one with --node",
        )),
    }
}

/// The error for a component that nobody knows, with those that are there.
fn not_there(name: &str, components: &[Component]) -> CliError {
    let known: Vec<_> = components.iter().map(|c| &c.metadata.name).collect();
    absent(Kind::Component, name, &known)
}

/// The same, asked for when its agent does not know it either.
pub async fn unknown(name: &str, controller: &Controller) -> CliError {
    match list(controller, Kind::Component).await {
        Ok(components) => not_there(name, &components),
        Err(e) => e,
    }
}

async fn list<T: DeserializeOwned>(
    controller: &Controller,
    kind: Kind,
) -> Result<Vec<T>, CliError> {
    let list = controller.list(kind).await;
    let list = list.map_err(CliError::request(format!("list {}", kind.plural())))?;
    Ok(list.items)
}
