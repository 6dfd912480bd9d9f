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
    /// It runs; one that does not is started by what is asked of it.
    pub runs: bool,
}

/// The manager of a display name; one that is not there yet is meant to be started. A system's manager is meant only by
/// its whole name: nothing by hand lands in a system's process by accident.
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
                runs: false,
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
    let found = managers
        .iter()
        .filter(|m| on(m, node) && m.metadata.name == name);
    let found: Vec<_> = found.cloned().collect();
    match found.as_slice() {
        [] => Ok(None),
        [manager] => Ok(Some(place_of(manager))),
        _ => Err(CliError::usage_help(
            format!("manager/{name} could be any of {}", names(&found)),
            "name its node with --node",
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
        runs: true,
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
    fn a_systems_manager_is_meant_only_by_its_whole_name() {
        let managers = [
            manager_named("hello.main", "local"),
            manager_named("bench", "local"),
            manager_named("bench", "arm1"),
        ];
        let choose = |name, node| choose(&managers, name, node);
        let manager = |name, node| choose(name, node).unwrap().map(|place| place.manager);
        assert_eq!(manager("main", None), None);
        assert_eq!(manager("hello.main", None).as_deref(), Some("hello.main"));
        assert_eq!(choose("bench", Some("arm1")).unwrap().unwrap().node, "arm1");
        assert_eq!(manager("leg", None), None);
        let error = choose("bench", None).unwrap_err().to_string();
        assert_eq!(
            error,
            "manager/bench could be any of bench on local, bench on arm1"
        );
    }
}
