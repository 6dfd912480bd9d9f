//! Hard orders of a profile as a graph over the components of one system, for one kind of step.
//!
//! Sequence numbers become levels: a component with conditions waits for the level below its own (its highest number,
//! since several conditions are ANDed), and a level for its members and the level below. A level is a node of its own,
//! so that the graph stays as small as the profile.
//!
//! `Preceding` outweighs the numbers: real profiles number components in the order of a list and let a low number wait
//! for a high one. Where the two contradict each other, a level does not wait for its members with a `Preceding`.

mod limits;
mod tell;
mod walk;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, EdgeIndex, NodeIndex};
use rts_schemas::system::{Condition, NO_SEQUENCE, Orders, SendingTiming, WaitFor};

use crate::graph::{Gate, Ix};
use crate::index::{Facts, Id, Live};
use crate::observed::LifeCycleState;
use crate::plan::{OnTimeout, OrderName, Rule};

/// A component in an order.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Member<'a> {
    /// Instance name.
    pub name: &'a str,
    /// False for one that nobody waits for when it cannot be brought up.
    pub required: bool,
}

/// Visits the components of one system in the order that these lists ask for. Gives what has to be said of it.
///
/// A component of a node of which nothing is said here cannot be asked, and nobody knows how far it is: who comes after
/// it waits.
pub(crate) fn visit<'a>(
    facts: &Facts<'a>,
    ids: &[Id<'a>],
    lists: &[List<'a>],
    mut visit: impl FnMut(Id<'a>, Gate) -> Standing,
) -> Vec<String> {
    let silent = lists.iter().all(|(_, list)| list.is_empty());
    let Some(uid) = ids.first().map(|id| id.uid).filter(|_| !silent) else {
        // Nobody comes before anybody: there is no graph to build.
        for id in ids {
            visit(*id, Gate::default());
        }
        return Vec::new();
    };
    let members = ids.iter().map(|id| Member {
        name: id.instance,
        required: facts
            .wants
            .get(id)
            .is_none_or(|want| want.placed.spec.required),
    });
    let elsewhere = facts.elsewhere.get(uid);
    let others = elsewhere.into_iter().flatten().map(|(name, there)| Member {
        name,
        required: there.required,
    });
    let order = Order::new(lists, members.chain(others));
    let over = order.walk(|instance, gate| {
        if let Some(there) = elsewhere.and_then(|elsewhere| elsewhere.get(instance)) {
            let node = &there.node;
            return Standing::WaitsAs(
                format!("is on {node}, where only a controller can ask").into(),
            );
        }
        match facts.id(uid, instance) {
            Some(id) => visit(id, gate),
            None => Standing::Done,
        }
    });
    order.tell(&over)
}

#[derive(Debug, Clone, Copy)]
enum Place<'a> {
    Component(Member<'a>),
    Level,
}

/// How one place waits for another.
#[derive(Debug, Clone, Copy)]
struct Wait {
    rule: Rule,
    /// Which of the order's time-outs ends it.
    timeout: Option<usize>,
}

/// Time-out of one `Preceding`.
#[derive(Debug, Clone, Copy)]
struct Timeout {
    /// Above 0.
    ms: u32,
    then: OnTimeout,
}

/// How far a component is, seen from what comes after it.
#[derive(Debug, Clone)]
pub(crate) enum Standing {
    /// Nothing has to be awaited.
    Done,
    /// These steps have to be awaited: one, or one for each instance that is taken down.
    Steps(Vec<Ix>),
    /// The same, and they need nothing: nobody ever gives them up, so that they end after all that stands before them.
    Certain(Vec<Ix>),
    /// It cannot get there now.
    Waits,
    /// It cannot get there now, and why (`was deactivated by hand`).
    WaitsAs(Cow<'static, str>),
    /// It was asked and is not there yet, without a step of this plan: who needs more than the request waits, even for an
    /// optional one, since its try has not ended. And why (`is being initialised`).
    Asked(&'static str),
}

/// Conditions of one order of a profile.
pub(crate) type List<'a> = (OrderName, &'a [Condition]);

/// All seven.
pub(crate) fn all(orders: &Orders) -> [List<'_>; 7] {
    [
        (OrderName::StartUp, &orders.start_up),
        (OrderName::ShutDown, &orders.shut_down),
        (OrderName::Activation, &orders.activation),
        (OrderName::Deactivation, &orders.deactivation),
        (OrderName::Resetting, &orders.resetting),
        (OrderName::Initializing, &orders.initializing),
        (OrderName::Finalizing, &orders.finalizing),
    ]
}

/// The two that order Create, since that also initialises.
pub(crate) fn making(orders: &Orders) -> [List<'_>; 2] {
    [
        (OrderName::StartUp, &orders.start_up),
        (OrderName::Initializing, &orders.initializing),
    ]
}

/// How far a component that is there and stays is in these two. An older plan may still be at it.
pub(crate) fn made(live: &Live<'_>) -> Standing {
    match live.component.state {
        LifeCycleState::Created => Standing::Asked("is being initialised"),
        _ => Standing::Done,
    }
}

/// The two that order Delete, since that also finalises.
pub(crate) fn deleting(orders: &Orders) -> [List<'_>; 2] {
    [
        (OrderName::ShutDown, &orders.shut_down),
        (OrderName::Finalizing, &orders.finalizing),
    ]
}

/// One order of one system; two where a step belongs to both.
pub(crate) struct Order<'a> {
    graph: DiGraph<Place<'a>, Wait>,
    wait_ms: BTreeMap<&'a str, u32>,
    timeouts: Vec<Timeout>,
    name: String,
}

impl<'a> Order<'a> {
    /// The order among `members`; conditions on, or of, others are left out. Each list has its own sequence numbers.
    pub fn new(lists: &[List<'a>], members: impl IntoIterator<Item = Member<'a>>) -> Self {
        let spoken = lists.iter().filter(|(_, list)| !list.is_empty());
        let names: Vec<&str> = spoken.map(|(name, _)| name.element()).collect();
        let mut order = Self {
            graph: DiGraph::new(),
            wait_ms: BTreeMap::new(),
            timeouts: Vec::new(),
            name: names.join(" and "),
        };
        let mut nodes: BTreeMap<&'a str, NodeIndex> = BTreeMap::new();
        for member in members {
            nodes
                .entry(member.name)
                .or_insert_with(|| order.graph.add_node(Place::Component(member)));
        }
        let mut numbered = BTreeSet::new();
        for list in lists {
            order.add_list(*list, &nodes, &mut numbered);
        }
        order.relax(&numbered);
        order
    }

    /// Name of its list; of both, where both say something.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Drops edges of `numbered` that are part of a circle.
    fn relax(&mut self, numbered: &BTreeSet<EdgeIndex>) {
        let mut group_of = vec![0; self.graph.node_count()];
        for (number, group) in kosaraju_scc(&self.graph).into_iter().enumerate() {
            for node in group {
                group_of[node.index()] = number;
            }
        }
        self.graph.retain_edges(|graph, edge| {
            let in_circle = graph
                .edge_endpoints(edge)
                .is_some_and(|(from, to)| group_of[from.index()] == group_of[to.index()]);
            !(in_circle && numbered.contains(&edge))
        });
    }

    /// `numbered` collects the edges from members with a `Preceding` to their levels.
    fn add_list(
        &mut self,
        (name, list): List<'a>,
        nodes: &BTreeMap<&'a str, NodeIndex>,
        numbered: &mut BTreeSet<EdgeIndex>,
    ) {
        let mut levels: BTreeMap<&'a str, u32> = BTreeMap::new();
        for condition in list {
            let target = condition.target.as_str();
            let Some(&node) = nodes.get(target) else {
                continue;
            };
            if condition.sequence != NO_SEQUENCE {
                let level = levels.entry(target).or_insert(condition.sequence);
                *level = condition.sequence.max(*level);
            }
            match &condition.wait {
                None => {}
                Some(WaitFor::Time { milliseconds }) => {
                    let wait = self.wait_ms.entry(target).or_default();
                    *wait = (*wait).max(*milliseconds);
                }
                Some(WaitFor::Preceding {
                    timing,
                    timeout_ms,
                    components,
                }) => {
                    let wait = self.wait(name, *timing, *timeout_ms);
                    for before in components.iter().filter_map(|c| nodes.get(c.as_str())) {
                        self.graph.add_edge(*before, node, wait);
                    }
                }
            }
        }
        let preceded: BTreeSet<NodeIndex> = list
            .iter()
            .filter(|c| matches!(c.wait, Some(WaitFor::Preceding { .. })))
            .filter_map(|c| nodes.get(c.target.as_str()).copied())
            .collect();
        let rule = Rule::Sequence { order: name };
        numbered.extend(self.add_levels(rule, &levels, nodes, &preceded));
    }

    fn wait(&mut self, order: OrderName, timing: SendingTiming, timeout_ms: u32) -> Wait {
        let timeout = (timeout_ms > 0).then_some(self.timeouts.len());
        self.timeouts.extend(timeout.map(|_| Timeout {
            ms: timeout_ms,
            then: on_timeout(order),
        }));
        let rule = match timing {
            SendingTiming::Sync => Rule::Sync { order },
            SendingTiming::Async => Rule::Async { order },
        };
        Wait { rule, timeout }
    }

    /// Gives the edges from `preceded` members to their levels.
    fn add_levels(
        &mut self,
        rule: Rule,
        levels: &BTreeMap<&str, u32>,
        nodes: &BTreeMap<&str, NodeIndex>,
        preceded: &BTreeSet<NodeIndex>,
    ) -> Vec<EdgeIndex> {
        let wait = Wait {
            rule,
            timeout: None,
        };
        let mut numbered = Vec::new();
        let mut by_level: BTreeMap<u32, Vec<NodeIndex>> = BTreeMap::new();
        for (target, level) in levels {
            by_level.entry(*level).or_default().push(nodes[target]);
        }
        let mut below: Option<NodeIndex> = None;
        for members in by_level.values() {
            let end = self.graph.add_node(Place::Level);
            if let Some(below) = below {
                self.graph.add_edge(below, end, wait);
            }
            for member in members {
                if let Some(below) = below {
                    self.graph.add_edge(below, *member, wait);
                }
                let edge = self.graph.add_edge(*member, end, wait);
                if preceded.contains(member) {
                    numbered.push(edge);
                }
            }
            below = Some(end);
        }
        numbered
    }

    /// Groups of components that wait for each other, each sorted.
    pub fn cycles(&self) -> Vec<Vec<&'a str>> {
        let mut cycles: Vec<Vec<&'a str>> = kosaraju_scc(&self.graph)
            .into_iter()
            .filter(|group| self.is_cycle(group))
            .map(|group| self.names(&group))
            .collect();
        cycles.sort();
        cycles
    }

    fn is_cycle(&self, group: &[NodeIndex]) -> bool {
        group.len() > 1 || self.graph.contains_edge(group[0], group[0])
    }

    fn names(&self, group: &[NodeIndex]) -> Vec<&'a str> {
        let mut names: Vec<_> = group
            .iter()
            .filter_map(|node| match self.graph[*node] {
                Place::Component(member) => Some(member.name),
                Place::Level => None,
            })
            .collect();
        names.sort_unstable();
        names
    }
}

/// Bringing up fails and is tried again; nothing is kept alive by an order.
fn on_timeout(order: OrderName) -> OnTimeout {
    match order {
        OrderName::StartUp
        | OrderName::Initializing
        | OrderName::Activation
        | OrderName::Resetting => OnTimeout::Fail,
        OrderName::ShutDown | OrderName::Finalizing | OrderName::Deactivation => OnTimeout::GoOn,
    }
}
