//! The arguments of the whole program, and which verb they mean.

mod frequent;

use std::path::PathBuf;

use clap::builder::{OsStringValueParser, TypedValueParser};
use clap::{ArgAction, Parser, Subcommand, ValueEnum};

use crate::commands::{
    activate, apply, check, completion, conf, connect, controller, convert, deactivate, describe,
    diff, disconnect, docs, down, events, explain, export, fmt, get, idl, logs, manager, node,
    plan, port, reset, schema, smoke, teardown, tick, top, up, version,
};
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::LocalError;
use crate::output::Output;
use crate::session::{Session, home};

/// Deploys systems of RT-Components and keeps them running
///
/// A system is described by an RTS Profile. `rtsctl apply FILE` starts what is missing, changes what differs, stops what
/// is no longer wanted, and ends when everything runs.
#[derive(Debug, Parser)]
#[command(name = "rtsctl", version, propagate_version = false)]
#[command(after_long_help = EXIT_CODES)]
pub struct Cli {
    /// Options of every verb.
    #[command(flatten)]
    pub globals: Globals,
    /// The verb.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Reads the arguments of the program.
    pub fn read() -> Result<Self, clap::Error> {
        frequent::read(std::env::args_os()).map_or_else(Self::try_parse, Ok)
    }
}

/// The exit codes in words.
pub const EXIT_CODES: &str = "\
Exit status:
  0    done; no difference
  1    only: differences or problems were found (diff, check, smoke)
  2    wrong usage, or the output cannot be written
  3    the profile or the plan is invalid
  4    the controller or an agent cannot be reached
  5    partly applied
  6    the deadline passed
  7    conflict with what is there, or a stale plan
  8    not authorised
  9    refused by a safety gate (--no-restart)
  130  interrupted
  141  the reader of the output went away";

/// Options of every verb. An empty path counts as none. Variables are read by [`Session::new`]: clap would list those that
/// are set in each usage line.
#[derive(Debug, Clone, clap::Args)]
pub struct Globals {
    /// Folder of the local stack [env: RTSCTL_HOME] [default: $XDG_STATE_HOME/rtsctl]
    #[arg(
        long,
        global = true,
        value_name = "DIR",
        value_parser = OsStringValueParser::new().map(PathBuf::from)
    )]
    pub home: Option<PathBuf>,
    /// Unix socket of the controller [env: RTSCTL_CONTROLLER] [default: the local one]
    #[arg(
        long,
        global = true,
        value_name = "SOCKET",
        value_parser = OsStringValueParser::new().map(PathBuf::from)
    )]
    pub controller: Option<PathBuf>,
    /// When to use colour
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    pub color: Color,
    /// Say more
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub verbose: u8,
    /// Say only results and errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
}

/// When to use colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// On a terminal, unless NO_COLOR is set
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// The verbs.
#[derive(Debug, Subcommand)]
#[allow(missing_docs, reason = "the help of a verb is on its arguments")]
pub enum Command {
    Up(up::Args),
    Down(down::Args),
    Apply(apply::Args),
    Diff(diff::Args),
    Plan(plan::Args),
    Check(check::Args),
    Explain(explain::Args),
    ExplainPlan(explain::PlanArgs),
    Fmt(fmt::Args),
    Get(get::Args),
    Describe(describe::Args),
    Top(top::Args),
    Events(events::Args),
    Logs(logs::Args),
    #[command(visible_alias = "delete")]
    Teardown(teardown::Args),
    Activate(activate::Args),
    Deactivate(deactivate::Args),
    Reset(reset::Args),
    Tick(tick::Args),
    Conf(conf::Args),
    Connect(connect::Args),
    Disconnect(disconnect::Args),
    Export(export::Args),
    Convert(convert::Args),
    #[command(subcommand)]
    Port(port::Command),
    #[command(subcommand)]
    Idl(idl::Command),
    #[command(subcommand)]
    Manager(manager::Command),
    #[command(subcommand)]
    Node(node::Command),
    #[command(subcommand)]
    Controller(controller::Command),
    Smoke(smoke::Args),
    Schema(schema::Args),
    Completion(completion::Args),
    Version(version::Args),
    #[command(hide = true)]
    Docs(docs::Args),
}

