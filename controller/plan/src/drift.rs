//! What a person changed by hand since a plan last did, and whether it is put back (`rtsctl.drift`).
//!
//! The manager keeps a mark for each such change, which says what was desired at that moment: the change is drift as
//! long as the same is desired, and dies with the instance. What differs without a mark is never drift. A configuration
//! has a mark for each value ([`crate::mark`]): some of its differences may be drift, and others not. A component that
//! was deactivated was to be Active, whatever else is desired: that is drift until it is activated.
//!
//! - What is repaired is planned like any difference, with a reason that says who made it.
//! - What is left is no difference: it has no change and no step. It is there as long as it works: a connector that a
//!   person made and that is lost is replaced, or removed, as any other.
//! - A component that was deactivated and is left so is not Active all the same: required, it holds up what is ordered
//!   after it. A connector that is left out is missing for `onDisconnect`: its ends are not Active without it, but
//!   none is deleted for it, since the mark would go with it.
//! - What no profile can say is not adopted but left; the values of a component that was deactivated are.
//!
//! Digests are made and marks read only where there is a mark, so that a plan of a system without drift costs nothing
//! more.

use rts_schemas::system::DriftPolicy;

use crate::decide::Decisions;
use crate::desired::{Desired, PlacedComponent};
use crate::in_place::{Setting, settings};
use crate::index::{Facts, Id, Keys};
use crate::links::Links;
use crate::mark::Mark;
use crate::observed::{ComponentObserved, LifeCycleState, Observed};
use crate::peers;
use crate::plan::{Blocked, Drift, DriftKind, FieldChange};
use crate::target;

/// Why a deactivation is not adopted.
const INACTIVE: &str = "no profile can say that it is Inactive";

/// What a person changed by hand, and why it, or a part of it, is not adopted, where it was to be.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub drift: Drift,
    /// A drift of which nothing is adopted has the policy `ignore`.
    pub not_adopted: Option<&'static str>,
}

impl Found {
    pub fn new(drift: Drift) -> Self {
        Self {
            drift,
            not_adopted: None,
        }
    }

    /// Is left and not adopted, if it was to be.
    #[must_use]
    pub fn unless(mut self, obstacle: Option<&'static str>) -> Self {
        if self.drift.policy == DriftPolicy::Adopt && obstacle.is_some() {
            self.drift.policy = DriftPolicy::Ignore;
            self.not_adopted = obstacle;
        }
        self
    }

    /// Is adopted, if it was to be, but for one part of it.
    #[must_use]
    pub fn but_for(mut self, obstacle: &'static str) -> Self {
        self.not_adopted = (self.drift.policy == DriftPolicy::Adopt).then_some(obstacle);
        self
    }

    /// True for what is not put back.
    pub fn left(&self) -> bool {
        self.drift.policy != DriftPolicy::Repair
    }

    /// What has to be said of it.
    pub fn note(&self) -> Option<String> {
        let (target, reason) = (&self.drift.target, &self.drift.reason);
        let why = self.not_adopted?;
        Some(match self.drift.policy {
            DriftPolicy::Adopt => format!(
                "{target} {reason}: its values are adopted, and it is left Inactive, since {why}"
            ),
            _ => format!("{target} {reason}: it is left and not adopted, since {why}"),
        })
    }
}

/// What a person changed by hand, sorted by target: as [`crate::plan()`] gives it, without the plan.
pub fn drift(desired: &Desired, observed: &Observed) -> Vec<Drift> {
    let keys = Keys::of(desired);
    let facts = Facts::new(&keys, desired, observed);
    let (decisions, links) = peers::settle(&facts, &Blocked::new());
    let found = found(&facts, &decisions, &links);
    found.into_iter().map(|found| found.drift).collect()
}

/// All of it, of components and connectors, sorted by target.
pub(crate) fn found<'a>(
    facts: &Facts<'a>,
    decisions: &Decisions<'a>,
    links: &Links<'a>,
) -> Vec<Found> {
    let present = decisions.present.iter();
    let own = present.filter_map(|(id, live)| component(facts, *id, *live));
    let mut all: Vec<Found> = own.chain(links.by_hand.values().cloned()).collect();
    let name = |found: &Found| (found.drift.target.clone(), found.drift.system.clone());
    all.sort_by_cached_key(name);
    all
}

/// What a person changed in a component that is there as desired, and can be seen.
fn component<'a>(facts: &Facts<'a>, id: Id<'a>, live: usize) -> Option<Found> {
    let live = &facts.lives[live];
    let (want, component) = (&facts.wants[&id], live.component);
    let placed = want.placed;
    if component.by_hand.is_empty() || !live.manager.responsive {
        return None;
    }
    if component.recreate_hash != placed.recreate_hash || live.seat() != want.seat() {
        return None;
    }
    let mark = Mark::of(component);
    let settings = settings(&placed.spec, component);
    let by_hand = settings.iter().filter(|setting| setting.is_drift(&mark));
    let mut fields: Vec<_> = by_hand.map(Setting::drift).collect();
    let changed = !fields.is_empty();
    let idle = deactivated(component);
    fields.extend(idle.then(|| FieldChange {
        field: "state".to_owned(),
        old: Some("Active".to_owned()),
        new: Some("Inactive".to_owned()),
    }));
    let reason = match (changed, idle) {
        (false, false) => return None,
        (true, false) => "was changed by hand",
        (false, true) => "was deactivated by hand",
        (true, true) => "was changed and deactivated by hand",
    };
    let drift = Drift {
        target: target::component(id.instance),
        system: want.system.name.clone(),
        policy: placed.spec.policy.drift,
        kind: DriftKind::Changed,
        reason: reason.to_owned(),
        fields,
    };
    let found = Found::new(drift);
    Some(match (idle, changed) {
        (true, false) => found.unless(Some(INACTIVE)),
        // Its values are adopted.
        (true, true) => found.but_for(INACTIVE),
        _ => found,
    })
}

/// True when it is Inactive since a person deactivated it, whatever is desired of it now: that it is Active always is.
pub(crate) fn deactivated(live: &ComponentObserved) -> bool {
    live.by_hand.deactivated.is_some() && live.state == LifeCycleState::Inactive
}

/// True when a person deactivated it and it is left so.
pub(crate) fn left_inactive(placed: &PlacedComponent, live: &ComponentObserved) -> bool {
    placed.spec.policy.drift != DriftPolicy::Repair && deactivated(live)
}
