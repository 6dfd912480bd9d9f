//! From an order to what stands before each step.
//!
//! Who comes after an optional component waits for the end of its try, and for whatever the optional one itself waits
//! for: it may be given up long before that, and a required component behind it counts all the same.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::Direction;
use petgraph::algo::kosaraju_scc;
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;

use super::limits::Limits;
use super::{Member, Order, Place, Standing};
use crate::graph::{Gate, Ix};
use crate::plan::{OnTimeout, Rule};

/// Optional components that cannot be brought up now → who would have waited for them.
pub(crate) type PassedOver<'a> = BTreeMap<&'a str, BTreeSet<&'a str>>;

/// Steps to await.
#[derive(Debug, Clone, Default)]
pub(super) struct Awaited {
    /// Until they have succeeded.
    pub needs: BTreeSet<Ix>,
    /// Until they have ended.
    pub ends: BTreeSet<Ix>,
}

impl Awaited {
    fn add(&mut self, other: &Self) {
        self.needs.extend(&other.needs);
        self.ends.extend(&other.ends);
    }

    fn is_empty(&self) -> bool {
        self.needs.is_empty() && self.ends.is_empty()
    }
}

/// What is to be awaited because of one place.
#[derive(Debug, Clone, Default)]
pub(super) struct Passed<'a> {
    /// Its own steps.
    pub own: Vec<Ix>,
    /// Its steps may fail: only their end counts.
    optional: bool,
    /// What stands before it, where its own steps do not speak for that.
    pub through: Awaited,
    /// Why it cannot get there now.
    waits: Option<String>,
    /// It was asked to get there.
    asked: bool,
    /// Optional components that nobody waits for.
    absent: BTreeSet<&'a str>,
}

/// What stands before one place.
#[derive(Default)]
struct Before<'a> {
    gate: Gate,
    absent: BTreeSet<&'a str>,
    /// It is part of a circle, in which everybody waits.
    in_cycle: bool,
}

