//! `cargo xtask bench heal`: from `kill -9` of a manager until its component is Active again with all its connectors.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use rts_manager_api::client::Client;
use rts_manager_api::control::{ComponentInfo, RequestBody, ResponseBody};
use rts_manager_api::files::{CONTROL_SOCKET, MANAGER_JSON, ManagerFile};
use rustix::process::{Pid, Signal, kill_process};

use super::Common;
use super::stack::Stack;
use super::{floors, stats};

/// Longest wait for anything.
const LIMIT: Duration = Duration::from_secs(30);
/// Between two looks.
const LOOK: Duration = Duration::from_millis(1);
/// Without a controller for this long an agent heals by itself.
const ALONE: Duration = Duration::from_millis(3500);
/// The system; its sink, Printer0, has a process of its own.
const SYSTEM: &str = "manifests/hello/system.xml";
const VICTIM: &str = "Printer0";
const SOURCE: &str = "Filter0";

/// Arguments of `cargo xtask bench heal`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
}

/// Measures all rows, interleaved run by run, and prints them.
pub fn run(args: &Args) -> Result<()> {
    let (profile, programs) = args.common.programs()?;
    let folder = tempfile::Builder::new().prefix("rtsb").tempdir_in("/tmp")?;
    let mut rows = [const { Vec::new() }; 3];
    for run in 0..=args.common.runs {
        let times = [
            heal(&programs, true)?,
            heal(&programs, false)?,
            floors::spawn_until_answer(&programs.join("rts-manager"), folder.path(), 1)?,
        ];
        if run > 0 {
            let rows = rows.iter_mut().zip(times);
            rows.for_each(|(row, time)| row.push(time));
        }
    }
    let names = ["heal-with-controller", "heal-alone", "floor-spawn"];
    let rows = names.iter().zip(rows);
    let rows: Vec<_> = rows
        .map(|(name, runs)| stats::Row::new(name, 1, runs))
        .collect();
    if !args.common.json {
        println!(
            "one component, {profile} build; a stack of its own for each run, so without back-off of earlier ones"
        );
    }
    stats::print(&rows, args.common.json)
}

/// One death in a new stack. Without a controller, it is killed first and given up by the agent.
fn heal(programs: &Path, controller: bool) -> Result<Duration> {
    let stack = Stack::start(programs)?;
    stack.rtsctl(&["apply", SYSTEM])?;
    if !controller {
        kill(identity(&stack.home().join("run/controller.json"))?)?;
        std::thread::sleep(ALONE);
    }
    let (victim, _) = find(&stack, VICTIM)?.context("it does not run")?;
    let start = Instant::now();
    kill(victim)?;
    loop {
        if let Some((pid, component)) = find(&stack, VICTIM)?
            && pid != victim
            && component.state == "Active"
            && is_connected(&stack)?
        {
            break;
        }
        ensure!(start.elapsed() < LIMIT, "{VICTIM} does not come back");
        std::thread::sleep(LOOK);
    }
    let took = start.elapsed();
    stack.stop()?;
    Ok(took)
}

fn is_connected(stack: &Stack) -> Result<bool> {
    let source = find(stack, SOURCE)?;
    Ok(source.is_some_and(|(_, source)| source.connectors.iter().all(|c| c.state == "Connected")))
}

/// A component and the process that holds it. What is starting or ending is not there.
fn find(stack: &Stack, instance: &str) -> Result<Option<(u32, ComponentInfo)>> {
    for entry in std::fs::read_dir(stack.home().join("run/local"))? {
        let folder = entry?.path();
        let Ok(text) = std::fs::read(folder.join(MANAGER_JSON)) else {
            continue;
        };
        let file: ManagerFile = serde_json::from_slice(&text)?;
        let components = ask(&folder.join(CONTROL_SOCKET)).unwrap_or_default();
        if let Some(found) = components.into_iter().find(|c| c.instance == instance) {
            return Ok(Some((file.pid, found)));
        }
    }
    Ok(None)
}

fn ask(socket: &Path) -> Option<Vec<ComponentInfo>> {
    let limit = Duration::from_secs(1);
    let mut client = Client::connect(socket, limit).ok()?;
    match client.call(RequestBody::Inventory, limit).ok()? {
        ResponseBody::Inventory(inventory) => Some(inventory.components),
        _ => None,
    }
}

fn identity(file: &PathBuf) -> Result<u32> {
    let text = std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    let value: serde_json::Value = serde_json::from_slice(&text)?;
    match value["pid"].as_u64().map(u32::try_from) {
        Some(Ok(pid)) => Ok(pid),
        _ => bail!("{} names no pid", file.display()),
    }
}

fn kill(pid: u32) -> Result<()> {
    let pid = i32::try_from(pid).ok().and_then(Pid::from_raw);
    Ok(kill_process(pid.context("no pid")?, Signal::KILL)?)
}
