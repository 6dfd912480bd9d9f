//! `plan`: from desired and observed state to steps.
//!
//! Decisions come first ([`crate::decide`], [`crate::links`], [`crate::peers`]), then the steps they need ([`crate::take_down`],
//! [`crate::bring_up`]), then their numbers ([`crate::graph`]). Rules that hold for every plan:
//!
//! - What is as desired is never touched, and nothing is taken down whose replacement cannot be tried now.
//! - What cannot be seen (a node that is unknown, a manager that does not answer) is not acted upon, in either way.
//! - StartUp and Initializing order Create, Activation orders Activate, Resetting orders Reset, Deactivation orders
//!   Deactivate, ShutDown and Finalizing order Delete. SYNC and sequence numbers are needs, ASYNC is a start order.
//!   Where they name an optional component they are end orders (`afterEndOf`), and one that cannot be brought up now is
//!   passed over ([`crate::order`]). A time-out limits the wait: bringing up fails then, taking down goes on.
//! - Where the profile is silent, services and data flow give preferences. They are start orders (`afterStartOf`), so
//!   that they hold nothing up that has failed, and give way inside a cycle: data flow first.
//! - A blocked target is neither brought up nor taken down until it may be tried again. When its process stops, that
//!   ends it in any case. What is left out for it is still a change, with the reason.
//! - A process that does not answer and in which nothing is wanted is stopped, without a word to its components; one
//!   that has expired is stopped in the same way, and started again.
//! - The end of a connector at an in-port goes when no desired connector asks for it and its source is gone.
//! - What a process holds that does not answer, and has not since something was to be made in it, is unknown: nothing of
//!   its system that is seen
//!   nowhere is made, since it may be in there, until that process answers or is gone.
//! - A component that was moved and may still run on a node that cannot be asked here is not made.
//! - With `onDisconnect` other than `keep` a component is Active only with all its data connectors ([`crate::peers`]).
//! - What a person changed by hand is put back or left, as `rtsctl.drift` says ([`mod@crate::drift`]); what is left is no
//!   difference.

use std::collections::BTreeMap;

use crate::alone::{feeds_by_hand, made_by_hand};
use crate::bring_up::{self, Up};
use crate::critical_path::critical_path;
use crate::decide::{Decisions, Stop};
use crate::desired::Desired;
use crate::diff;
use crate::drift::{self, Found};
use crate::graph::{Numbered, Preference, Steps};
use crate::index::{Facts, Keys};
use crate::links::Links;
use crate::observed::Observed;
use crate::peers;
use crate::plan::{Blocked, Plan, WaitingOn};
use crate::take_down::{self, Down};
use crate::target;

/// What to do so that `observed` becomes `desired`. Its changes are empty when nothing differs, its steps also when
/// nothing can be done now.
///
/// `blocked` names targets ([`target::on`]) that failed and must not be tried again yet.
pub fn plan(desired: &Desired, observed: &Observed, blocked: &Blocked) -> Plan {
    let keys = Keys::of(desired);
    let facts = Facts::new(&keys, desired, observed);
    let (decisions, links) = peers::settle(&facts, blocked);
    let mut steps = Steps::default();
    let down = take_down::add(&facts, &decisions, &links, blocked, &mut steps);
    let up = bring_up::add(&facts, &decisions, &links, &down, blocked, &mut steps);
    let numbered = steps.number();
    let by_hand = drift::found(&facts, &decisions, &links);
    Plan {
        changes: diff::changes(&facts, &decisions, &links, &down, &up),
        restarts: diff::restarts(&facts, &decisions),
        waiting_on: waiting_on(&facts, &decisions, &links, &down, &up, &numbered),
        notes: notes(&facts, &decisions, &links, &up, &numbered, &by_hand),
        drift: by_hand.into_iter().map(|found| found.drift).collect(),
        critical_path: critical_path(&numbered.steps),
        steps: numbered.steps,
    }
}