impl<'a> Order<'a> {
    /// Visits every component after those it waits for, with what stands before it. Members of a cycle are told that
    /// they wait; a visitor that must act all the same sees only edges that do not close a circle.
    pub fn walk(&self, mut visit: impl FnMut(&'a str, Gate) -> Standing) -> PassedOver<'a> {
        let mut over = PassedOver::new();
        let mut passed: Vec<Option<Passed<'a>>> = vec![None; self.graph.node_count()];
        // Its groups come in reverse topological order.
        for mut group in kosaraju_scc(&self.graph).into_iter().rev() {
            group.sort_unstable();
            let cycle = self.is_cycle(&group).then(|| {
                let names = self.names(&group).join(", ");
                format!("its {} orders form a cycle of {names}", self.name)
            });
            for node in group {
                let Place::Component(member) = self.graph[node] else {
                    passed[node.index()] = Some(self.level(node, &passed, cycle.as_ref()));
                    continue;
                };
                let mut before = self.before(node, member, &passed);
                if cycle.is_some() {
                    before.gate.waits.clone_from(&cycle);
                    before.in_cycle = true;
                }
                let own = self.pass(member, before, &mut visit, &mut over);
                passed[node.index()] = Some(own);
            }
        }
        over
    }

    /// What is to be awaited because of a level: its members, and the level below when they have no step at all.
    fn level(
        &self,
        node: NodeIndex,
        passed: &[Option<Passed<'a>>],
        cycle: Option<&String>,
    ) -> Passed<'a> {
        let mut level = Passed::default();
        let mut below = Passed::default();
        for edge in self.graph.edges_directed(node, Direction::Incoming) {
            let Some(before) = &passed[edge.source().index()] else {
                continue;
            };
            if level.waits.is_none() {
                level.waits.clone_from(&before.waits);
            }
            let into = match self.graph[edge.source()] {
                Place::Level => &mut below,
                Place::Component(_) => &mut level,
            };
            let own = match before.optional {
                true => &mut into.through.ends,
                false => &mut into.through.needs,
            };
            own.extend(&before.own);
            into.through.add(&before.through);
            into.absent.extend(&before.absent);
        }
        // Where somebody may go on without a member, that does not speak for the level below.
        let go_on = self.timeouts.iter().any(|t| t.then == OnTimeout::GoOn);
        if go_on || level.through.is_empty() {
            level.through.add(&below.through);
            level.absent.append(&mut below.absent);
        }
        level.waits = cycle.cloned().or(level.waits);
        level
    }

    fn before(
        &self,
        node: NodeIndex,
        member: Member<'a>,
        passed: &[Option<Passed<'a>>],
    ) -> Before<'a> {
        let mut before = Before::default();
        before.gate.wait_ms = self.wait_ms.get(member.name).copied().unwrap_or_default();
        let mut limits = Limits::default();
        for edge in self.graph.edges_directed(node, Direction::Incoming) {
            let Some(source) = &passed[edge.source().index()] else {
                continue;
            };
            before.add(edge.weight().rule, source);
            if !self.timeouts.is_empty() {
                limits.add(*edge.weight(), source);
            }
        }
        before.gate.limits = limits.settle(&self.timeouts, &before.gate);
        before
    }

    fn pass(
        &self,
        member: Member<'a>,
        before: Before<'a>,
        visit: &mut impl FnMut(&'a str, Gate) -> Standing,
        over: &mut PassedOver<'a>,
    ) -> Passed<'a> {
        let Member { name, required } = member;
        let Before {
            gate,
            absent,
            in_cycle,
        } = before;
        let waits = gate.waits.clone();
        let carried = carried(&gate);
        let holds_up = required || in_cycle;
        let (own, certain) = match visit(name, gate) {
            Standing::Done => return Passed::default(),
            Standing::Steps(own) => (own, false),
            Standing::Certain(own) => (own, true),
            Standing::Asked(why) => {
                return Passed {
                    asked: true,
                    ..self.held_up(name, &format!(", which {why}"))
                };
            }
            Standing::Waits if holds_up => return self.held_up(name, ""),
            Standing::WaitsAs(why) if holds_up => {
                return self.held_up(name, &format!(", which {why}"));
            }
            Standing::Waits | Standing::WaitsAs(_) => {
                return Passed {
                    through: carried,
                    waits,
                    absent: absent.into_iter().chain([name]).collect(),
                    ..Passed::default()
                };
            }
        };
        for absent in absent {
            over.entry(absent).or_default().insert(name);
        }
        let mut passed = Passed {
            own,
            optional: !required,
            ..Passed::default()
        };
        // The success of a required one says that all the rest succeeded, and the end of what is never given up that
        // all the rest has ended.
        if !required && !certain {
            passed.through = carried;
        }
        passed
    }

    /// Who comes after a component waits, since that one does.
    fn held_up(&self, name: &str, why: &str) -> Passed<'a> {
        Passed {
            waits: Some(format!("waits for {name}{why} ({} order)", self.name)),
            ..Passed::default()
        }
    }
}

impl<'a> Before<'a> {
    fn add(&mut self, rule: Rule, source: &Passed<'a>) {
        let gate = &mut self.gate;
        let content = source.asked && matches!(rule, Rule::Async { .. });
        if gate.waits.is_none() && !content {
            gate.waits.clone_from(&source.waits);
        }
        self.absent.extend(&source.absent);
        let through = &source.through;
        let through = through.needs.iter().chain(&through.ends);
        let all = source.own.iter().chain(through.clone());
        gate.because.extend(all.map(|ix| (*ix, rule)));
        if let Rule::Async { .. } = rule {
            // A request that is never sent counts as sent once it could have been.
            gate.starts.extend(&source.own);
            gate.ends.extend(through);
            return;
        }
        match source.optional {
            true => gate.ends.extend(&source.own),
            false => gate.needs.extend(&source.own),
        }
        gate.needs.extend(&source.through.needs);
        gate.ends.extend(&source.through.ends);
    }
}

/// What stands before a component, but for what it may go on without.
fn carried(gate: &Gate) -> Awaited {
    let go_on = gate.limits.iter().filter(|l| l.then == OnTimeout::GoOn);
    let limited: BTreeSet<Ix> = go_on.flat_map(|limit| &limit.steps).copied().collect();
    Awaited {
        needs: &gate.needs - &limited,
        ends: &gate.ends - &limited,
    }
}
