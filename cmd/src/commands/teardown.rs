//! `rtsctl teardown`.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Kind, Node, System};

use super::apply::list_unfinished;
use super::get::there_are;
use super::{ask, can_ask, duration, goes_on, or_interrupted};
use crate::error::CliError;
use crate::exit::Exit;
use crate::follow::Follower;
use crate::local::plural;
use crate::local::relays::{self, Patience};
use crate::session::Session;
use crate::show::progress::Progress;
use crate::show::timings;
use crate::timings::Laps;

/// How long a node must have been out of reach before it is no longer waited for.
const OUT_OF_REACH: Duration = Duration::from_secs(3);

/// Take a system down, and wait until everything has really stopped
///
/// A node that cannot be reached is named, and the exit code is 5: the controller takes its part down when it comes back.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Name of the system
    name: String,
    /// Do not ask
    #[arg(short, long)]
    yes: bool,
    /// Do not wait for an Unknown node that will not come back; if it does, its part is stopped. Can be repeated
    #[arg(long, value_name = "NODE")]
    forget_node: Vec<String>,
    /// How long to wait; the controller goes on after that
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    timeout: Duration,
    /// Show where the time went: what was waited for, in rtsctl, the controller and the agents
    #[arg(long)]
    timings: bool,
}

/// Asks, deletes, and follows until the system is gone.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let mut laps = Laps::default();
    let timings = args.timings;
    let outcome = teardown(args, session, &mut laps).await;
    match timings {
        true => laps.told(outcome, session).await,
        false => outcome,
    }
}

async fn teardown(args: Args, session: &Session, laps: &mut Laps) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    laps.lap("connect");
    let name = &args.name;
    if !(args.yes && args.forget_node.is_empty()) {
        check(&args, &controller).await?;
        laps.lap("find");
    }
    let start = Instant::now();
    let deleted = controller.delete_but(name, &args.forget_node).await;
    let deleted = deleted.map_err(failed(name))?;
    let components = plural("component", deleted.spec.components.len());
    let goes_on = goes_on(name, &deleted.status.nodes);
    laps.lap(timings::TEARDOWN);
    let wait = wait(deleted, start + args.timeout, &controller, session);
    let gone = or_interrupted(wait, session, &goes_on).await;
    laps.lap(timings::FOLLOW);
    match gone? {
        None => {
            let seconds = start.elapsed().as_secs_f64();
            let text = match args.forget_node.as_slice() {
                [] => format!("system/{name} is gone: {components} stopped ({seconds:.2} s)"),
                nodes => {
                    let nodes = nodes.join(", ");
                    format!("system/{name} is gone; what it has on {nodes} was not waited for")
                }
            };
            session.out.result(&text)?;
            Ok(Exit::Ok)
        }
        Some(system) if !system.status.tombstones.is_empty() => {
            let silent = &system.status.tombstones;
            let others = silent.iter().filter(|node| !relays::is_away(node));
            out_of_reach(name, others, session);
            match relays::away(silent) {
                Some(away) => Err(away.into()),
                None => Ok(Exit::Partly),
            }
        }
        Some(system) => {
            list_unfinished(&system, session);
            if let Some(away) = relays::away(&system.status.nodes) {
                return Err(away.into());
            }
            Err(CliError::Deadline {
                system: name.clone(),
                goal: "gone",
                seconds: args.timeout.as_secs_f64(),
                nodes: system.status.nodes.into(),
            })
        }
    }
}

/// Looks at the system before it is touched: its nodes are known, and whoever can be asked agrees.
async fn check(args: &Args, controller: &Controller) -> Result<(), CliError> {
    let name = &args.name;
    let system = controller.system(name).await.map_err(failed(name))?;
    nodes_are_known(&args.forget_node, &system, controller).await?;
    if args.yes {
        return Ok(());
    }
    let components = plural("component", system.spec.components.len());
    confirm(name, &components)
}

/// What was tried: a system that is not there was looked for in vain.
fn failed(name: &str) -> impl FnOnce(ClientError) -> CliError {
    move |error| {
        let is_missing = matches!(&error, ClientError::Problem(problem) if problem.status == 404);
        let what = if is_missing { "find" } else { "take down" };
        CliError::request(format!("{what} system/{name}"))(error)
    }
}

/// A node that nobody has heard of is a slip of the pen.
async fn nodes_are_known(
    names: &[String],
    system: &System,
    controller: &Controller,
) -> Result<(), CliError> {
    if names.is_empty() {
        return Ok(());
    }
    let list = controller.list::<Node>(Kind::Node).await;
    let list = list.map_err(CliError::request("list nodes"))?;
    let listed = list.items.into_iter().map(|node| node.metadata.name);
    let left = system.status.tombstones.iter().cloned();
    let known: BTreeSet<String> = listed.chain(left).collect();
    match names.iter().find(|name| !known.contains(*name)) {
        None => Ok(()),
        Some(name) => Err(CliError::usage_help(
            format!("node/{name} is not there"),
            there_are(&known.into_iter().collect::<Vec<_>>()),
        )),
    }
}

/// Says which nodes could not be asked, and how to go on without them.
fn out_of_reach<'a>(name: &str, nodes: impl Iterator<Item = &'a String>, session: &Session) {
    let lacking = session.lacking();
    for node in nodes {
        let up = if lacking.contains(node) {
            "; `rtsctl up` starts its agent again"
        } else {
            ""
        };
        session.out.stderr(&format!(
            "rtsctl: system/{name} has stopped but on node/{node}, which cannot be reached: its part is taken down when it \
             comes back{up}; `rtsctl teardown {name} --forget-node {node}` does without it"
        ));
    }
}

fn confirm(name: &str, components: &str) -> Result<(), CliError> {
    if !can_ask() {
        return Err(CliError::usage_help(
            format!("system/{name} would be taken down with its {components}"),
            "say --yes where nobody can be asked",
        ));
    }
    if ask(&format!("Take down system/{name} with its {components}?")) {
        Ok(())
    } else {
        Err(CliError::usage("nothing was taken down"))
    }
}

/// `None` once it is gone; its last state when time is up before, or when only nodes out of reach are waited for.
pub async fn wait(
    from: System,
    deadline: Instant,
    controller: &Controller,
    session: &Session,
) -> Result<Option<System>, CliError> {
    let name = from.metadata.name.clone();
    let mut progress = Progress::start(session.out, &format!("system/{name}: taking down"));
    let mut follower = Follower::new(controller, &from);
    let mut last = from;
    let mut since = None;
    let mut patience = Patience::default();
    let end = follower.until(deadline, |state| match state {
        None => ControlFlow::Break(true),
        Some(system) => {
            progress.system(&system);
            last = system;
            let silent = &last.status.tombstones;
            // A session that was lost is made anew, and then it goes on.
            if patience.with(silent) || silent.is_empty() {
                since = None;
                return ControlFlow::Continue(());
            }
            let given_up = relays::given_up(silent).is_some();
            if given_up || since.get_or_insert_with(Instant::now).elapsed() >= OUT_OF_REACH {
                ControlFlow::Break(false)
            } else {
                ControlFlow::Continue(())
            }
        }
    });
    let end = end.await;
    let end = end.map_err(CliError::request(format!("follow system/{name}")))?;
    Ok((end != Some(true)).then_some(last))
}