/// Runs a verb, and prints the error if there is one.
pub fn run(cli: Cli, out: &Output) -> Exit {
    let result = match cli.command {
        // These need no home.
        Command::Check(args) => check::run(&args, home(&cli.globals).ok().as_ref(), out),
        Command::Completion(args) => completion::run(&args, out),
        Command::Convert(args) => convert::run(&args, out),
        Command::Docs(args) => docs::run(&args, out),
        Command::Idl(command) => idl::run(&command, out),
        Command::Schema(args) => schema::run(&args, out),
        Command::Fmt(args) => fmt::run(&args, out),
        Command::Smoke(args) => {
            smoke::own_stack(&cli.globals).and_then(|()| on_runtime(smoke::run(args, out)))
        }
        Command::Explain(args) if args.is_field() => explain::fields(&args, out),
        command => match Session::new(&cli.globals, *out) {
            Ok(session) => return within(command, &session),
            Err(e) => Err(e),
        },
    };
    result.unwrap_or_else(|e| failed(&e, None, out))
}

/// Runs a verb that works with a session.
fn within(command: Command, session: &Session) -> Exit {
    let result = on_runtime(dispatch(command, session));
    result.unwrap_or_else(|e| failed(&e, session.help(&e), &session.out))
}

/// Runs it to its end.
fn on_runtime(work: impl Future<Output = Result<Exit, CliError>>) -> Result<Exit, CliError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|e| CliError::Local(LocalError::Runtime(e)))?;
    runtime.block_on(work)
}

/// Prints an error with what helps, and gives its exit code.
pub(crate) fn failed(error: &CliError, help: Option<String>, out: &Output) -> Exit {
    let help = help.or_else(|| error.help());
    out.error(error, help.as_deref());
    error.exit()
}

async fn dispatch(command: Command, session: &Session) -> Result<Exit, CliError> {
    match command {
        Command::Up(args) => up::run(args, session).await,
        Command::Down(args) => down::run(&args, session).await,
        Command::Apply(args) => apply::run(args, session).await,
        Command::Diff(args) => diff::run(args, session).await,
        Command::Plan(args) => plan::run(args, session).await,
        Command::Explain(args) => explain::run(args.plan, session).await,
        Command::ExplainPlan(args) => explain::run(args, session).await,
        Command::Fmt(args) => fmt::run(&args, &session.out),
        Command::Get(args) => get::run(args, session).await,
        Command::Describe(args) => describe::run(&args, session).await,
        Command::Top(args) => top::run(args, session).await,
        Command::Events(args) => events::run(args, session).await,
        Command::Logs(args) => logs::run(args, session).await,
        Command::Teardown(args) => teardown::run(args, session).await,
        Command::Activate(args) => activate::run(&args, session).await,
        Command::Deactivate(args) => deactivate::run(&args, session).await,
        Command::Reset(args) => reset::run(&args, session).await,
        Command::Tick(args) => tick::run(&args, session).await,
        Command::Conf(args) => conf::run(args, session).await,
        Command::Connect(args) => connect::run(args, session).await,
        Command::Disconnect(args) => disconnect::run(args, session).await,
        Command::Port(command) => port::run(command, session).await,
        Command::Export(args) => export::run(&args, session).await,
        Command::Convert(args) => convert::run(&args, &session.out),
        Command::Manager(command) => manager::run(command, session).await,
        Command::Node(command) => node::run(command, session).await,
        Command::Controller(command) => controller::run(command, session).await,
        Command::Check(args) => check::run(&args, Some(&session.home), &session.out),
        Command::Completion(args) => completion::run(&args, &session.out),
        Command::Version(args) => version::run(&args, session).await,
        Command::Docs(args) => docs::run(&args, &session.out),
        Command::Idl(command) => idl::run(&command, &session.out),
        Command::Schema(args) => schema::run(&args, &session.out),
        Command::Smoke(args) => smoke::run(args, &session.out).await,
    }
}
