//! `rtsctl node remove`.

use std::time::Duration;

use rts_controller_api::ClientError;
use rts_host::error::chain;
use rts_ssh::{Claim, Destination, Session as Ssh};

use super::reach::control_folder;
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::lock::HomeLock;
use crate::local::nodes::Nodes;
use crate::local::{plural, relays};
use crate::session::Session;

/// Longest wait for the controller, and for the machine.
const PATIENCE: Duration = Duration::from_secs(10);

/// Forget a node that is reached by SSH
///
/// Refused while something of it runs there: take the systems down first. Programs and modules that were copied there and that
/// nobody else needs are removed.
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
    let known = nodes.named(&args.node).and_then(|node| node.ssh.clone());
    let Some(ssh) = known else {
        return Err(CliError::usage_help(
            format!(
                "{} is no node of this home that is reached by SSH",
                args.node
            ),
            "`rtsctl node list` shows the nodes",
        ));
    };
    let on_it = format!("on node {})", args.node);
    let mut systems = relays::systems(session).await;
    systems.retain(|system| system.ends_with(&on_it));
    if !systems.is_empty() && !args.force {
        return Err(CliError::usage_help(
            format!("still running: {}", systems.join(", ")),
            "take them down with `rtsctl teardown`, or leave them there with --force",
        ));
    }
    let lock = HomeLock::take(home)?;
    Nodes::of(home)?.without(&args.node).save(home)?;
    relays::stop(home, &args.node);
    forget(session, &args.node).await?;
    drop(lock);
    if let Err(why) = collect(session, &args.node, &ssh.destination).await {
        session.out.warn(&format!(
            "what was copied to {} stays there until somebody else reaches it: {why}",
            ssh.destination
        ));
    }
    session.out.result(&format!("node/{} removed", args.node))?;
    Ok(Exit::Ok)
}

/// Ends the lease of the node's copies over there; the machine may be gone for good.
async fn collect(session: &Session, node: &str, machine: &Destination) -> Result<(), String> {
    let work = async {
        let ssh = Ssh::open(machine, &control_folder(&session.home)).await?;
        let home = ssh.survey().await?.rtsctl_home();
        let lease = rts_relay::lease(session.home.path(), node);
        let collected = ssh.collect(&home, Claim::End(&lease)).await;
        ssh.close().await;
        collected
    };
    match tokio::time::timeout(PATIENCE, work).await {
        Ok(Ok(collected)) if !collected.told.is_empty() => Err(collected.told.join("; ")),
        Ok(Ok(collected)) => {
            let digests = plural("digest", collected.removed);
            let text = format!("rtsctl: removed the files of {digests} from {machine}");
            session.out.detail(&text);
            Ok(())
        }
        Ok(Err(e)) => Err(chain(&e)),
        Err(_) => Err(format!(
            "it does not answer within {} s",
            PATIENCE.as_secs()
        )),
    }
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
