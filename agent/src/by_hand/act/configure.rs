//! Configuration by hand.

use std::collections::BTreeMap;
use std::sync::Arc;

use rts_agent_api::messages::Acted;
use rts_http::problem::Problem;
use rts_manager_api::control::RequestBody;
use rts_plan::mark::{self, Change, Mark};
use rts_plan::observed::ComponentObserved;
use rts_plan::target;

use super::super::answers::link;
use super::super::{DEFAULT_SET, LIMIT};
use super::subject::{Wanted, advised};
use crate::agent::Agent;

/// What a person wants to set.
pub(super) struct Wish {
    /// Set of the values; none for the active one.
    pub set: Option<String>,
    /// Parameter → value.
    pub values: BTreeMap<String, String>,
    /// The set to make the active one.
    pub active: Option<String>,
}

impl Agent {
    pub(super) async fn configure_by_hand(
        self: &Arc<Self>,
        instance: &str,
        wish: Wish,
        dry_run: bool,
    ) -> Result<Acted, Problem> {
        let _turn = match dry_run {
            true => None,
            false => Some(self.turns.at(instance).await),
        };
        let subject = self.subject(instance).await?;
        let (node, target) = (&self.config.node, target::component(instance));
        let component = &subject.component;
        let set = check(component, &wish)?;
        if is_so(component, &set, &wish) {
            return Ok(subject.unchanged(node, target));
        }
        if !dry_run {
            let by_hand = subject.mark(|wanted| mark(component, wanted, &set, &wish).encode());
            let values = wish.values;
            let sets = (!values.is_empty()).then_some((set, values));
            let request = RequestBody::Configure {
                instance: instance.to_owned(),
                sets: sets.into_iter().collect(),
                active: wish.active,
                rate: None,
                on_disconnect: None,
                order: None,
                by_hand,
            };
            let done = subject.manager.link.done(request, LIMIT).await;
            done.map_err(link)?;
        }
        Ok(subject.drifted(node, target, dry_run))
    }
}

/// The mark that a component has with this change.
fn mark(component: &ComponentObserved, wanted: &Wanted, set: &str, wish: &Wish) -> Mark {
    let mut mark = Mark::of(component);
    let placed = &wanted.component;
    let policy = placed.spec.policy.drift;
    let now = component.configuration.sets.get(set);
    for (name, value) in &wish.values {
        let Some(desired) = mark::desired(placed, component, set, name) else {
            continue;
        };
        let change = Change {
            desired,
            before: now.and_then(|set| set.get(name)).map(String::as_str),
            value,
            policy,
        };
        mark.change(mark::path(set, name), &change);
    }
    if let Some(active) = &wish.active {
        let desired = placed.spec.configuration.active.as_deref();
        let change = Change {
            desired: desired.unwrap_or(DEFAULT_SET),
            before: Some(active_set(component)),
            value: active,
            policy,
        };
        mark.change(mark::ACTIVE.to_owned(), &change);
    }
    mark
}

fn active_set(component: &ComponentObserved) -> &str {
    let active = component.configuration.active.as_deref();
    active.unwrap_or(DEFAULT_SET)
}

/// Refuses names that the component does not have. Gives the set that the values go to.
fn check(component: &ComponentObserved, wish: &Wish) -> Result<String, Problem> {
    let name = &component.instance;
    let configuration = &component.configuration;
    if wish.values.is_empty() && wish.active.is_none() {
        let detail = format!("nothing was given to be set in {name}");
        return Err(Problem::invalid("nothing-to-set", detail));
    }
    let set = wish.set.as_deref().unwrap_or(active_set(component));
    let sets: Vec<&str> = configuration.sets.keys().map(String::as_str).collect();
    for wanted in wish.active.iter().map(String::as_str).chain([set]) {
        // Every component has it, filled or not.
        if wanted != DEFAULT_SET && !sets.contains(&wanted) {
            return Err(Problem::invalid(
                "unknown-set",
                format!(
                    "{name} has no configuration set {wanted}; {}",
                    advised(wanted, "sets", sets)
                ),
            ));
        }
    }
    let own = configuration.sets.get(DEFAULT_SET).into_iter().flatten();
    let known = component.defaults.iter().chain(own);
    let known: Vec<&str> = known.map(|(parameter, _)| parameter.as_str()).collect();
    check_values(wish)?;
    let mut wanted = wish.values.keys().map(String::as_str);
    match wanted.find(|parameter| !known.contains(parameter)) {
        Some(unknown) => Err(Problem::invalid(
            "unknown-parameter",
            format!(
                "{name} has no parameter {unknown}; {}",
                advised(unknown, "parameters", known)
            ),
        )),
        None => Ok(set.to_owned()),
    }
}

/// Refuses what no profile can hold.
fn check_values(wish: &Wish) -> Result<(), Problem> {
    let refused = |c: &char| c.is_control() && !matches!(c, '\t' | '\n');
    let mut values = wish.values.iter();
    let found = values.find_map(|(name, value)| Some((name, value.chars().find(refused)?)));
    match found {
        Some((name, c)) => Err(Problem::invalid(
            "invalid-value",
            format!(
                "the value of {name} has the control character U+{:04X}: of those, a value may have only tab and newline",
                u32::from(c)
            ),
        )),
        None => Ok(()),
    }
}

/// True when it is all so already.
fn is_so(component: &ComponentObserved, set: &str, wish: &Wish) -> bool {
    let now = component.configuration.sets.get(set);
    let is_set = |(parameter, value)| now.and_then(|set| set.get(parameter)) == Some(value);
    let active = wish.active.as_deref();
    wish.values.iter().all(is_set) && active.is_none_or(|set| set == active_set(component))
}
