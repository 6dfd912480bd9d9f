//! What `onDisconnect` asks for when a connector cannot be made now.
//!
//! A component's manager acts at once when a peer is lost. The plan brings the component back only when all its data
//! connectors are connected, and acts itself where the manager did not.

use rts_schemas::system::{OnDisconnect, PortKind};

use crate::decide::{Decisions, Doomed, decide};
use crate::index::{Facts, Id, Live};
use crate::links::{self, Flow, Links};
use crate::observed::LifeCycleState;
use crate::plan::Blocked;
use crate::table::Table;
use crate::target;

/// A component that must not be Active now.
#[derive(Debug)]
pub(crate) struct Idle {
    /// Which connector it waits for.
    pub reason: String,
    /// It is certain that the connector does not work; else an end of it cannot be seen.
    pub certain: bool,
    /// The connector is being made already.
    pub transient: bool,
    /// A person took the connector away, and that is left.
    pub by_hand: bool,
}

impl Idle {
    /// Of several reasons the heaviest counts.
    fn weight(&self) -> (bool, bool, bool) {
        (self.certain, !self.by_hand, !self.transient)
    }
}

/// Decides what becomes of components and connectors. A component that must stop for a lost peer takes others with
/// it, so that it goes on until no more are found: at most once for each component.
pub(crate) fn settle<'a>(facts: &Facts<'a>, blocked: &Blocked) -> (Decisions<'a>, Links<'a>) {
    let mut doomed = Doomed::default();
    loop {
        let decisions = decide(facts, blocked, &doomed);
        let mut links = links::decide(facts, &decisions, blocked);
        links.idle = idle(facts, &links);
        let more = stopping(facts, &decisions, blocked, &links);
        if more.is_empty() {
            return (decisions, links);
        }
        doomed.extend(more);
    }
}

/// Components with a policy and a connector that is neither there nor made by the plan.
fn idle<'a>(facts: &Facts<'a>, links: &Links<'a>) -> Table<Id<'a>, Idle> {
    let mut idle: Table<Id<'a>, Idle> = Table::default();
    for (key, link) in facts.links.iter() {
        if link.connector.spec.kind != PortKind::Data || links.joins.contains_key(key) {
            continue;
        }
        let [source, target] = link.ends;
        let by_hand = links.left_out(key);
        let (flow, transient) = match links.waits.get(key) {
            Some(wait) => (wait.flow, wait.transient),
            None if by_hand => (Flow::No, false),
            None if facts.wants.contains_key(&source) => (Flow::Yes, false),
            // Its source is on a node of which nothing is said here, but its in-port is not.
            None if is_fed(facts, target, key.1) => (Flow::Yes, false),
            None => (Flow::Unknown, false),
        };
        if flow == Flow::Yes {
            continue;
        }
        let certain = flow == Flow::No;
        for id in [source, target] {
            let policy = facts.wants.get(&id).map(|want| want.on_disconnect());
            let Some(policy) = policy.filter(|policy| *policy != OnDisconnect::Keep) else {
                continue;
            };
            let new = Idle {
                reason: waits_for(key.1, by_hand, policy),
                certain,
                transient,
                by_hand,
            };
            if idle.get(&id).is_none_or(|old| new.weight() > old.weight()) {
                idle.insert(id, new);
            }
        }
    }
    idle
}

/// True when the in-port end of a connector has its source.
fn is_fed<'a>(facts: &Facts<'a>, target: Id<'a>, connector: &str) -> bool {
    let ends = facts.instances(target).iter().flat_map(|live| {
        let live = &facts.lives[*live];
        let answers = live.manager.responsive;
        live.component.bindings.iter().filter(move |_| answers)
    });
    let mut ends = ends.filter(|end| end.connected);
    ends.any(|end| end.connector == connector)
}

fn waits_for(connector: &str, by_hand: bool, policy: OnDisconnect) -> String {
    let policy = policy.as_str();
    let which = match by_hand {
        true => ", which was disconnected by hand",
        false => "",
    };
    format!("waits for connector {connector}{which}: rtsctl.onDisconnect is {policy}")
}

/// Components that are Active without one of their connectors, and have to be deleted for it. A connector that a person
/// took away and that is left so deletes nobody: who is made again would have it again, against the policy. Its ends
/// are deactivated.
fn stopping<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    blocked: &Blocked,
    links: &Links<'a>,
) -> Doomed<'a> {
    let mut doomed = Doomed::default();
    let stops = |id: &Id<'a>| {
        let want = &facts.wants[id];
        want.on_disconnect() == OnDisconnect::Stop
            && acting(facts, decisions, blocked, id).is_some()
    };
    let seeds = links
        .idle
        .iter()
        .filter(|(id, idle)| idle.certain && !idle.by_hand && stops(id));
    let mut open = Vec::new();
    for (id, idle) in seeds {
        doomed.insert(*id, idle.reason.clone());
        open.push(*id);
    }
    while let Some(peer) = open.pop() {
        for (id, connector) in facts.leans.get(&peer).into_iter().flatten() {
            if !doomed.contains_key(id) && stops(id) {
                doomed.insert(*id, waits_for(connector, false, OnDisconnect::Stop));
                open.push(*id);
            }
        }
    }
    doomed
}

/// The instance of a component when it is Active and can be told to be otherwise.
pub(crate) fn acting<'f, 'a>(
    facts: &'f Facts<'a>,
    decisions: &Decisions<'a>,
    blocked: &Blocked,
    id: &Id<'a>,
) -> Option<(usize, &'f Live<'a>)> {
    let ix = *decisions.present.get(id)?;
    let live = &facts.lives[ix];
    let own = || target::component(id.instance);
    let blocked = target::why_blocked(blocked, live.node, own).is_some();
    let active = live.component.state == LifeCycleState::Active && live.manager.responsive;
    (active && facts.nodes.contains(live.node) && !blocked).then_some((ix, live))
}
