//! `cargo xtask bench launch`: from a command to all components Active, by our agent and by SSH, beside what nothing can beat.

mod corpus;
mod profile;
mod ssh_loop;

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Result;
use rts_test_sshd::{Server, Setup};

use self::profile::Profile;
use super::Common;
use super::stack::Stack;
use super::{floors, stats};
use crate::tools;

/// Components of the rows that have many.
const MANY: u32 = 10;
/// Type of every component: it has no ports to connect, so that only launching is measured.
pub const TYPE: &str = "ConfigSample";
/// File of its module.
pub const MODULE: &str = "libconfig_sample.so";

/// Arguments of `cargo xtask bench launch`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Leave out what needs an SSH server.
    #[arg(long)]
    no_ssh: bool,
    #[command(flatten)]
    common: Common,
}

/// What is measured in one go: rows, and the time of each.
struct Case<'a> {
    rows: Vec<String>,
    components: u32,
    measure: Box<dyn FnMut() -> Result<Vec<Duration>> + 'a>,
}

impl<'a> Case<'a> {
    fn one(row: &str, components: u32, mut run: impl FnMut() -> Result<Duration> + 'a) -> Self {
        Self {
            rows: vec![row.to_owned()],
            components,
            measure: Box::new(move || Ok(vec![run()?])),
        }
    }
}

/// Measures all rows, interleaved run by run, and prints them.
pub fn run(args: &Args) -> Result<()> {
    let (profile, programs) = args.common.programs()?;
    let server = match args.no_ssh {
        true => None,
        false => {
            tools::sshd()?;
            Some(Server::start(Setup::default())?)
        }
    };
    let stack = Stack::start(&programs)?;
    let mut cases = agent(&stack)?;
    cases.extend(corpus::cases(&stack)?);
    if let Some(server) = &server {
        cases.extend(ssh(server, &stack, &programs));
    }
    cases.extend(floor(&stack, &programs));
    let rows = stats::take_turns(&mut cases, args.common.runs)?;
    drop(cases);
    stack.stop()?;
    if !args.common.json {
        println!("{profile} build, `rtsctl` included in the rows of agent and system");
    }
    stats::print(&rows, args.common.json)
}

impl stats::Turn for Case<'_> {
    fn rows(&self) -> (&[String], u32) {
        (&self.rows, self.components)
    }

    fn run(&mut self) -> Result<Vec<Duration>> {
        (self.measure)()
    }
}

/// `rtsctl apply` on a running stack.
fn agent(stack: &Stack) -> Result<Vec<Case<'_>>> {
    let folder = stack.folder.path();
    let one = Profile::new("one", 1, true).write(folder)?;
    let resident = Profile::new("added", 1, false).write(folder)?;
    let added = Profile::new("added", 2, false).write_as("added-to", folder)?;
    let same = Profile::new("same", MANY, false).write(folder)?;
    let separate = Profile::new("separate", MANY, true).write(folder)?;
    Ok(vec![
        Case::one("agent-1-same", 1, move || {
            apply(stack, &resident)?;
            let took = apply(stack, &added);
            teardown(stack, "added")?;
            took
        }),
        case("agent-1-separate", 1, stack, "one", one),
        case("agent-10-same", MANY, stack, "same", same),
        case("agent-10-separate", MANY, stack, "separate", separate),
    ])
}

fn case<'a>(
    row: &str,
    components: u32,
    stack: &'a Stack,
    system: &'static str,
    file: PathBuf,
) -> Case<'a> {
    Case::one(row, components, move || {
        let took = apply(stack, &file);
        teardown(stack, system)?;
        took
    })
}

/// The manager of each component started by SSH.
fn ssh<'a>(server: &'a Server, stack: &'a Stack, programs: &'a Path) -> Vec<Case<'a>> {
    let row = |row, components, at_once| {
        Case::one(row, components, move || {
            ssh_loop::launch(server, programs, stack.folder.path(), components, at_once)
        })
    };
    vec![
        row("ssh-loop-1", 1, false),
        row("ssh-loop-10", MANY, false),
        row("ssh-at-once-10", MANY, true),
    ]
}

/// What no launcher can beat.
fn floor<'a>(stack: &'a Stack, programs: &Path) -> Vec<Case<'a>> {
    let folder = stack.folder.path();
    let (module, manager) = (programs.join(MODULE), programs.join("rts-manager"));
    vec![
        Case::one("floor-dlopen", MANY, move || {
            floors::dlopen_and_create(&module, folder, MANY)
        }),
        Case::one("floor-spawn", MANY, move || {
            floors::spawn_until_answer(&manager, folder, MANY)
        }),
    ]
}

fn apply(stack: &Stack, file: &Path) -> Result<Duration> {
    stack.timed(&["apply", &file.to_string_lossy()])
}

fn teardown(stack: &Stack, system: &str) -> Result<Duration> {
    stack.timed(&["teardown", system, "--yes"])
}
