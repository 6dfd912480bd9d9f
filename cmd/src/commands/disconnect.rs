//! `rtsctl disconnect`.

use std::collections::BTreeSet;

use rts_agent_api::messages::Act;
use rts_controller_api::objects::{Component, Connector, Kind};

use super::by_hand::{Hand, find};
use super::get::absent;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Remove connectors by hand (rtdis)
///
/// Of two ports, all connectors between them; of one port, all of its connectors. What becomes of it in a system is for
/// `rtsctl.drift` to say: by default the controller connects them again.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A port (`Sine0.out`), or a connector: NAME, or SYSTEM/NAME where several systems have one of that name
    #[arg(value_name = "PORT|CONNECTOR")]
    what: String,
    /// The other port
    #[arg(value_name = "PORT")]
    other: Option<String>,
    /// Only say what would be done
    #[arg(long)]
    dry_run: bool,
}

/// Removes them. All are tried; the first failure gives the exit code.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let hand = Hand::reach(args.dry_run, session).await?;
    let components: Vec<Component> = hand.list(Kind::Component).await?;
    let connectors: Vec<Connector> = hand.list(Kind::Connector).await?;
    let mut exit = Exit::Ok;
    for connector in meant(&args, &components, &connectors)? {
        let done = remove(connector, &components, &hand).await;
        exit = hand.first(exit, done)?;
    }
    Ok(exit)
}

async fn remove(
    connector: &Connector,
    components: &[Component],
    hand: &Hand<'_>,
) -> Result<(), CliError> {
    let name = &connector.metadata.name;
    let Some(source) = find::source(connector, components) else {
        let message = format!("connector/{name}: the component of its out-port is not there");
        return Err(CliError::usage(message));
    };
    let act = Act::Disconnect {
        instance: source.metadata.name.clone(),
        connector: name.clone(),
    };
    let so = connector.status.state == "Disconnected";
    hand.act(&source.status.node, act, so, "").await
}

/// The connectors that are meant, at least one, all of one system.
fn meant<'a>(
    args: &Args,
    components: &[Component],
    connectors: &'a [Connector],
) -> Result<Vec<&'a Connector>, CliError> {
    let found = match &args.other {
        Some(other) => between(&args.what, other, components, connectors)?,
        None => match find::connectors(&args.what, connectors) {
            none if none.is_empty() => of_port(&args.what, components, connectors)?,
            named => named,
        },
    };
    let systems: BTreeSet<_> = found.iter().map(|c| &c.spec.system).collect();
    if systems.len() > 1 {
        let name = |c: &&Connector| format!("{}/{}", c.spec.system, c.metadata.name);
        let names: Vec<_> = found.iter().map(name).collect();
        return Err(CliError::usage_help(
            "connectors of several systems are meant",
            format!("name one: {}", names.join(", ")),
        ));
    }
    Ok(found)
}

fn between<'a>(
    a: &str,
    b: &str,
    components: &[Component],
    connectors: &'a [Connector],
) -> Result<Vec<&'a Connector>, CliError> {
    let (a, b) = (find::end(a, components)?, find::end(b, components)?);
    let joins = |c: &&Connector| (a.sends(c) && b.receives(c)) || (b.sends(c) && a.receives(c));
    let found: Vec<_> = connectors.iter().filter(joins).collect();
    if found.is_empty() {
        let touches = |c: &&Connector| [&a, &b].iter().any(|end| end.sends(c) || end.receives(c));
        let names = connectors.iter().filter(touches);
        return Err(none_at(
            &format!("between {} and {}", a.port, b.port),
            names,
        ));
    }
    Ok(found)
}

/// All connectors of a port.
fn of_port<'a>(
    text: &str,
    components: &[Component],
    connectors: &'a [Connector],
) -> Result<Vec<&'a Connector>, CliError> {
    let Ok(end) = find::end(text, components) else {
        let known: Vec<_> = connectors.iter().map(|c| &c.metadata.name).collect();
        return Err(absent(Kind::Connector, text, &known));
    };
    let touches = |c: &&Connector| end.sends(c) || end.receives(c);
    let found: Vec<_> = connectors.iter().filter(touches).collect();
    if found.is_empty() {
        return Err(none_at(&format!("at {}", end.port), std::iter::empty()));
    }
    Ok(found)
}

fn none_at<'a>(place: &str, others: impl Iterator<Item = &'a Connector>) -> CliError {
    let others: Vec<_> = others.map(|c| c.metadata.name.as_str()).collect();
    let help = if others.is_empty() {
        "see `rtsctl get connectors -o wide`".to_owned()
    } else {
        format!("there are: {}", rts_schemas::suggest::listed(others))
    };
    CliError::usage_help(format!("there is no connector {place}"), help)
}
