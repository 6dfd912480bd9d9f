//! Decides what happens to each connector.
//!
//! A connector dies with its source component. When only its target goes, or what it was made with changed, it is
//! disconnected at the source and made again; neither end is deactivated for it. What a person made of it by hand may be
//! left (`by_hand`).

mod by_hand;
pub(crate) mod compare;
mod left_overs;

use rts_schemas::system::PortKind;

use self::compare::Match;
use crate::decide::Decisions;
use crate::desired::{PlacedConnector, SystemRef};
use crate::drift::Found;
use crate::index::{Facts, Id, Link, LinkId};
use crate::observed::{ConnectorObserved, ConnectorState};
use crate::peers::Idle;
use crate::plan::{Blocked, FieldChange};
use crate::table::Table;
use crate::target;

/// A connector that is there and has to go.
#[derive(Debug)]
pub(crate) struct Cut<'a> {
    /// Its source, by index into `Facts::lives`.
    pub source: usize,
    pub system: Option<&'a SystemRef>,
    pub connector: &'a ConnectorObserved,
    /// The component at its other end, when that is taken down.
    pub dying_target: Option<usize>,
    pub reason: String,
}

/// A connector to make.
#[derive(Debug)]
pub(crate) struct Join<'a> {
    pub system: &'a SystemRef,
    pub connector: &'a PlacedConnector,
    /// The component at its source.
    pub source: Id<'a>,
    /// True when there was one of this name before.
    pub again: bool,
    pub fields: Vec<FieldChange>,
    pub reason: String,
}

/// A connector that cannot be made now.
#[derive(Debug)]
pub(crate) struct Wait<'a> {
    pub system: &'a SystemRef,
    pub reason: String,
    /// It is being made already.
    pub transient: bool,
    /// It is certain that it is not there; false where an end cannot be seen.
    pub missing: bool,
    /// Whether what is there of it works.
    pub flow: Flow,
}

/// Whether samples flow through a connector that is not as desired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    /// It is connected, and both ends stay.
    Yes,
    /// It is not connected.
    No,
    /// Its source cannot be seen, or it is being connected.
    Unknown,
}

/// All decisions about connectors, by system uid and name.
#[derive(Debug, Default)]
pub(crate) struct Links<'a> {
    pub cuts: Table<LinkId<'a>, Cut<'a>>,
    pub joins: Table<LinkId<'a>, Join<'a>>,
    /// What cannot be made now.
    pub waits: Table<LinkId<'a>, Wait<'a>>,
    /// Service connectors, which have no steps yet: system name and connector name.
    pub services: Vec<(&'a str, &'a str)>,
    /// The same of connectors at undetermined ports of stand-ins, and why.
    pub undetermined: Vec<(&'a str, &'a str, &'a str)>,
    /// Components that must not be Active for want of a connector.
    pub idle: Table<Id<'a>, Idle>,
    /// What a person changed by hand; what is left of it is in none of the above.
    pub by_hand: Table<LinkId<'a>, Found>,
}

/// One end of a desired connector once the plan is carried out.
enum End {
    /// The instance that is there stays.
    Stays(usize),
    /// It is created by the plan.
    Made,
    /// There will be none, or it cannot be seen, and why.
    Absent(String),
    /// On a node that this plan is not made for: an agent plans its own node alone, and the connect finds the rest.
    Elsewhere,
}

/// Decides.
pub(crate) fn decide<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    blocked: &Blocked,
) -> Links<'a> {
    let mut links = Links::default();
    left_overs::cut(facts, decisions, blocked, &mut links);
    for (key, link) in facts.links.iter() {
        if link.connector.spec.kind == PortKind::Service {
            // Of a system that goes nobody wants it.
            if link.ends.iter().any(|end| facts.wants.contains_key(end)) {
                links.services.push((link.system.name.as_str(), key.1));
            }
            continue;
        }
        if let Some(why) = &link.connector.undetermined {
            let system = link.system.name.as_str();
            links.undetermined.push((system, key.1, why));
            continue;
        }
        let linker = Linker {
            facts,
            decisions,
            blocked,
            key: *key,
            link: *link,
        };
        linker.decide(&mut links);
    }
    links.services.sort_unstable();
    links.undetermined.sort_unstable();
    links
}

struct Linker<'f, 'a> {
    facts: &'f Facts<'a>,
    decisions: &'f Decisions<'a>,
    blocked: &'f Blocked,
    key: LinkId<'a>,
    link: Link<'a>,
}

