//! Laws of order, attacked with random systems and random failures.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;
use rts_plan::plan::{Plan, Rule, Step, StepId, Work};
use rts_plan::{StoredSystem, service_provider};
use rts_schemas::system::{Orders, PortKind};

use crate::lab::{Event, Lab, events, without};
use crate::world::specs::{NODES, system};

/// No orders; data flows, and services are called, from lower to higher numbers only. One connector in three is a
/// service.
fn silent_profile() -> impl Strategy<Value = StoredSystem> {
    system("a", "C", 8).prop_map(|mut system| {
        let spec = &mut system.spec;
        spec.orders = Orders::default();
        spec.connectors
            .retain(|c| c.source.instance < c.target.instance);
        for connector in spec.connectors.iter_mut().step_by(3) {
            connector.kind = PortKind::Service;
            let (consumer, provider) = (&connector.source, &connector.target);
            let key = format!("{}.port.{}.required.I.i", consumer.instance, consumer.port);
            let value = format!("{}.port.{}.provided.I.i", provider.instance, provider.port);
            connector.properties.insert(key, value);
        }
        system
    })
}

fn instance(step: &Step) -> Option<&str> {
    match &step.work {
        Work::Activate { instance, .. } | Work::Deactivate { instance, .. } => Some(instance),
        _ => None,
    }
}

/// When each component was asked; those that never were are not there.
fn asked<'p>(plan: &'p Plan, asked: &[StepId]) -> BTreeMap<&'p str, usize> {
    let step = |id: &StepId| &plan.steps[*id as usize - 1];
    let all = asked.iter().enumerate();
    all.filter_map(|(when, id)| Some((instance(step(id))?, when)))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// However far a plan has been carried out, no step was done before what its orders name: the simulated world reads
    /// them from the profile, and looks at every step.
    #[test]
    fn order_is_respected_in_every_prefix(
        seed: u64,
        events in events(),
        states in prop::collection::vec(0..4u8, 12),
        fail in 1..12usize,
    ) {
        let mut lab = Lab::after(seed, &events)?;
        lab.set_states(&states);
        let plan = lab.plan();
        lab.blocked.clear();
        lab.run(&plan, Some(fail))?;
        lab.world.calm();
        lab.converge()?;
        lab.world.delete("a");
        let teardown = lab.plan();
        lab.run(&teardown, Some(fail + 2))?;
    }

    /// Agents without a controller, each of which sees its own node alone, break no order among nodes either.
    #[test]
    fn agents_alone_break_no_order(
        seed: u64,
        events in events(),
        kills in prop::collection::vec(0..9usize, 1..5),
        states in prop::collection::vec(0..4u8, 12),
    ) {
        let events = without(&events, |event| matches!(event, Event::Hand(_)));
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        lab.converge()?;
        kills.into_iter().for_each(|nth| lab.world.kill(nth));
        lab.set_states(&states);
        // Twice: what one node brings up, the connectors of another reach.
        for node in NODES.into_iter().chain(NODES) {
            lab.run_alone(node)?;
        }
    }

    /// Where the profile is silent, down-stream is asked first and providers are, and taking down goes the other way.
    #[test]
    fn preferences_hold_where_the_profile_is_silent(seed: u64, system in silent_profile(), fail in 1..12usize) {
        let mut lab = Lab::after(seed, &[Event::Apply(Box::new(system.clone()))])?;
        let plan = lab.plan();
        prop_assert!(!plan.notes.iter().any(|note| note.contains("give no") || note.contains("gives no")), "{}", plan);
        let run = lab.run(&plan, Some(fail))?;
        let up = asked(&plan, &run.asked);
        lab.converge()?;
        // In new processes, so that services are still wanted.
        let mut changed = system.clone();
        changed.module_digests.values_mut().for_each(|digest| digest.push('x'));
        lab.world.apply(changed);
        let plan = lab.plan();
        let run = lab.run(&plan, None)?;
        let deactivates = |id: &&StepId| matches!(plan.steps[**id as usize - 1].work, Work::Deactivate { .. });
        let down: Vec<StepId> = run.asked.iter().filter(deactivates).copied().collect();
        let down = asked(&plan, &down);
        for connector in &system.spec.connectors {
            let (source, target) = (connector.source.instance.as_str(), connector.target.instance.as_str());
            if connector.kind == PortKind::Service {
                prop_assert_eq!(service_provider(connector), Some(&connector.target));
            }
            if let (Some(source), Some(target)) = (up.get(source), up.get(target)) {
                prop_assert!(target < source, "{} comes up in the wrong order", connector.name);
            }
            if let (Some(source), Some(target)) = (down.get(source), down.get(target)) {
                prop_assert!(source < target, "{} goes down in the wrong order", connector.name);
            }
        }
    }

    /// An order makes nobody depend on the success of an optional component.
    #[test]
    fn nobody_needs_an_optional_component(seed: u64, events in events()) {
        let lab = Lab::after(seed, &events)?;
        let plan = lab.plan();
        let systems = lab.world.systems.iter().filter(|system| !system.deleting);
        let optional: BTreeSet<(&str, String)> = systems
            .flat_map(|system| {
                let own = system.spec.components.iter().filter(|c| !c.required);
                own.map(|c| (system.reference.uid.as_str(), format!("component/{}", c.instance)))
            })
            .collect();
        for step in &plan.steps {
            let uid = step.system.as_ref().map_or("", |system| system.uid.as_str());
            for because in &step.because {
                let other = &plan.steps[because.step as usize - 1];
                let waits = matches!(because.rule, Rule::Sequence { .. } | Rule::Sync { .. });
                if waits && optional.contains(&(uid, other.target.clone())) {
                    prop_assert!(step.after_end_of.contains(&other.id), "{:?}", step);
                    prop_assert!(!step.needs.contains(&other.id), "{:?}", step);
                }
            }
        }
    }
}
