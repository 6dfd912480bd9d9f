//! Laws on what a person changed by hand, attacked with random systems, histories and hands.

use std::collections::BTreeSet;

use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use rts_plan::desired::Desired;
use rts_plan::observed::Observed;
use rts_plan::plan::{Blocked, Drift, DriftKind};
use rts_plan::{StoredSystem, drift, plan, with_drift};
use rts_schemas::system::{DriftPolicy, OnDisconnect};

use crate::lab::shape::shape;
use crate::lab::{Event, Lab, events, hand, has, with_components, without};
use crate::world::World;
use crate::world::by_hand::Hand;
use crate::world::specs::set;

fn hands() -> impl Strategy<Value = Vec<Hand>> {
    prop::collection::vec(hand(), 1..6)
}

/// Events without those that only a person can mend.
fn mended(events: &[Event]) -> Vec<Event> {
    without(events, |event| {
        matches!(
            event,
            Event::ByHand(..) | Event::Error(_) | Event::Hold(_) | Event::Hand(_)
        )
    })
}

/// A world that is as desired, in which a person has done something since.
fn touched(seed: u64, events: &[Event], hands: &[Hand]) -> Result<Lab, TestCaseError> {
    let mut lab = Lab::after(seed, events)?;
    lab.world.calm();
    lab.converge()?;
    hands.iter().for_each(|hand| lab.world.by_hand(hand));
    Ok(lab)
}

fn left(drift: &Drift) -> bool {
    drift.policy != DriftPolicy::Repair
}

/// Incarnations of the components that a drift lives in.
fn homes(world: &World, drift: &Drift) -> BTreeSet<String> {
    let mut homes = BTreeSet::new();
    for (_, _, component) in world.components() {
        if drift.target == rts_plan::target::component(&component.instance) {
            homes.insert(component.incarnation.clone());
        }
        let name = drift.target.strip_prefix("connector/").unwrap_or_default();
        if component.by_hand.disconnected.contains_key(name) {
            homes.insert(component.incarnation.clone());
        }
        for connector in component.connectors.iter().filter(|c| c.name == name) {
            homes.insert(component.incarnation.clone());
            homes.insert(connector.target_incarnation.clone());
        }
    }
    homes
}

fn there(world: &World) -> BTreeSet<String> {
    let all = world.components();
    all.map(|(_, _, c)| c.incarnation.clone()).collect()
}

/// Applies every system as `change` makes it.
fn apply(lab: &mut Lab, change: impl Fn(&mut StoredSystem)) {
    for mut system in lab.world.systems.clone() {
        if !system.deleting {
            change(&mut system);
            lab.world.apply(system);
        }
    }
}

/// Stores the systems with what was changed by hand.
fn fold(lab: &mut Lab, which: impl Fn(&Drift) -> bool) {
    let drift = lab.drift();
    apply(lab, |system| {
        system.spec = with_drift(&system.spec, &drift, &which).0;
    });
}

/// What was left before is so still, as long as what it lives in is there.
fn stays_left(before: &World, drift: &[Drift], lab: &Lab) -> TestCaseResult {
    let there = there(&lab.world);
    let after = lab.plan().drift;
    for drift in drift.iter().filter(|drift| left(drift)) {
        let stays = homes(before, drift).is_subset(&there);
        prop_assert!(
            !stays || after.contains(drift),
            "{:#?}\n{:#?}",
            drift,
            after
        );
    }
    Ok(())
}

