//! Soft edges, and which of them give way in a cycle.

use std::collections::BTreeSet;

use petgraph::algo::kosaraju_scc;
use petgraph::graph::DiGraph;
use rts_schemas::system::{ConnectorSpec, PortKind};

use super::{Ix, Steps};
use crate::plan::{Rule, Work};
use crate::service::service_provider;

/// Why a step should come after another. The first gives way first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Preference {
    /// Data flows between them.
    DataFlow,
    /// One provides a service to the other.
    Service,
}

impl Preference {
    /// What a connector asks for: which of its ends (0 the source, 1 the target) comes up first and goes down last.
    pub fn of(spec: &ConnectorSpec) -> Option<(usize, Self)> {
        match spec.kind {
            // What it feeds comes first, so that no sample is lost.
            PortKind::Data => Some((1, Self::DataFlow)),
            PortKind::Service => {
                let provider = service_provider(spec)?;
                Some((usize::from(*provider == spec.target), Self::Service))
            }
        }
    }

    /// The rule by which work comes later.
    pub fn rule(self, later: &Work) -> Rule {
        match (self, later) {
            (Self::Service, _) => Rule::ProviderFirst,
            (Self::DataFlow, Work::Deactivate { .. }) => Rule::UpStreamFirst,
            (Self::DataFlow, _) => Rule::DownStreamFirst,
        }
    }
}

/// Preferences that were dropped in one cycle.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Dropped {
    pub why: Preference,
    /// Targets of the steps in the cycle, sorted.
    pub targets: Vec<String>,
}

impl Steps {
    /// Drops preferences inside cycles: data flow first, services only where a cycle remains.
    pub(super) fn drop_preferences(&mut self) -> Vec<Dropped> {
        let mut dropped = Vec::new();
        if self.drafts.iter().all(|draft| draft.prefers.is_empty()) {
            return dropped;
        }
        let mut open: BTreeSet<Ix> = (0..self.drafts.len()).collect();
        for why in [Preference::DataFlow, Preference::Service] {
            let cycles = self.cycles(&open);
            open = cycles.iter().flatten().copied().collect();
            for members in cycles {
                if !self.drop_among(&members, why) {
                    continue;
                }
                let targets = members.iter().map(|ix| self.drafts[*ix].target.clone());
                let targets: BTreeSet<String> = targets.collect();
                let targets = targets.into_iter().collect();
                dropped.push(Dropped { why, targets });
            }
        }
        dropped.sort();
        dropped.dedup();
        dropped
    }

    /// Drops those of one kind; false when there was none.
    fn drop_among(&mut self, members: &BTreeSet<Ix>, why: Preference) -> bool {
        let mut any = false;
        for ix in members {
            let prefers = &mut self.drafts[*ix].prefers;
            let before = prefers.len();
            prefers.retain(|(on, own)| *own != why || !members.contains(on));
            any |= prefers.len() < before;
        }
        any
    }

    /// Groups of at least two of `among` that stand before each other.
    fn cycles(&self, among: &BTreeSet<Ix>) -> Vec<BTreeSet<Ix>> {
        let mut graph: DiGraph<Ix, ()> = DiGraph::with_capacity(among.len(), 0);
        let mut nodes = vec![None; self.drafts.len()];
        for ix in among {
            nodes[*ix] = Some(graph.add_node(*ix));
        }
        for ix in among {
            for before in self.drafts[*ix].before() {
                if let (Some(from), Some(to)) = (nodes[before], nodes[*ix]) {
                    graph.add_edge(from, to, ());
                }
            }
        }
        let groups = kosaraju_scc(&graph).into_iter();
        groups
            .filter(|group| group.len() > 1)
            .map(|group| group.into_iter().map(|node| graph[node]).collect())
            .collect()
    }
}
