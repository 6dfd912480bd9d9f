//! Laws that hold for every plan, attacked with random systems, random starting states and random failures.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;
use rts_plan::place::{Context, recreate_hash};
use rts_plan::plan;
use rts_plan::plan::Work;
use rts_schemas::system::DriftPolicy;

use crate::lab::shape::shape;
use crate::lab::trouble::trouble;
use crate::lab::{Event, Lab, events, with_components, without};
use crate::world::World;
use crate::world::specs::system;

fn incarnations(world: &World) -> BTreeMap<String, String> {
    let all = world.components();
    all.map(|(_, _, c)| {
        (
            c.incarnation.clone(),
            format!("{:?} {}", c.state, c.instance),
        )
    })
    .collect()
}

fn by_hand(world: &World) -> BTreeSet<String> {
    let own = world
        .components()
        .filter(|(_, key, _)| key.system.is_none());
    own.filter(|(_, _, c)| c.system.is_none())
        .map(|(_, _, c)| c.incarnation.clone())
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// From any state, repeated plans come to an end, and then all is as desired or said to wait.
    #[test]
    fn converges(seed: u64, events in events()) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        lab.converge()?;
        let waiting: BTreeSet<String> =
            lab.plan().waiting_on.into_iter().map(|w| w.target).collect();
        for missing in lab.difference() {
            let said = [format!("component/{missing}"), format!("connector/{missing}")];
            prop_assert!(said.iter().any(|t| waiting.contains(t)), "{} is missing in silence", missing);
        }
    }

    /// Without something that only a person can mend, nothing waits in the end.
    #[test]
    fn nothing_waits_for_ever(seed: u64, events in events()) {
        let events = without(&events, |event| {
            matches!(event, Event::ByHand(..) | Event::Error(_) | Event::Hold(_))
        });
        let events = with_components(&events, |c| c.policy.drift = DriftPolicy::Repair);
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        lab.converge()?;
        prop_assert_eq!(lab.plan().waiting_on, []);
        prop_assert_eq!(lab.difference(), Vec::<String>::new());
        prop_assert!(lab.world.managers().all(|(_, m)| m.expired.is_none()));
        lab.agents_agree()?;
    }

    /// The way there and the way back lead to where it began: places, contents, settings and connectors are as before.
    #[test]
    fn there_and_back(seed: u64, one in system("a", "C", 8), other in system("a", "C", 8)) {
        let mut lab = Lab::after(seed, &[Event::Apply(Box::new(one.clone()))])?;
        lab.converge()?;
        let before = shape(&lab.world);
        lab.world.apply(other);
        lab.converge()?;
        lab.world.apply(one.clone());
        lab.converge()?;
        prop_assert!(lab.plan().in_step(), "{}", lab.plan());
        prop_assert_eq!(before, shape(&lab.world));
    }

    /// What is missing, and can be seen to be, is a change, whether something can be done about it now or not.
    #[test]
    fn what_is_missing_is_a_change(seed: u64, events in events()) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        let plan = plan(&lab.world.desired(), &lab.world.observed(), &lab.blocked);
        let changed: BTreeSet<String> = plan.changes.iter().map(|c| c.target.clone()).collect();
        for missing in lab.difference() {
            let said = [format!("component/{missing}"), format!("connector/{missing}")];
            prop_assert!(said.iter().any(|t| changed.contains(t)), "{} is missing: {}", missing, plan);
        }
    }

    /// A converged world gets an empty plan, whoever asks how often.
    #[test]
    fn same_input_same_plan(seed: u64, events in events()) {
        let lab = Lab::after(seed, &events)?;
        let (desired, observed) = (lab.world.desired(), lab.world.observed());
        let once = plan(&desired, &observed, &lab.blocked);
        prop_assert_eq!(&once, &plan(&desired, &observed, &lab.blocked));
        prop_assert!(once.steps.is_empty() || !once.changes.is_empty());
    }

    /// Teardown leaves nothing but what a person made, and does not touch that.
    #[test]
    fn teardown_leaves_nothing(seed: u64, events in events(), silent in any::<u16>(), unseen in any::<u16>()) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        // Managers that do not answer, whichever, do not matter; nor does it that nobody knows what is in them.
        for nth in 0..16 {
            if silent >> nth & 1 == 0 {
                continue;
            }
            if unseen >> nth & 1 == 1 {
                lab.world.lose_sight_of_manager(nth);
            } else if let Some(manager) = lab.world.managers_mut().nth(nth) {
                manager.responsive = false;
            }
        }
        let mine = by_hand(&lab.world);
        lab.world.delete("a");
        lab.world.delete("b");
        lab.converge()?;
        let left: Vec<_> = lab.world.managers().filter(|(_, m)| m.key.system.is_some()).collect();
        prop_assert!(left.is_empty(), "{:?}", left);
        prop_assert_eq!(mine, by_hand(&lab.world));
    }

    /// One system's end is not felt in another.
    #[test]
    fn systems_do_not_disturb_each_other(
        seed: u64,
        events in events(),
        other in system("b", "D", 3),
    ) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        lab.world.apply(other);
        lab.converge()?;
        let of_b = |world: &World| -> BTreeMap<String, String> {
            let all = world.components().filter(|(_, _, c)| c.instance.starts_with('D'));
            all.map(|(_, _, c)| (c.incarnation.clone(), format!("{:?} {:?}", c.state, c.connectors))).collect()
        };
        let before = of_b(&lab.world);
        lab.world.delete("a");
        let teardown = lab.plan();
        let felt = teardown.steps.iter().find(|s| s.system.as_ref().is_some_and(|s| s.name == "b"));
        prop_assert!(felt.is_none(), "{:?}", felt);
        lab.converge()?;
        prop_assert_eq!(before, of_b(&lab.world));
    }

    /// Once a plan was carried out, nothing that must not be is Active without one of its connectors, whatever is
    /// blocked or held, and whether or not the managers have acted.
    #[test]
    fn nobody_is_active_without_its_peers(
        seed: u64,
        events in events(),
        settle: bool,
        troubles in prop::collection::vec(trouble(), 0..5),
    ) {
        let mut lab = Lab::after(seed, &events)?;
        if settle {
            lab.world.calm();
            lab.converge()?;
        }
        troubles.iter().for_each(|trouble| lab.trouble(trouble));
        let dim = lab.dim();
        let plan = plan(&lab.world.desired(), &lab.world.observed(), &lab.blocked);
        lab.nothing_is_made_without_its_peers(&plan, &dim)?;
        let run = lab.run(&plan, None)?;
        if !run.failed.is_empty() {
            return Ok(());
        }
        for (instance, connector) in lab.without_peers(&dim) {
            prop_assert!(false, "{} is Active without {}: {}\n{:#?}", instance, connector, plan, plan.steps);
        }
    }

    /// What an agent holds is not made, by nobody.
    #[test]
    fn held_is_not_made(seed: u64, events in events(), holds in prop::collection::vec(0..9usize, 0..3)) {
        let mut lab = Lab::after(seed, &events)?;
        holds.iter().for_each(|nth| lab.world.hold(*nth));
        let held: BTreeSet<(&String, &String)> = lab.world.nodes.iter()
            .flat_map(|(node, inventory)| inventory.held.iter().map(move |h| (node, h)))
            .filter(|(_, held)| !lab.world.components().any(|(_, _, c)| {
                c.instance == held.instance && c.system.as_ref() == Some(&held.system)
            }))
            .map(|(node, held)| (node, &held.instance))
            .collect();
        for step in &lab.plan().steps {
            if let Work::Create { instance, .. } = &step.work {
                prop_assert!(!held.contains(&(&step.node, instance)), "{:?}", step);
            }
        }
    }

    /// What is as desired is not touched: whatever a plan does, a component whose place and hash are right, in a
    /// process in which no module changed and that has not expired, stays the same instance and is never deactivated;
    /// but for one that lost a peer and must not go on without it.
    #[test]
    fn settled_is_not_touched(seed: u64, events in events(), fail in 1..9usize) {
        let mut lab = Lab::after(seed, &events)?;
        let desired = lab.world.desired();
        let plan = lab.plan();
        let mut settled = BTreeSet::new();
        for (node, manager) in lab.world.managers() {
            let parts = &desired.nodes[node].systems;
            let part = parts.iter().find(|p| Some(&p.system) == manager.key.system.as_ref());
            let Some(part) = part.filter(|_| manager.expired.is_none()) else { continue };
            let place = |instance: &str| part.components.iter().find(|p| p.spec.instance == instance && p.manager == manager.key.name);
            let old_code = part.components.iter().any(|p| p.stand_in.is_none() && p.manager == manager.key.name && manager.opened.get(&p.spec.type_name).is_some_and(|opened| Some(opened) != p.module_digest.as_ref()));
            let changed = old_code || manager.components.iter().any(|c| place(&c.instance).is_some_and(|p| {
                let with_new_module = recreate_hash(&c.type_name, p.module_digest.as_deref(), &p.manager, &Context::found(c), None);
                p.stand_in.is_none() && !c.stand_in && p.spec.type_name == c.type_name && with_new_module != c.recreate_hash
            }));
            for component in &manager.components {
                let fits = component.system.as_ref() == Some(&part.system) && place(&component.instance).is_some_and(|p| p.recreate_hash == component.recreate_hash);
                if fits && !changed && !lab.waits_for_a_peer(&plan, &component.instance) {
                    settled.insert((component.incarnation.clone(), component.instance.clone(), node.to_owned(), manager.key.clone()));
                }
            }
        }
        for (_, instance, node, key) in &settled {
            for step in &plan.steps {
                let hit = match &step.work {
                    Work::Deactivate { manager, instance: i } | Work::Delete { manager, instance: i } => i == instance && manager == key && step.node == *node,
                    Work::StopManager { manager, .. } => manager == key && step.node == *node,
                    _ => false,
                };
                prop_assert!(!hit, "{:?}", step);
            }
        }
        lab.blocked.clear();
        lab.run(&plan, Some(fail))?;
        let there = incarnations(&lab.world);
        for (incarnation, instance, ..) in &settled {
            let by_itself = lab.world.stopped.contains(incarnation);
            prop_assert!(by_itself || there.contains_key(incarnation), "{} was lost", instance);
        }
    }
}
