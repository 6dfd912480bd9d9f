//! Whom a restart interrupts.

use super::names::tame;
use crate::plan::{Affected, Restart};

/// `restarts: process hello.main (pid 7) on local stops: type of Sine0 changed; made again: Sine0, Filter0; …`.
pub fn restart(restart: &Restart) -> String {
    let (mut text, parts) = parts(restart);
    for (name, part) in parts {
        text.push_str(&match name {
            "" => format!(", {part}"),
            name => format!("; {name}: {part}"),
        });
    }
    text
}

/// What happens to the process, and then what that means to whom. What has no name goes on with the one before.
pub(super) fn parts(restart: &Restart) -> (String, Vec<(&'static str, String)>) {
    let (manager, node, reason) = (&restart.manager, &restart.node, tame(&restart.reason));
    let head = match restart.pid {
        Some(pid) => format!("restarts: process {manager} (pid {pid}) on {node} stops: {reason}"),
        None => format!(
            "restarts: only components in process {manager} on {node}, which goes on: {reason}"
        ),
    };
    let mut parts = Vec::new();
    let mut list = |name, names: &[String]| {
        if !names.is_empty() {
            parts.push((name, tame(&names.join(", ")).into_owned()));
        }
    };
    list("made again", &restart.components);
    list("also stopped", &restart.also_stopped);
    list("connectors cut", &restart.connectors);
    for (number, peer) in restart.affected.iter().enumerate() {
        list(if number == 0 { "peers" } else { "" }, &[affected(peer)]);
    }
    (head, parts)
}

/// `Printer0 in hello.Printer0 on local gets no samples meanwhile`.
fn affected(peer: &Affected) -> String {
    let (instance, manager, node) = (&peer.instance, &peer.manager, &peer.node);
    let what = match peer.starved {
        true => "gets no samples meanwhile",
        false => "sends to nobody meanwhile",
    };
    format!("{instance} in {manager} on {node} {what}")
}