fn in_step_but_for(lab: &Lab, but: &BTreeSet<String>) -> TestCaseResult {
    let plan = lab.plan();
    let changes = plan.changes.iter().map(|c| &c.target);
    let steps = plan.steps.iter().map(|s| &s.target);
    let targets = changes
        .chain(steps)
        .chain(plan.drift.iter().map(|d| &d.target));
    for target in targets {
        prop_assert!(but.contains(target), "{} is not in step: {}", target, plan);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// What nobody changed by hand is no drift, whatever happens to it.
    #[test]
    fn only_a_person_makes_drift(seed: u64, events in events()) {
        let events = without(&events, |event| matches!(event, Event::Hand(_)));
        let lab = Lab::after(seed, &events)?;
        prop_assert_eq!(lab.drift(), []);
    }

    /// What is ignored, or to be adopted, stays through every plan, as long as what it lives in does.
    #[test]
    fn what_is_left_is_not_touched(seed: u64, events in events(), hands in hands()) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        hands.iter().for_each(|hand| lab.world.by_hand(hand));
        let before = lab.world.clone();
        let drift = lab.plan().drift;
        lab.converge()?;
        stays_left(&before, &drift, &lab)?;
    }

    /// Left drift alone is no difference: nothing is to be done, and nobody waits.
    #[test]
    fn what_is_left_is_no_difference(seed: u64, events in events(), hands in hands()) {
        let events = with_components(&mended(&events), |component| {
            component.policy.drift = DriftPolicy::Ignore;
            component.policy.on_disconnect = OnDisconnect::Keep;
        });
        let lab = touched(seed, &events, &hands)?;
        let plan = lab.plan();
        prop_assert!(plan.in_step(), "{}", plan);
        prop_assert!(lab.difference().is_empty());
    }

    /// What is repaired is as desired in the end.
    #[test]
    fn what_is_repaired_goes(seed: u64, events in events(), hands in hands()) {
        let mut lab = touched(seed, &mended(&events), &hands)?;
        apply(&mut lab, |system| {
            for component in &mut system.spec.components {
                component.policy.drift = DriftPolicy::Repair;
            }
        });
        let plan = lab.plan();
        let changed: BTreeSet<_> = plan.changes.iter().map(|c| c.target.as_str()).collect();
        for drift in &plan.drift {
            prop_assert!(changed.contains(drift.target.as_str()), "{}", plan);
        }
        lab.converge()?;
        let plan = lab.plan();
        prop_assert!(plan.in_step() && plan.drift.is_empty(), "{}", plan);
        prop_assert_eq!(lab.difference(), Vec::<String>::new());
    }

    /// Once something else is desired, that comes, whatever the policy: each value for itself. What was deactivated
    /// stays so.
    #[test]
    fn a_new_wish_replaces_what_was_changed(seed: u64, events in events(), hands in hands(), values: bool) {
        let mut lab = touched(seed, &mended(&events), &hands)?;
        let before = lab.drift();
        apply(&mut lab, |system| {
            for component in &mut system.spec.components {
                component.configuration.active = Some("slow".to_owned());
                if values {
                    set(component, "gain", "9.75");
                }
            }
            for connector in &mut system.spec.connectors {
                let how = "dataport.subscription_type".to_owned();
                connector.properties.insert(how, "block".to_owned());
            }
        });
        lab.converge()?;
        let plan = lab.plan();
        // Who is ordered after one that a person stopped, and that is left so, waits for it.
        let stopped = plan.drift.iter().any(|drift| left(drift) && has(drift, "state"));
        prop_assert!(plan.in_step() || stopped && plan.steps.is_empty(), "{}", plan);
        for now in plan.drift.iter().filter(|d| d.kind != DriftKind::Extra) {
            let had = before.iter().filter(|d| d.target == now.target);
            let had: Vec<_> = had.flat_map(|d| &d.fields).map(|f| &f.field).collect();
            for field in &now.fields {
                let stays = field.field == "state" || !values && field.field.ends_with(".gain");
                // One that is to be put back may have to wait for one that is left.
                let may = left(now) || stopped;
                prop_assert!(may && stays && had.contains(&&field.field), "{:#?}", now);
            }
        }
    }

    /// A change of the profile elsewhere ends no drift: not of the other values, nor that it was deactivated.
    #[test]
    fn what_is_left_stays_when_something_else_changes(seed: u64, events in events(), hands in hands()) {
        let mut lab = touched(seed, &mended(&events), &hands)?;
        let before = lab.world.clone();
        let drift = lab.drift();
        apply(&mut lab, |system| {
            for component in &mut system.spec.components {
                set(component, "other", "9.75");
            }
        });
        lab.world.calm();
        lab.converge()?;
        stays_left(&before, &drift, &lab)?;
    }

    /// With all drift written into the system, what runs is as desired; but for what was deactivated.
    #[test]
    fn what_is_exported_is_what_runs(seed: u64, events in events(), hands in hands()) {
        let mut lab = touched(seed, &mended(&events), &hands)?;
        let drift = lab.drift().into_iter();
        let idle = drift.filter(|d| has(d, "state")).map(|d| d.target).collect();
        fold(&mut lab, |_| true);
        in_step_but_for(&lab, &idle)?;
    }

    /// What was to be adopted is desired afterwards, and is not touched for it.
    #[test]
    fn what_is_adopted_is_desired(seed: u64, events in events(), hands in hands()) {
        let mut lab = touched(seed, &mended(&events), &hands)?;
        let adopts = |drift: &Drift| drift.policy == DriftPolicy::Adopt;
        let adopted: Vec<Drift> = lab.drift().into_iter().filter(adopts).collect();
        let touched_before: BTreeSet<_> = lab.plan().changes.into_iter().map(|c| c.target).collect();
        fold(&mut lab, adopts);
        let plan = lab.plan();
        prop_assert!(!plan.drift.iter().any(adopts), "{:#?}", plan.drift);
        for drift in adopted {
            let step = plan.steps.iter().find(|step| step.target == drift.target);
            let before = touched_before.contains(&drift.target);
            prop_assert!(before || step.is_none(), "{:?}\n{}", step, plan);
        }
    }

    /// What was adopted goes when the system of before is applied again: nothing remembers it.
    #[test]
    fn what_was_adopted_goes_back(seed: u64, events in events(), hands in hands()) {
        let events = with_components(&mended(&events), |c| c.policy.drift = DriftPolicy::Adopt);
        let mut lab = touched(seed, &events, &[])?;
        let (before, systems) = (shape(&lab.world), lab.world.systems.clone());
        let settled = |hand: &&Hand| !matches!(hand, Hand::Activate(_) | Hand::Deactivate(_));
        hands.iter().filter(settled).for_each(|hand| lab.world.by_hand(hand));
        fold(&mut lab, |_| true);
        prop_assert!(lab.plan().in_step(), "{}", lab.plan());
        lab.world.calm();
        lab.world.systems = systems;
        lab.converge()?;
        prop_assert!(lab.plan().in_step(), "{}", lab.plan());
        prop_assert_eq!(lab.drift(), []);
        prop_assert_eq!(before, shape(&lab.world));
    }

    /// An agent sees the same in its own node as the controller does.
    #[test]
    fn agents_see_the_same(seed: u64, events in events(), hands in hands()) {
        let lab = touched(seed, &mended(&events), &hands)?;
        let (mut desired, observed) = (lab.world.desired(), lab.world.observed());
        let all = drift(&desired, &observed);
        prop_assert_eq!(&all, &plan(&desired, &observed, &Blocked::new()).drift);
        let mut seen = Vec::new();
        for (node, answer) in observed.nodes {
            let (mut own, mut inventory) = (Desired::default(), Observed::default());
            own.nodes.extend(desired.nodes.remove_entry(&node));
            inventory.nodes.insert(node, answer);
            seen.extend(plan(&own, &inventory, &Blocked::new()).drift);
        }
        seen.sort_by(|a, b| (&a.target, &a.system).cmp(&(&b.target, &b.system)));
        let what = |d: Drift| (left(&d), d.target, d.system, d.kind, d.fields);
        let (seen, all): (Vec<_>, Vec<_>) =
            (seen.into_iter().map(what).collect(), all.into_iter().map(what).collect());
        prop_assert_eq!(seen, all);
    }
}