impl<'a> Linker<'_, 'a> {
    fn decide(self, links: &mut Links<'a>) {
        let source = self.end(0);
        let target = self.end(1);
        let observed = match &source {
            End::Stays(live) => self.observed(*live).map(|connector| (*live, connector)),
            _ => None,
        };
        let by_hand = match &source {
            End::Stays(live) => self.by_hand(*live, observed.map(|(_, connector)| connector)),
            _ => None,
        };
        if let Some(found) = &by_hand {
            links.by_hand.insert(self.key, found.clone());
            if found.left() {
                return self.leave(links, observed.map(|(_, connector)| connector));
            }
        }
        let Some((reason, fields)) = self.differs(links, &source, &target, observed) else {
            return;
        };
        let reason = by_hand.as_ref().map_or(reason, by_hand::repaired);
        let node = &self.link.connector.source.node;
        let name = || target::connector(self.key.1);
        if let Some(why) = target::why_blocked(self.blocked, node, name) {
            return self.wait(links, why.clone(), true);
        }
        if let Some((source, connector)) = observed {
            links.cuts.or_insert_with(self.key, || Cut {
                source,
                system: Some(self.link.system),
                connector,
                dying_target: None,
                reason: reason.clone(),
            });
        }
        let join = Join {
            system: self.link.system,
            connector: self.link.connector,
            source: self.id(0),
            again: self.had_before() || observed.is_some(),
            fields,
            reason,
        };
        links.joins.insert(self.key, join);
    }

    /// Why it is made, and what differs, when it is to be made and can be now; what cannot be made now waits.
    fn differs(
        &self,
        links: &mut Links<'a>,
        source: &End,
        target: &End,
        observed: Option<(usize, &'a ConnectorObserved)>,
    ) -> Option<(String, Vec<FieldChange>)> {
        let (why, missing) = match (source, target, observed) {
            (End::Elsewhere, _, _) => return None,
            (End::Absent(why), _, _) => (why, !self.unseen(0)),
            (_, End::Absent(why), observed) => {
                let unseen = self.unseen(1);
                let flows = observed.is_some_and(|(_, c)| c.state == ConnectorState::Connected);
                if unseen && flows {
                    return None;
                }
                (why, !unseen)
            }
            (_, End::Stays(_) | End::Elsewhere, Some((_, connector))) => {
                match self.compare(connector, target) {
                    Match::Same => {}
                    Match::Pending => self.pending(links),
                    Match::Differs(reason, fields) => return Some((reason, fields)),
                }
                return None;
            }
            (_, End::Made, Some(_)) => return Some((self.made_again(1), Vec::new())),
            (End::Made, _, _) if self.had_before() => {
                return Some((self.made_again(0), Vec::new()));
            }
            _ => return Some(("is not there yet".to_owned(), Vec::new())),
        };
        self.wait(links, why.clone(), missing);
        None
    }

    fn made_again(&self, end: usize) -> String {
        let role = ["source", "target"][end];
        format!("its {role} {} is made again", self.id(end).instance)
    }

    fn id(&self, end: usize) -> Id<'a> {
        self.link.ends[end]
    }

    fn end(&self, end: usize) -> End {
        let id = self.id(end);
        let Some(want) = self.facts.wants.get(&id) else {
            return End::Elsewhere;
        };
        match self.decisions.present.get(&id) {
            Some(_) if self.silent(id) => {
                let manager = want.key.display_name();
                End::Absent(format!("manager {manager} does not answer"))
            }
            Some(&live) if self.facts.lives[live].seat() == want.seat() => End::Stays(live),
            Some(_) => End::Absent(format!("{} is to move", id.instance)),
            None if self.decisions.makes.contains_key(&id) => End::Made,
            None => {
                let why = self.decisions.waits.get(&id);
                let why = why.map_or("nothing makes it", String::as_str);
                let unknown = self.facts.unknown.contains_key(want.node);
                let there = match unknown || self.decisions.unseen.contains(&id) {
                    true => "cannot be seen",
                    false => "is not there",
                };
                End::Absent(format!("{} {there}: {why}", id.instance))
            }
        }
    }

    /// True when a component lies in a manager that does not answer, or may do so.
    fn silent(&self, id: Id<'a>) -> bool {
        by_hand::silent(self.facts, self.decisions, id)
    }

    fn observed(&self, live: usize) -> Option<&'a ConnectorObserved> {
        let connectors = &self.facts.lives[live].component.connectors;
        connectors
            .iter()
            .find(|c| c.name == self.link.connector.spec.name)
    }

    /// True when the source that is made again had this connector.
    fn had_before(&self) -> bool {
        let make = self.decisions.makes.get(&self.id(0));
        let old = make.and_then(|make| make.old);
        old.is_some_and(|live| self.observed(live).is_some())
    }

    /// True when nobody can say what is at an end.
    fn unseen(&self, end: usize) -> bool {
        let places = [&self.link.connector.source, &self.link.connector.target];
        self.facts.unknown.contains_key(places[end].node.as_str()) || self.silent(self.id(end))
    }

    fn wait(&self, links: &mut Links<'a>, reason: String, missing: bool) {
        let wait = Wait {
            system: self.link.system,
            reason,
            transient: false,
            missing,
            flow: self.flow(),
        };
        links.waits.insert(self.key, wait);
    }

    /// Leaves what a person made of it.
    fn leave(&self, links: &mut Links<'a>, observed: Option<&ConnectorObserved>) {
        if observed.is_some_and(|c| c.state == ConnectorState::Connecting) {
            self.pending(links);
        }
    }

    fn pending(&self, links: &mut Links<'a>) {
        let wait = Wait {
            system: self.link.system,
            reason: "is being connected".to_owned(),
            transient: true,
            missing: false,
            flow: Flow::Unknown,
        };
        links.waits.insert(self.key, wait);
    }
}
