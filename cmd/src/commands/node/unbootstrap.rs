//! `rtsctl node unbootstrap`.

use rts_ssh::Destination;
use rts_ssh::bootstrap::remove;
use serde_json::json;

use super::bootstrap::{Format, open};
use super::reach::{ReachArgs, node_name};
use crate::commands::or_interrupted;
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::nodes::Nodes;
use crate::local::relays;
use crate::session::Session;

/// Said when Ctrl-C ends it.
const AGAIN: &str = "run the same again to remove the rest";

/// Remove an agent that `node bootstrap` installed, and all that it keeps
///
/// Its service, programs, modules, state and logs. Managers that still run are stopped only with `--yes`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The machine.
    #[command(flatten)]
    reach: ReachArgs,
    /// Name of the node [default: the name that the machine has for itself]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Stop managers that still run
    #[arg(short, long)]
    yes: bool,
    /// Only say what would be done
    #[arg(long)]
    dry_run: bool,
    /// How to print
    #[arg(short, long, value_name = "FORMAT", default_value = "text")]
    output: Format,
}

/// Removes it.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let destination = args.reach.settle()?;
    let work = async {
        let ssh = open(&destination, session).await?;
        let survey = ssh.survey().await?;
        let node = node_name(args.name, &survey)?;
        let removed = remove(&ssh, &survey, &node, args.yes, args.dry_run).await?;
        ssh.close().await;
        let text = match (removed.done.is_empty(), args.output) {
            (_, Format::Json) => {
                let object = json!({
                    "node": node,
                    "host": destination.to_string(),
                    "home": removed.service.home,
                    "changed": !removed.done.is_empty() && !args.dry_run,
                    "dryRun": args.dry_run,
                    "changes": removed.done,
                    "left": removed.left,
                    "notes": removed.told,
                });
                format!("{object:#}")
            }
            (true, _) => {
                format!("node/{node} is not installed on {destination}: nothing to remove")
            }
            (false, _) if args.dry_run => {
                let lines = removed.done.iter().map(|done| format!("would {done}\n"));
                lines.collect()
            }
            (false, _) => format!("node/{node} removed from {destination}"),
        };
        session.out.result(&text)?;
        if !args.dry_run {
            part(session, &node, &destination)?;
        }
        for why in &removed.told {
            session.out.warn(why);
        }
        if let Some(left) = &removed.left {
            let home = &removed.service.home;
            session.out.say(&format!(
                "rtsctl: left alone in {home}, as it is of others: {left}"
            ));
        }
        Ok(Exit::Ok)
    };
    or_interrupted(work, session, AGAIN).await
}

/// Where this home had joined the agent, its relay ends: what was told through it is of before.
fn part(session: &Session, node: &str, machine: &Destination) -> Result<(), CliError> {
    let nodes = Nodes::of(&session.home)?;
    let joined = nodes.by_ssh().find(|known| {
        let reached = known.ssh.as_ref().map(|ssh| &ssh.destination);
        let same = |d: &&Destination| (&d.host, &d.user) == (&machine.host, &machine.user);
        known.name == node && reached.filter(same).is_some()
    });
    if joined.is_some() {
        relays::stop(&session.home, node);
        session.out.say(&format!(
            "rtsctl: {node} is still a node of this home: the next command reaches it by SSH alone, and what it should run starts \
             again; `rtsctl node remove {node}` forgets it"
        ));
    }
    Ok(())
}