fn waiting_on(
    facts: &Facts<'_>,
    decisions: &Decisions<'_>,
    links: &Links<'_>,
    down: &Down<'_>,
    up: &Up<'_>,
    numbered: &Numbered,
) -> Vec<WaitingOn> {
    let mut waiting: BTreeMap<String, (String, bool)> = BTreeMap::new();
    let mut wait = |target: String, reason: String| waiting.insert(target, (reason, false));
    for (node, reason) in &facts.unknown {
        wait(target::node(node), format!("is unknown: {reason}"));
    }
    for (ix, reason) in &down.stuck {
        let instance = &facts.lives[*ix].component.instance;
        wait(target::component(instance), reason.clone());
    }
    for (link, reason) in down.stuck_cuts.iter() {
        wait(target::connector(link.1), reason.clone());
    }
    for end in &down.left_ends {
        if let Some(reason) = &end.blocked {
            wait(target::connector(&end.binding.connector), reason.clone());
        }
    }
    for (seat, (stop, why)) in decisions.stuck.iter() {
        let reason = match stop {
            Stop::Unwanted => why.clone(),
            Stop::Restart(reason) => format!("is to be replaced: {reason}; blocked: {why}"),
        };
        wait(target::manager(seat.1), reason);
    }
    for (seat, manager) in facts.processes.iter() {
        let (node, key) = (seat.0, seat.1);
        let ends = decisions.stops.contains_key(seat) || decisions.stuck.contains_key(seat);
        if !manager.responsive && !ends && key.system.is_some() && facts.nodes.contains(node) {
            let pid = manager.pid;
            let unseen = match manager.unseen {
                true => " and has not said what it holds",
                false => "",
            };
            let reason = format!(
                "pid {pid} on {node} does not answer{unseen}: end it with `kill -9 {pid}`, and it starts again"
            );
            wait(target::manager(key), reason);
        }
    }
    for (id, reason) in up.waits.iter() {
        let idle = links.idle.get(id).filter(|idle| idle.reason == *reason);
        let transient = idle.is_some_and(|idle| idle.transient);
        waiting.insert(target::component(id.instance), (reason.clone(), transient));
    }
    for (link, wait) in links.waits.iter() {
        let entry = (wait.reason.clone(), wait.transient);
        waiting.insert(target::connector(link.1), entry);
    }
    for target in &numbered.stuck {
        waiting
            .entry(target.clone())
            .or_insert_with(|| ("its orders form a cycle".to_owned(), false));
    }
    waiting
        .into_iter()
        .map(|(target, (reason, transient))| WaitingOn {
            target,
            reason,
            transient,
        })
        .collect()
}

fn notes<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    links: &Links<'a>,
    up: &Up<'a>,
    numbered: &Numbered,
    by_hand: &[Found],
) -> Vec<String> {
    let mut notes = Vec::new();
    for (seat, manager) in facts.processes.iter() {
        let (node, name) = (seat.0, seat.1.display_name());
        if seat.1.system.is_none() {
            notes.push(format!(
                "manager {name} on {node} was started by hand: it is left alone"
            ));
            continue;
        }
        if !facts.nodes.contains(node) {
            notes.push(format!(
                "manager {name} runs on {node}, where nothing was placed: it is left alone"
            ));
            continue;
        }
        let by_hand = made_by_hand(facts, seat);
        if by_hand.is_empty() {
            continue;
        }
        let names = by_hand.into_iter().collect::<Vec<_>>().join(", ");
        let fate = match decisions.stops.contains_key(seat) {
            true => format!("ends with its process (pid {})", manager.pid),
            false => "is left alone".to_owned(),
        };
        notes.push(format!(
            "made by hand in manager {name} on {node}: {names}; {fate}"
        ));
    }
    notes.extend(feeds_by_hand(facts, &decisions.fates));
    for (system, name) in &links.services {
        notes.push(format!(
            "service connector {name} of system {system}: is declared, service ports are connected by a later version"
        ));
    }
    for (system, name, why) in &links.undetermined {
        notes.push(format!(
            "connector {name} of system {system}: is declared, and not made: {why}"
        ));
    }
    notes.extend(up.notes.iter().cloned());
    notes.extend(by_hand.iter().filter_map(Found::note));
    for dropped in &numbered.dropped {
        let names = dropped.targets.join(", ");
        notes.push(match dropped.why {
            Preference::DataFlow => format!(
                "data flow gives no start or stop order among {names}: it runs in a circle, or against a written order or a service"
            ),
            Preference::Service => format!(
                "services give no start or stop order among {names}: they are provided in a circle, or against a written order"
            ),
        });
    }
    notes
}
