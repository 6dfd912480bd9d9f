//! What the verbs that change by hand what runs have in common: how targets are named, how an act is asked for, and what
//! is said of it.

pub mod find;
mod words;

use rts_agent_api::messages::{Act, ActRequest, Acted};
use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Component, Kind, List};
use rts_schemas::system::DriftPolicy;
use serde::de::DeserializeOwned;

use super::or_interrupted;
use crate::cli;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// What is said when the waiting for an act ends before the act.
const GOES_ON: &str = "only the waiting ends: what was asked for may still be done";

/// Components whose state a person changes.
#[derive(Debug, clap::Args)]
pub struct Targets {
    /// Instance names; NODE/NAME where several nodes have one of that name
    #[arg(value_name = "NAME", required = true)]
    names: Vec<String>,
    /// Only say what would be done
    #[arg(long)]
    dry_run: bool,
}

/// Does the same to each component: to none if one of them is not there. All are tried; the first failure gives the exit
/// code.
pub async fn each(
    targets: &Targets,
    act: impl Fn(String) -> Act,
    session: &Session,
) -> Result<Exit, CliError> {
    let hand = Hand::reach(targets.dry_run, session).await?;
    let components: Vec<Component> = hand.list(Kind::Component).await?;
    let (mut exit, mut found) = (Exit::Ok, Vec::new());
    for name in &targets.names {
        let known = find::component(name, &components);
        exit = hand.first(exit, known.map(|component| found.push(component)))?;
    }
    if exit != Exit::Ok {
        if !found.is_empty() {
            session.out.say("rtsctl: nothing was done to the others");
        }
        return Ok(exit);
    }
    let ticks = matches!(act(String::new()), Act::Tick { .. });
    for component in each_member(found, &components, ticks) {
        let done = hand.lead(component, &act).await;
        exit = hand.first(exit, done)?;
    }
    Ok(exit)
}

/// Instead of a composite its members, in their order; of those that are ticked as one, the first.
fn each_member<'a>(
    found: Vec<&'a Component>,
    all: &'a [Component],
    ticks: bool,
) -> Vec<&'a Component> {
    let mut each: Vec<&Component> = Vec::new();
    for component in found {
        let of_system = all
            .iter()
            .filter(|other| other.spec.system == component.spec.system);
        let named = |name: &String| of_system.clone().find(|other| other.metadata.name == *name);
        match &component.spec.composite {
            None => each.push(component),
            Some(composite) => {
                let most = match ticks && composite.kind.shares_context() {
                    true => 1,
                    false => composite.members.len(),
                };
                each.extend(composite.members.iter().filter_map(named).take(most));
            }
        }
    }
    each.dedup_by_key(|component| &component.metadata);
    each
}

/// A person's hand: where acts are asked for.
pub struct Hand<'a> {
    controller: Controller,
    session: &'a Session,
    dry_run: bool,
}

impl<'a> Hand<'a> {
    /// At the controller that runs.
    pub async fn reach(dry_run: bool, session: &'a Session) -> Result<Self, CliError> {
        Ok(Self {
            controller: session.connect().await?,
            session,
            dry_run,
        })
    }

    /// All objects of a kind.
    pub async fn list<T: DeserializeOwned>(&self, kind: Kind) -> Result<Vec<T>, CliError> {
        let list: Result<List<T>, _> = self.controller.list(kind).await;
        let list = list.map_err(CliError::request(format!("list {}", kind.plural())))?;
        Ok(list.items)
    }

    /// The exit code of the first of several, of which this is one. A failure is told; a result that cannot be printed
    /// ends it all.
    pub fn first(&self, exit: Exit, done: Result<(), CliError>) -> Result<Exit, CliError> {
        match done {
            Ok(()) => Ok(exit),
            Err(e @ (CliError::Stdout(_) | CliError::Interrupted)) => Err(e),
            Err(e) => {
                let code = cli::failed(&e, self.session.help(&e), &self.session.out);
                Ok(if exit == Exit::Ok { code } else { exit })
            }
        }
    }

    /// Leads a component into another state.
    async fn lead(
        &self,
        component: &Component,
        act: &impl Fn(String) -> Act,
    ) -> Result<(), CliError> {
        let act = act(component.metadata.name.clone());
        let so = words::is_so(&act, &component.status.state);
        self.act(&component.status.node, act, so, "").await
    }

    /// Asks for an act, and says what came of it. `so`: as far as is known it is so already. `details` follow the result.
    pub async fn act(&self, node: &str, act: Act, so: bool, details: &str) -> Result<(), CliError> {
        let request = ActRequest {
            act,
            dry_run: self.dry_run,
        };
        let acted = async {
            let acted = self.controller.act(node, &request).await;
            acted.map_err(refused(words::attempt(&request.act)))
        };
        let acted = or_interrupted(acted, self.session, GOES_ON).await?;
        self.tell(&request.act, &acted, so, details)
    }

    fn tell(&self, act: &Act, acted: &Acted, so: bool, details: &str) -> Result<(), CliError> {
        let out = &self.session.out;
        // What was known may be old; only what will differ from what is wanted has a policy.
        let done = match (self.dry_run, acted.changed) {
            (true, _) if acted.policy.is_some() || !so => words::Done::Would,
            (false, true) => words::Done::Yes,
            _ => words::Done::Already,
        };
        out.result(&words::result(act, &acted.target, done, details))?;
        let undone = acted.policy == Some(DriftPolicy::Repair);
        for note in &acted.notes {
            if undone {
                out.warn(note);
            } else {
                out.say(&format!("note: {note}"));
            }
        }
        Ok(())
    }
}

/// What the agent calls invalid is what was said on the command line.
fn refused(what: String) -> impl FnOnce(ClientError) -> CliError {
    move |error| match CliError::request(what)(error) {
        invalid if invalid.exit() == Exit::Invalid => CliError::usage(invalid.line()),
        other => other,
    }
}
