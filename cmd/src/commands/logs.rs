//! `rtsctl logs`.

use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Component, Kind, Node};

use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Print the last lines of a component's log
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Instance name of the component
    instance: String,
    /// Number of lines
    #[arg(long, value_name = "N", default_value_t = 100)]
    tail: usize,
    /// Node that it runs on [default: where it is found]
    #[arg(long, value_name = "NODE")]
    node: Option<String>,
}

/// Prints the lines.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let instance = &args.instance;
    let node = match args.node {
        Some(node) => node,
        None => find(&controller, instance).await?,
    };
    let log = controller.log(&node, instance, args.tail).await;
    let log = log.map_err(CliError::request(format!(
        "read the log of component/{instance}"
    )))?;
    session.out.result(&log)?;
    Ok(Exit::Ok)
}

/// The node of a component, or the only node: the log of one that is gone may still be there.
async fn find(controller: &Controller, instance: &str) -> Result<String, CliError> {
    let components = controller.list::<Component>(Kind::Component).await;
    let components = components.map_err(CliError::request("list components"))?;
    let mut places: Vec<_> = components
        .items
        .into_iter()
        .filter(|c| c.metadata.name == instance)
        .map(|c| c.status.node)
        .collect();
    places.sort();
    places.dedup();
    if places.is_empty() {
        let nodes = controller.list::<Node>(Kind::Node).await;
        let nodes = nodes.map_err(CliError::request("list nodes"))?;
        places.extend(nodes.items.into_iter().map(|n| n.metadata.name));
        if places.len() != 1 {
            return Err(CliError::usage_help(
                format!("component/{instance} is not there"),
                "see `rtsctl get components`, or name its node with --node",
            ));
        }
    }
    match places.as_slice() {
        [node] => Ok(node.clone()),
        _ => Err(CliError::usage_help(
            format!(
                "component/{instance} is on several nodes: {}",
                places.join(", ")
            ),
            "name one with --node",
        )),
    }
}
