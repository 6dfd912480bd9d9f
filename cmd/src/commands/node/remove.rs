//! `rtsctl node remove`.

use std::time::Duration;

use rts_controller_api::ClientError;

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::lock::HomeLock;
use crate::local::nodes::Nodes;
use crate::local::relays;
use crate::session::Session;

/// Longest wait for the controller.
const PATIENCE: Duration = Duration::from_secs(10);

/// Forget a node that is reached by SSH
///
/// Refused while something of it runs there: take the systems down first. Programs and modules that were copied stay, and
/// are used again when the node is added again.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Name of the node
    node: String,
    /// Also while systems run there, which then go on without anybody who knows of them
    #[arg(long)]
    force: bool,
}

/// Ends its relay and forgets it.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    let home = &session.home;
    let nodes = Nodes::of(home)?;
    if !nodes.by_ssh().any(|node| node.name == args.node) {
        return Err(CliError::usage_help(
            format!(
                "{} is no node of this home that is reached by SSH",
                args.node
            ),
            "`rtsctl node list` shows the nodes",
        ));
    }
    let on_it = format!("on node {})", args.node);
    let mut systems = relays::systems(session).await;
    systems.retain(|system| system.ends_with(&on_it));
    if !systems.is_empty() && !args.force {
        return Err(CliError::usage_help(
            format!("still running: {}", systems.join(", ")),
            "take them down with `rtsctl teardown`, or leave them there with --force",
        ));
    }
    let _lock = HomeLock::take(home)?;
    Nodes::of(home)?.without(&args.node).save(home)?;
    relays::stop(home, &args.node);
    forget(session, &args.node).await?;
    session.out.result(&format!("node/{} removed", args.node))?;
    Ok(Exit::Ok)
}

/// The controller, if it runs, no longer shows the node. One on which systems went on is shown until they are gone.
async fn forget(session: &Session, node: &str) -> Result<(), CliError> {
    if !session.local_answers().await? {
        return Ok(());
    }
    match session.local(PATIENCE)?.forget_node(node).await {
        Ok(()) => Ok(()),
        // It had never greeted.
        Err(ClientError::Problem(problem)) if problem.status == 404 => Ok(()),
        Err(e) => {
            session
                .out
                .warn(&format!("node {node} is still shown: {e}"));
            Ok(())
        }
    }
}
