//! Hard orders of a profile as a graph over the components of one system, for one kind of step.
//!
//! Sequence numbers become levels: a component with conditions waits for the level below its own (its highest number,
//! since several conditions are ANDed), and a level for its members and the level below. A level is a node of its own,
//! so that the graph stays as small as the profile.
//!
//! `Preceding` outweighs the numbers: real profiles number components in the order of a list and let a low number wait
//! for a high one. Where the two contradict each other, a level does not wait for its members with a `Preceding`.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, EdgeIndex, NodeIndex};
use petgraph::visit::EdgeRef;
use rts_schemas::system::{Condition, SendingTiming, WaitFor};

use crate::graph::{Gate, Ix};

#[derive(Debug, Clone, Copy)]
enum Place<'a> {
    Component(&'a str),
    Level,
}

/// How far a component is, seen from what comes after it.
#[derive(Debug, Clone)]
pub(crate) enum Standing {
    /// Nothing has to be awaited.
    Done,
    /// These steps have to be awaited: one, or one for each instance that is taken down.
    Steps(Vec<Ix>),
    /// It cannot get there now.
    Waits,
}

/// One order of one system.
pub(crate) struct Order<'a> {
    graph: DiGraph<Place<'a>, SendingTiming>,
    wait_ms: BTreeMap<&'a str, u32>,
    name: &'a str,
}

#[derive(Debug, Clone, Default)]
struct Passed {
    steps: BTreeSet<Ix>,
    waits: Option<String>,
}

