//! Writes faults.

use std::time::Duration;

use super::token::quoted;
use super::{CONTROLLER, span};
use crate::faults::{Fault, Misbehaviour, Timed, When};

/// A fault as it can be read again.
pub fn print(timed: &Timed) -> String {
    let Timed { when, fault } = timed;
    let (what, lasts) = what(fault);
    let when = match when {
        When::At(time) => format!(" at {}", span::write(*time)),
        When::Step(step) => format!(" at step {step}"),
    };
    format!("{what}{when}{}", lasting(lasts))
}

/// Faults in order. What was said as one is said as one again.
pub fn print_all(faults: &[Timed]) -> Vec<String> {
    groups(faults).into_iter().map(|(text, _)| text).collect()
}

/// The same, each text with its faults, which have one time.
pub fn groups(faults: &[Timed]) -> Vec<(String, &[Timed])> {
    let mut groups = Vec::new();
    let mut rest = faults;
    while let [first, after @ ..] = rest {
        let dropped = dropped(first, after.first());
        let count = if dropped.is_some() { 2 } else { 1 };
        let (group, more) = rest.split_at(count.min(rest.len()));
        groups.push((dropped.unwrap_or_else(|| print(first)), group));
        rest = more;
    }
    groups
}

/// Two cuts that are one drop.
fn dropped(first: &Timed, second: Option<&Timed>) -> Option<String> {
    let (Fault::Cut { from, to, lasts }, other) = (&first.fault, second?) else {
        return None;
    };
    let back = Fault::Cut {
        from: to.clone(),
        to: from.clone(),
        lasts: *lasts,
    };
    let is = other.fault == back && other.when == first.when && to == CONTROLLER;
    let cut = print(first);
    let cannot = format!("{} cannot reach {}", quoted(from), quoted(to));
    let rest = cut.strip_prefix(&cannot).filter(|_| is)?;
    Some(format!("agent {} drops{rest}", quoted(from)))
}

fn lasting(lasts: Option<Duration>) -> String {
    lasts.map_or_else(String::new, |lasts| format!(" for {}", span::write(lasts)))
}

fn on(node: &str) -> String {
    match node {
        "" => String::new(),
        node => format!(" on {}", quoted(node)),
    }
}

fn manager(name: Option<&String>) -> String {
    name.map_or_else(|| "any".to_owned(), |name| quoted_but(name, "any"))
}

/// Quoted also when it is this word.
fn quoted_but(name: &str, word: &str) -> String {
    match name == word {
        true => format!("\"{name}\""),
        false => quoted(name),
    }
}

/// Without its time, and how long it lasts.
fn what(fault: &Fault) -> (String, Option<Duration>) {
    match fault {
        Fault::Crash { host, calls, down } => {
            let who = match host.as_str() {
                CONTROLLER => CONTROLLER.to_owned(),
                node => format!("agent {}", quoted(node)),
            };
            let calls = match calls {
                0 => String::new(),
                calls => format!(" after {calls} calls"),
            };
            (format!("{who} crashes{calls}"), *down)
        }
        Fault::Reboot { node, down } => (format!("node {} reboots", quoted(node)), Some(*down)),
        Fault::Cut { from, to, lasts } => {
            // In the place of the first word, a name must not be one of those.
            let from = match super::parse::FIRST.contains(&from.as_str()) {
                true if from != CONTROLLER => format!("\"{from}\""),
                _ => quoted(from),
            };
            (format!("{from} cannot reach {}", quoted(to)), *lasts)
        }
        Fault::Weather {
            lost,
            doubled,
            delay,
            lasts,
        } => (weather(*lost, *doubled, *delay), Some(*lasts)),
        Fault::DiskFails { host, lasts } => {
            (format!("disk of {} fails", quoted(host)), Some(*lasts))
        }
        Fault::DiskSlow { host, delay, lasts } => {
            let delay = span::write(*delay);
            let text = format!("disk of {} is slow {delay}", quoted(host));
            (text, Some(*lasts))
        }
        Fault::ClockJumps { host, by } => {
            let by = span::write_signed(*by);
            (format!("clock of {} jumps {by}", quoted(host)), None)
        }
        Fault::ManagerDies {
            node,
            manager: name,
        } => {
            let name = manager(name.as_ref());
            (format!("manager {name} dies{}", on(node)), None)
        }
        Fault::ManagerHangs {
            node,
            manager: name,
        } => {
            let name = manager(name.as_ref());
            (format!("manager {name} hangs{}", on(node)), None)
        }
        Fault::ManagersFailToStart { node, lasts } => {
            let text = format!("managers on {} fail to start", quoted(node));
            (text, Some(*lasts))
        }
        Fault::ModuleFails {
            node,
            type_name,
            lasts,
        } => {
            let text = format!("module {} fails{}", quoted(type_name), on(node));
            (text, *lasts)
        }
        Fault::Misbehaves {
            instance,
            how,
            lasts,
        } => {
            let text = format!("component {} misbehaves {}", quoted(instance), name(*how));
            (text, *lasts)
        }
        Fault::Usurper => ("usurper appears".to_owned(), None),
    }
}

fn weather(lost: u32, doubled: u32, delay: Duration) -> String {
    let mut text = "network".to_owned();
    if lost > 0 || (doubled == 0 && delay.is_zero()) {
        text.push_str(&format!(" loses {}", span::write_share(lost)));
    }
    if doubled > 0 {
        text.push_str(&format!(" doubles {}", span::write_share(doubled)));
    }
    if !delay.is_zero() {
        text.push_str(&format!(" delays {}", span::write(delay)));
    }
    text
}

/// Ways to misbehave, by name.
pub const MISBEHAVIOURS: [(&str, Misbehaviour); 13] = [
    ("crash-at-once", Misbehaviour::CrashAtOnce),
    ("crash-later", Misbehaviour::CrashLater),
    ("hang-initialize", Misbehaviour::HangInitialize),
    ("hang-activate", Misbehaviour::HangActivate),
    ("hang-execute", Misbehaviour::HangExecute),
    ("hang-deactivate", Misbehaviour::HangDeactivate),
    ("hang-finalize", Misbehaviour::HangFinalize),
    ("error-initialize", Misbehaviour::ErrorInitialize),
    ("error-activate", Misbehaviour::ErrorActivate),
    ("error-execute", Misbehaviour::ErrorExecute),
    ("panic", Misbehaviour::Panic),
    ("ignore-deactivate", Misbehaviour::IgnoreDeactivate),
    ("slow-activate", Misbehaviour::SlowActivate),
];

fn name(how: Misbehaviour) -> &'static str {
    let known = MISBEHAVIOURS.iter().find(|(_, known)| *known == how);
    known.map_or("", |(name, _)| name)
}
