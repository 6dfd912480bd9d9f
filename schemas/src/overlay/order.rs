//! Orders that an overlay adds to those of the profile.

use super::select::{self, Names};
use super::{DeploymentSpec, Order, Rule, Selector};
use crate::diagnostic::Finding;
use crate::span::Span;
use crate::system::{Condition, NO_SEQUENCE, Orders, SendingTiming, SystemSpec, WaitFor};
use crate::yaml_type::{Faults, List, Setting};

/// Most pairs of components that the rules of one list may make: globs on both sides multiply.
const PAIRS: usize = 100_000;

/// Adds the conditions, and says where each stands (`/orders/activation/3`).
pub(super) fn add(
    spec: &mut SystemSpec,
    said: &DeploymentSpec,
    faults: &mut Faults,
    mut placed: impl FnMut(String, Span),
) {
    let Some(order) = said.order.get() else {
        return;
    };
    let known = SystemSpec {
        orders: Orders::default(),
        ..spec.clone()
    };
    let instances: Vec<String> = spec.components.iter().map(|c| c.instance.clone()).collect();
    let rules = Rules {
        names: Names::of_instances(&known),
        instances: &instances,
    };
    for (name, list, onto) in lists(order, &mut spec.orders) {
        let mut pairs = 0;
        for (rule, span) in list.get().into_iter().flat_map(|list| &list.0) {
            let conditions = rules.conditions(rule, *span, faults);
            pairs += conditions.iter().map(size).sum::<usize>();
            if pairs > PAIRS {
                let message = format!("the rules of `{name}` make more than {PAIRS} pairs");
                let help = "name the components that matter, or use narrower globs";
                faults.push(
                    Finding::error("too-many-entries", message).help(help),
                    *span,
                );
                break;
            }
            for condition in conditions {
                placed(format!("/orders/{name}/{}", onto.len()), *span);
                onto.push(condition);
            }
        }
    }
}

type Listed<'a> = (
    &'static str,
    &'a Setting<List<Rule>>,
    &'a mut Vec<Condition>,
);

fn lists<'a>(order: &'a Order, onto: &'a mut Orders) -> [Listed<'a>; 7] {
    [
        ("startUp", &order.start_up, &mut onto.start_up),
        ("shutDown", &order.shut_down, &mut onto.shut_down),
        ("activation", &order.activation, &mut onto.activation),
        ("deactivation", &order.deactivation, &mut onto.deactivation),
        ("resetting", &order.resetting, &mut onto.resetting),
        ("initializing", &order.initializing, &mut onto.initializing),
        ("finalizing", &order.finalizing, &mut onto.finalizing),
    ]
}

fn size(condition: &Condition) -> usize {
    match &condition.wait {
        Some(WaitFor::Preceding { components, .. }) => components.len(),
        _ => 1,
    }
}

struct Rules<'a> {
    names: Names<'a>,
    instances: &'a [String],
}

/// A component, and whether it was meant by its name.
type Meant<'a> = (&'a str, bool);

impl<'a> Rules<'a> {
    fn conditions(&self, rule: &Rule, span: Span, faults: &mut Faults) -> Vec<Condition> {
        let targets = self.find(&rule.component, faults);
        let after = self.find(&rule.after, faults);
        let before = self.find(&rule.before, faults);
        let says = [
            !rule.after.is_silent(),
            !rule.before.is_silent(),
            !rule.wait.is_silent(),
            !rule.sequence.is_silent(),
        ];
        if says == [false; 4] {
            let message = "this rule says nothing of its components".to_owned();
            let help = "add `after`, `before`, `wait` or `sequence`";
            faults.push(Finding::error("empty-rule", message).help(help), span);
        }
        if targets.len().saturating_mul(after.len().max(before.len())) > PAIRS {
            let message = format!("this rule makes more than {PAIRS} pairs of components");
            let help = "name the components that matter, or use narrower globs";
            faults.push(Finding::error("too-many-entries", message).help(help), span);
            return Vec::new();
        }
        let mut conditions = Vec::new();
        for target in &targets {
            conditions.extend(preceding(rule, *target, &after));
            let wait = rule.wait.get().map(|wait| WaitFor::Time {
                milliseconds: wait.0,
            });
            conditions.extend(wait.map(|wait| condition(target.0, NO_SEQUENCE, Some(wait))));
            let sequence = rule.sequence.get();
            conditions.extend(sequence.map(|number| condition(target.0, number.0, None)));
        }
        for later in &before {
            conditions.extend(preceding(rule, *later, &targets));
        }
        conditions
    }

    fn find(&self, list: &Setting<List<Selector>>, faults: &mut Faults) -> Vec<Meant<'a>> {
        let mut found = Vec::new();
        for (selector, span) in list.get().into_iter().flat_map(|list| &list.0) {
            let indices = self.names.find(&selector.0);
            if indices.is_empty() {
                faults.push(self.names.unmatched("component", &selector.0), *span);
            }
            for index in indices {
                if let Some(instance) = self.instances.get(index) {
                    let by_name = *instance == selector.0 || !select::is_glob(&selector.0);
                    found.push((instance.as_str(), by_name));
                }
            }
        }
        found
    }
}

/// The condition that a component waits for others. A glob that fits the component too does not mean it.
fn preceding(rule: &Rule, target: Meant<'_>, others: &[Meant<'_>]) -> Option<Condition> {
    let others = others.iter().filter(|other| {
        let itself = other.0 == target.0;
        !itself || (other.1 && target.1)
    });
    let wait = WaitFor::Preceding {
        timing: rule.timing.get().copied().unwrap_or(SendingTiming::Sync),
        timeout_ms: rule.timeout.get().map_or(0, |timeout| timeout.0),
        components: others.map(|(name, _)| (*name).to_owned()).collect(),
    };
    let condition = condition(target.0, NO_SEQUENCE, Some(wait));
    (size(&condition) > 0).then_some(condition)
}

fn condition(target: &str, sequence: u32, wait: Option<WaitFor>) -> Condition {
    Condition {
        target: target.to_owned(),
        sequence,
        wait,
    }
}
