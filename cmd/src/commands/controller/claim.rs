//! `rtsctl controller adopt` and `take-over`: a node that another controller's store told what to run.

use rts_agent_api::messages::LedgerFence;
use rts_controller_api::requests::{NodeClaimed, TakeOver};

use super::confirm;
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::plural;
use crate::session::Session;

/// Make what runs on a node of another controller this one's
///
/// Nothing restarts. The node's systems are known here under their names and identities, and obey this controller from
/// then on.
#[derive(Debug, clap::Args)]
pub struct AdoptArgs {
    /// Node
    node: String,
}

/// Put this controller's set in the place of what a node runs for another one
///
/// What the other controller's systems run there is stopped. Only what was shown before the question is replaced: when the
/// node was told something else meanwhile, nothing happens.
#[derive(Debug, clap::Args)]
pub struct TakeOverArgs {
    /// Node
    node: String,
    /// Do not ask
    #[arg(short, long)]
    yes: bool,
}

/// Adopts, and says what.
pub async fn adopt(args: &AdoptArgs, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let node = &args.node;
    let claimed = controller.adopt(node).await;
    let claimed = claimed.map_err(CliError::request(format!("adopt node/{node}")))?;
    session.out.result(&adopted(&claimed))?;
    Ok(Exit::Ok)
}

/// Shows the ledger, asks, and takes over.
pub async fn take_over(args: &TakeOverArgs, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let node = &args.node;
    let found = controller.node(node).await;
    let status = found
        .map_err(CliError::request(format!("find node/{node}")))?
        .status;
    let Some(ledger) = status.ledger else {
        let text = format!("node/{node} is this controller's already");
        session.out.result(&text)?;
        return Ok(Exit::Ok);
    };
    let (count, whose) = (
        plural("component", status.components as usize),
        words(&ledger),
    );
    confirm(
        args.yes,
        &format!("Replace what node/{node} runs ({count}) for {whose}?"),
        &format!("what node/{node} runs ({count}) for {whose} would be replaced"),
    )?;
    let request = TakeOver { confirm: ledger };
    let claimed = controller.take_over(node, &request).await;
    claimed.map_err(CliError::request(format!("take node/{node} over")))?;
    let text = format!("node/{node} is this controller's: what {whose} ran there is replaced");
    session.out.result(&text)?;
    Ok(Exit::Ok)
}

fn adopted(claimed: &NodeClaimed) -> String {
    let node = &claimed.node;
    if !claimed.changed {
        return format!("node/{node} is this controller's already");
    }
    let count = plural("system", claimed.systems.len());
    match claimed.systems.as_slice() {
        [] => format!("node/{node} adopted: it runs no system"),
        names => format!("node/{node} adopted with {count}: {}", names.join(", ")),
    }
}

fn words(ledger: &LedgerFence) -> String {
    format!("cluster {}, epoch {}", ledger.cluster_uid, ledger.epoch)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_adopted_is_said() {
        let mut claimed = NodeClaimed {
            node: "local".to_owned(),
            changed: true,
            ledger: None,
            systems: vec!["hello".to_owned(), "arm".to_owned()],
        };
        insta::assert_snapshot!(adopted(&claimed), @"node/local adopted with 2 systems: hello, arm");
        claimed.systems.clear();
        insta::assert_snapshot!(adopted(&claimed), @"node/local adopted: it runs no system");
        claimed.changed = false;
        insta::assert_snapshot!(adopted(&claimed), @"node/local is this controller's already");
    }
}