impl<'a> Order<'a> {
    /// The order among `members`; conditions on, or of, others are left out. Each list has its own sequence numbers.
    pub fn new(
        name: &'a str,
        lists: &[&'a [Condition]],
        members: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let mut order = Self {
            graph: DiGraph::new(),
            wait_ms: BTreeMap::new(),
            name,
        };
        let mut nodes: BTreeMap<&'a str, NodeIndex> = BTreeMap::new();
        for member in members {
            nodes
                .entry(member)
                .or_insert_with(|| order.graph.add_node(Place::Component(member)));
        }
        let mut numbered = BTreeSet::new();
        for list in lists {
            order.add_list(list, &nodes, &mut numbered);
        }
        order.relax(&numbered);
        order
    }

    /// Drops edges of `numbered` that are part of a circle.
    fn relax(&mut self, numbered: &BTreeSet<EdgeIndex>) {
        let mut group_of = vec![0; self.graph.node_count()];
        for (number, group) in tarjan_scc(&self.graph).into_iter().enumerate() {
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
        list: &'a [Condition],
        nodes: &BTreeMap<&'a str, NodeIndex>,
        numbered: &mut BTreeSet<EdgeIndex>,
    ) {
        let mut levels: BTreeMap<&'a str, u32> = BTreeMap::new();
        for condition in list {
            let target = condition.target.as_str();
            let Some(&node) = nodes.get(target) else {
                continue;
            };
            let level = levels.entry(target).or_insert(condition.sequence);
            *level = condition.sequence.max(*level);
            self.add_wait(target, node, condition.wait.as_ref(), nodes);
        }
        let preceded: BTreeSet<NodeIndex> = list
            .iter()
            .filter(|c| matches!(c.wait, Some(WaitFor::Preceding { .. })))
            .filter_map(|c| nodes.get(c.target.as_str()).copied())
            .collect();
        numbered.extend(self.add_levels(&levels, nodes, &preceded));
    }

    fn add_wait(
        &mut self,
        target: &'a str,
        node: NodeIndex,
        wait: Option<&WaitFor>,
        nodes: &BTreeMap<&str, NodeIndex>,
    ) {
        match wait {
            None => {}
            Some(WaitFor::Time { milliseconds }) => {
                let wait = self.wait_ms.entry(target).or_default();
                *wait = (*wait).max(*milliseconds);
            }
            Some(WaitFor::Preceding {
                timing, components, ..
            }) => {
                for before in components.iter().filter_map(|c| nodes.get(c.as_str())) {
                    self.graph.add_edge(*before, node, *timing);
                }
            }
        }
    }

    /// Gives the edges from `preceded` members to their levels.
    fn add_levels(
        &mut self,
        levels: &BTreeMap<&str, u32>,
        nodes: &BTreeMap<&str, NodeIndex>,
        preceded: &BTreeSet<NodeIndex>,
    ) -> Vec<EdgeIndex> {
        let mut numbered = Vec::new();
        let mut by_level: BTreeMap<u32, Vec<NodeIndex>> = BTreeMap::new();
        for (target, level) in levels {
            by_level.entry(*level).or_default().push(nodes[target]);
        }
        let mut below: Option<NodeIndex> = None;
        for members in by_level.values() {
            let end = self.graph.add_node(Place::Level);
            if let Some(below) = below {
                self.graph.add_edge(below, end, SendingTiming::Sync);
            }
            for member in members {
                if let Some(below) = below {
                    self.graph.add_edge(below, *member, SendingTiming::Sync);
                }
                let edge = self.graph.add_edge(*member, end, SendingTiming::Sync);
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
        let mut cycles: Vec<Vec<&'a str>> = tarjan_scc(&self.graph)
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
                Place::Component(name) => Some(name),
                Place::Level => None,
            })
            .collect();
        names.sort_unstable();
        names
    }

    /// Visits every component after those it waits for, with what stands before it. Members of a cycle are told that
    /// they wait; a visitor that must act all the same sees only edges that do not close a circle.
    pub fn walk(&self, mut visit: impl FnMut(&'a str, Gate) -> Standing) {
        let mut passed: Vec<Option<Passed>> = vec![None; self.graph.node_count()];
        // Tarjan's groups come in reverse topological order.
        for mut group in tarjan_scc(&self.graph).into_iter().rev() {
            group.sort_unstable();
            let cycle = self.is_cycle(&group).then(|| {
                let names = self.names(&group).join(", ");
                format!("its {} orders form a cycle of {names}", self.name)
            });
            for node in group {
                let mut gate = self.gate(node, &passed);
                if cycle.is_some() {
                    gate.waits.clone_from(&cycle);
                }
                passed[node.index()] = Some(match self.graph[node] {
                    Place::Level => Passed {
                        steps: gate.needs,
                        waits: gate.waits,
                    },
                    Place::Component(name) => self.pass(name, gate, &mut visit),
                });
            }
        }
    }

    fn gate(&self, node: NodeIndex, passed: &[Option<Passed>]) -> Gate {
        let mut gate = Gate::default();
        if let Place::Component(name) = self.graph[node] {
            gate.wait_ms = self.wait_ms.get(name).copied().unwrap_or_default();
        }
        let level = matches!(self.graph[node], Place::Level);
        let mut below = BTreeSet::new();
        for edge in self
            .graph
            .edges_directed(node, petgraph::Direction::Incoming)
        {
            let source = edge.source();
            let Some(before) = &passed[source.index()] else {
                continue;
            };
            if before.waits.is_some() && gate.waits.is_none() {
                gate.waits.clone_from(&before.waits);
            }
            let set = match (edge.weight(), self.graph[source]) {
                // The members of a level have waited for the level below, if they have a step at all.
                (_, Place::Level) if level => &mut below,
                (SendingTiming::Async, _) => &mut gate.starts,
                (SendingTiming::Sync, _) => &mut gate.needs,
            };
            set.extend(before.steps.iter().copied());
        }
        if gate.needs.is_empty() {
            gate.needs = below;
        }
        gate
    }

    fn pass(
        &self,
        name: &'a str,
        gate: Gate,
        visit: &mut impl FnMut(&'a str, Gate) -> Standing,
    ) -> Passed {
        match visit(name, gate) {
            Standing::Done => Passed::default(),
            Standing::Steps(steps) => Passed {
                steps: steps.into_iter().collect(),
                waits: None,
            },
            Standing::Waits => Passed {
                steps: BTreeSet::new(),
                waits: Some(format!("waits for {name} ({} order)", self.name)),
            },
        }
    }
}
