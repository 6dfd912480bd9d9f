//! `rtsctl version`.

use rts_controller_api::objects::{Kind, Node};
use rts_host::identity::Identity;

use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Print the versions of rtsctl, and of the controller and the agents that run
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Prints them.
pub async fn run(_: &Args, session: &Session) -> Result<Exit, CliError> {
    let mut text = format!("rtsctl {}\n", env!("CARGO_PKG_VERSION"));
    if let Ok(controller) = session.connect().await {
        let file = session.home.controller_json();
        let version = match &session.controller {
            Some(_) => None,
            None => Identity::read(&file).map(|identity| identity.version),
        };
        if let Some(version) = version.filter(|version| !version.is_empty()) {
            text.push_str(&format!("controller {version}\n"));
        }
        let nodes = controller.list::<Node>(Kind::Node).await;
        let nodes = nodes.map_err(CliError::request("list nodes"))?;
        for node in nodes.items {
            text.push_str(&format!(
                "agent {} {}\n",
                node.metadata.name, node.status.version
            ));
        }
    }
    session.out.result(&text)?;
    Ok(Exit::Ok)
}
