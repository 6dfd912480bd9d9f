//! Lays what is said over a component.

use std::collections::BTreeMap;

use super::{ConfigurationSettings, ExecutionContextSettings, ResourceSettings, Settings};
use crate::system::{
    ComponentSpec, Configuration, ExecutionContextSpec, Placement, Resources, StandInSpec,
};
use crate::yaml_type::Setting;

/// Lays what is said over a component: what is not said stays.
pub fn lay(component: &mut ComponentSpec, said: &Settings) {
    place(&mut component.placement, said);
    let policy = &mut component.policy;
    said.restart.lay(&mut policy.restart);
    said.restart_limit.lay_some(&mut policy.restart_limit);
    said.restart_window.lay_some(&mut policy.restart_window_ms);
    said.start_timeout.lay_some(&mut policy.start_timeout_ms);
    let liveness = &mut policy.liveness_timeout_ms;
    said.liveness_timeout.lay_some(liveness);
    said.on_hang.lay(&mut policy.on_hang);
    said.on_disconnect.lay(&mut policy.on_disconnect);
    said.reset_on_error.lay(&mut policy.reset_on_error);
    said.drift.lay(&mut policy.drift);
    said.package.lay_some(&mut component.package.name);
    said.version.lay_some(&mut component.package.version);
    match &said.stand_in {
        Setting::Silent => {}
        Setting::Removed(_) => component.stand_in = StandInSpec::default(),
        Setting::Said(said, _) => said.lay(&mut component.stand_in),
    }
    context(&mut component.execution_context, &said.execution_context);
    resources(&mut component.resources, &said.resources);
    configuration(&mut component.configuration, &said.configuration);
}

/// The same for several that are said at one place: a process of its own beats a manager, whichever stands first.
pub fn lay_all(component: &mut ComponentSpec, all: &[Settings]) {
    let (isolated, others): (Vec<_>, Vec<_>) =
        all.iter().partition(|said| !said.isolated.is_silent());
    for said in others.into_iter().chain(isolated) {
        lay(component, said);
    }
}

fn place(placement: &mut Placement, said: &Settings) {
    said.node.lay_some(&mut placement.node);
    said.manager.lay_some(&mut placement.manager);
    if said.manager.get().is_some() {
        placement.isolated = false;
    }
    said.isolated.lay(&mut placement.isolated);
    if said.isolated.get() == Some(&true) {
        placement.manager = None;
    }
}

/// What is taken back as a whole is what an overlay or a property said: kind and rate stay as the profile has them.
fn context(onto: &mut ExecutionContextSpec, said: &Setting<Box<ExecutionContextSettings>>) {
    match said {
        Setting::Silent => {}
        Setting::Removed(_) => {
            onto.name = None;
            onto.order = 0;
        }
        Setting::Said(said, _) => {
            said.name.lay_some(&mut onto.name);
            let mut order = Some(onto.order);
            said.order.lay_some(&mut order);
            onto.order = order.unwrap_or_default();
            said.kind.lay(&mut onto.kind);
            said.rate.lay_some(&mut onto.rate);
        }
    }
}

fn resources(onto: &mut Resources, said: &Setting<ResourceSettings>) {
    match said {
        Setting::Silent => {}
        Setting::Removed(_) => *onto = Resources::default(),
        Setting::Said(said, _) => {
            said.cpus.lay_some(&mut onto.cpus);
            said.realtime_priority.lay_some(&mut onto.realtime_priority);
            said.lock_memory.lay_some(&mut onto.lock_memory);
            said.required.lay_some(&mut onto.required);
            said.memory_limit.lay_some(&mut onto.memory_limit_bytes);
        }
    }
}

fn configuration(onto: &mut Configuration, said: &Setting<ConfigurationSettings>) {
    let said = match said {
        Setting::Silent => return,
        Setting::Removed(_) => return *onto = Configuration::default(),
        Setting::Said(said, _) => said,
    };
    said.active.lay_some(&mut onto.active);
    let sets = match &said.sets {
        Setting::Silent => return,
        Setting::Removed(_) => return onto.sets.clear(),
        Setting::Said(sets, _) => sets,
    };
    for (name, said) in sets.iter() {
        match said {
            Setting::Silent => {}
            Setting::Removed(_) => {
                onto.sets.remove(name.trimmed());
            }
            Setting::Said(values, _) => {
                let set: &mut BTreeMap<_, _> =
                    onto.sets.entry(name.trimmed().to_owned()).or_default();
                for (parameter, value) in values.iter() {
                    let parameter = parameter.trimmed();
                    match value {
                        Setting::Silent => {}
                        Setting::Removed(_) => {
                            set.remove(parameter);
                        }
                        Setting::Said(value, _) => {
                            set.insert(parameter.to_owned(), value.0.clone());
                        }
                    }
                }
            }
        }
    }
}
