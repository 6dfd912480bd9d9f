//! Which manager process on which node a person means.

use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Kind, Manager, Node};

use crate::error::CliError;
use crate::local::LOCAL_NODE;

/// A manager and its node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Node name.
    pub node: String,
    /// Display name (`hello.main`).
    pub manager: String,
}

/// The manager of a display name, else of a short name; one that is not there yet is meant to be started.
pub async fn manager(
    controller: &Controller,
    name: &str,
    node: Option<&str>,
) -> Result<Place, CliError> {
    match choose(&managers(controller).await?, name, node)? {
        Some(place) => Ok(place),
        None => {
            let node = match node {
                Some(node) => node.to_owned(),
                None => only_node(controller).await?,
            };
            Ok(Place {
                node,
                manager: name.to_owned(),
            })
        }
    }
}

/// The manager that holds a component.
pub async fn component(
    controller: &Controller,
    instance: &str,
    node: Option<&str>,
) -> Result<Place, CliError> {
    let mut managers = managers(controller).await?;
    managers.retain(|m| m.status.components.iter().any(|c| c == instance) && on(m, node));
    let help = "see `rtsctl get components`, or name --node and --manager";
    match managers.as_slice() {
        [manager] => Ok(place_of(manager)),
        [] => Err(CliError::usage_help(
            format!("component/{instance} is not there"),
            help,
        )),
        _ => Err(CliError::usage_help(
            format!(
                "component/{instance} is in several managers: {}",
                names(&managers)
            ),
            help,
        )),
    }
}

async fn managers(controller: &Controller) -> Result<Vec<Manager>, CliError> {
    let list = controller.list::<Manager>(Kind::Manager).await;
    Ok(list.map_err(CliError::request("list managers"))?.items)
}

fn choose(managers: &[Manager], name: &str, node: Option<&str>) -> Result<Option<Place>, CliError> {
    let fits = |short: bool| {
        let fits_name = move |full: &str| {
            full == name || (short && full.rsplit_once('.').is_some_and(|(_, last)| last == name))
        };
        let found = managers.iter().filter(|m| on(m, node));
        found
            .filter(|m| fits_name(&m.metadata.name))
            .cloned()
            .collect::<Vec<_>>()
    };
    let exact = fits(false);
    let found = if exact.is_empty() { fits(true) } else { exact };
    match found.as_slice() {
        [] => Ok(None),
        [manager] => Ok(Some(place_of(manager))),
        _ => Err(CliError::usage_help(
            format!("manager/{name} could be any of {}", names(&found)),
            "write its whole name, or name its node with --node",
        )),
    }
}

fn on(manager: &Manager, node: Option<&str>) -> bool {
    node.is_none_or(|node| manager.status.node == node)
}

fn place_of(manager: &Manager) -> Place {
    Place {
        node: manager.status.node.clone(),
        manager: manager.metadata.name.clone(),
    }
}

fn names(managers: &[Manager]) -> String {
    let name = |m: &Manager| format!("{} on {}", m.metadata.name, m.status.node);
    managers.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// The node, when there is no choice; `local` among several.
async fn only_node(controller: &Controller) -> Result<String, CliError> {
    let nodes = controller.list::<Node>(Kind::Node).await;
    let nodes = nodes.map_err(CliError::request("list nodes"))?;
    let names: Vec<_> = nodes.items.into_iter().map(|n| n.metadata.name).collect();
    match names.as_slice() {
        [node] => Ok(node.clone()),
        _ if names.iter().any(|n| n == LOCAL_NODE) => Ok(LOCAL_NODE.to_owned()),
        _ => Err(CliError::usage_help(
            "no node is named and there is no single one",
            format!("name one with --node: {}", names.join(", ")),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::{lists::typed, samples};

    fn manager_named(name: &str, node: &str) -> Manager {
        let mut manager = typed(Kind::Manager, &samples::values(Kind::Manager)).unwrap();
        let mut manager: Manager = manager.remove(0);
        manager.metadata.name = name.to_owned();
        manager.status.node = node.to_owned();
        manager
    }

    #[test]
    fn a_whole_name_wins_and_a_short_one_must_be_clear() {
        let managers = [
            manager_named("main", "local"),
            manager_named("hello.main", "local"),
            manager_named("hello.arm", "local"),
            manager_named("bye.arm", "arm1"),
        ];
        let choose = |name, node| choose(&managers, name, node);
        let manager = |name, node| choose(name, node).unwrap().unwrap().manager;
        assert_eq!(manager("main", None), "main");
        assert_eq!(manager("hello.main", None), "hello.main");
        assert_eq!(manager("arm", Some("arm1")), "bye.arm");
        assert_eq!(choose("leg", None).unwrap(), None);
        let error = choose("arm", None).unwrap_err().to_string();
        assert_eq!(
            error,
            "manager/arm could be any of hello.arm on local, bye.arm on arm1"
        );
    }
}
