//! The end of controller and agents, and of every program of ours that the run folder no longer tells of.

use std::path::Path;
use std::time::{Duration, Instant};

use rts_host::identity::Identity;
use rts_host::process::Process;
use rustix::process::Signal;

use super::{GRACE, KILLED, Stopped, folders, name_of};
use crate::local::LocalError;
use crate::local::home::Home;
use crate::local::lock::is_held;
use crate::local::strays::{self, Program, Stray};

/// Ends the controller, of whatever the run folder or the arguments of a process tell.
pub(super) fn stop_controller(home: &Home, stopped: &mut Stopped) -> Result<(), LocalError> {
    let what = "the controller";
    let (json, lock) = (home.controller_json(), home.controller_lock());
    stopped.controller = stop_daemon(what, &json, stopped);
    // One that has just started has its lock before its description.
    stopped.controller |= !stop_strays(home, Program::Controller, stopped).is_empty();
    note_held(what, &json, &lock, stopped)
}

/// Ends the relays of all nodes that are reached by SSH: the agents over there end with them, managers go on.
pub(super) fn stop_relays(home: &Home, stopped: &mut Stopped) -> Result<(), LocalError> {
    for node in folders(&home.run())? {
        let what = format!("the relay of node {}", name_of(&node));
        if stop_daemon(&what, &node.join("relay.json"), stopped) {
            stopped.relays.push(name_of(&node));
        }
    }
    let strays = stop_strays(home, Program::Relay, stopped);
    stopped.relays.extend(strays);
    Ok(())
}

/// Ends the agents of all nodes.
pub(super) fn stop_agents(home: &Home, stopped: &mut Stopped) -> Result<(), LocalError> {
    let nodes = folders(&home.run())?;
    let what = |node: &Path| format!("the agent of node {}", name_of(node));
    for node in &nodes {
        if stop_daemon(&what(node), &node.join("agent.json"), stopped) {
            stopped.agents.push(name_of(node));
        }
    }
    let strays = stop_strays(home, Program::Agent, stopped);
    stopped.agents.extend(strays);
    for node in &nodes {
        let (json, lock) = (node.join("agent.json"), node.join("agent.lock"));
        note_held(&what(node), &json, &lock, stopped)?;
    }
    Ok(())
}

/// Stops what the run folder no longer tells of, all at once; gives the names of what was stopped.
pub(super) fn stop_strays(home: &Home, program: Program, stopped: &mut Stopped) -> Vec<String> {
    let strays = strays::find(home, program);
    signal_and_wait(&strays, program, Signal::TERM, GRACE);
    for stray in strays.iter().filter(|stray| lives(stray)) {
        stopped.killed.push(describe(stray));
    }
    signal_and_wait(&strays, program, Signal::KILL, KILLED);
    let mut names = Vec::new();
    for stray in strays {
        if lives(&stray) {
            let what = describe(&stray);
            stopped.left.push(format!("{what} does not die"));
        } else {
            names.push(stray.name);
        }
    }
    names
}

fn lives(stray: &Stray) -> bool {
    !stray.process.ended(Duration::ZERO)
}

fn describe(stray: &Stray) -> String {
    format!("{} (pid {})", stray.name, stray.process.pid())
}

fn signal_and_wait(strays: &[Stray], program: Program, signal: Signal, patience: Duration) {
    for stray in strays.iter().filter(|stray| lives(stray)) {
        // A daemon's group is its own; what it started is stopped by itself.
        if program == Program::Manager {
            stray.process.signal_group(signal);
        } else {
            stray.process.signal(signal);
        }
    }
    let end = Instant::now() + patience;
    for stray in strays {
        let left = end.saturating_duration_since(Instant::now());
        stray.process.ended(left);
    }
}

/// Ends the daemon that a description names; true when there was one and it ended.
fn stop_daemon(what: &str, json: &Path, stopped: &mut Stopped) -> bool {
    let Some(process) = Identity::read(json).and_then(|identity| Process::identified(&identity))
    else {
        return false;
    };
    process.signal(Signal::TERM);
    if process.ended(GRACE) {
        return true;
    }
    let what = format!("{what} (pid {})", process.pid());
    process.signal(Signal::KILL);
    if process.ended(KILLED) {
        stopped.killed.push(what);
        return true;
    }
    stopped.left.push(format!("{what} does not die"));
    false
}

/// Whoever still holds the lock of a daemon is somebody that we do not know.
fn note_held(
    what: &str,
    json: &Path,
    lock: &Path,
    stopped: &mut Stopped,
) -> Result<(), LocalError> {
    if is_held(lock)? {
        stopped.left.push(format!(
            "{what} holds {} but {} does not say which process it is",
            lock.display(),
            json.display()
        ));
    }
    Ok(())
}
