//! `rts:StartUp` to `rts:Finalizing`.

use std::collections::HashMap;

use super::target;
use crate::system::{ComponentSpec, Condition, Orders, SendingTiming, WaitFor};
use crate::xml::Tag;

type Components<'a> = HashMap<&'a str, &'a ComponentSpec>;

pub(super) fn orders(orders: &Orders, components: &Components<'_>) -> Vec<Tag> {
    let all = [
        ("rts:StartUp", &orders.start_up),
        ("rts:ShutDown", &orders.shut_down),
        ("rts:Activation", &orders.activation),
        ("rts:Deactivation", &orders.deactivation),
        ("rts:Resetting", &orders.resetting),
        ("rts:Initializing", &orders.initializing),
        ("rts:Finalizing", &orders.finalizing),
    ];
    let said = all.into_iter().filter(|(_, list)| !list.is_empty());
    said.map(|(element, list)| {
        let conditions = list.iter().map(|one| condition(one, components));
        Tag::new(element).holding(conditions)
    })
    .collect()
}

fn condition(condition: &Condition, components: &Components<'_>) -> Tag {
    let wait = condition.wait.as_ref().map(|wait| match wait {
        WaitFor::Time { milliseconds } => {
            Tag::new("rts:WaitTime").with("rts:waitTime", milliseconds.to_string())
        }
        WaitFor::Preceding {
            timing,
            timeout_ms,
            components: before,
        } => Tag::new("rts:Preceding")
            .with(
                "rts:sendingTiming",
                match timing {
                    SendingTiming::Sync => "SYNC",
                    SendingTiming::Async => "ASYNC",
                },
            )
            .with("rts:timeout", timeout_ms.to_string())
            .holding(
                before
                    .iter()
                    .map(|name| context("rts:PrecedingComponents", name, components)),
            ),
    });
    Tag::new("rts:targets")
        .with("xsi:type", "rtsExt:condition_ext")
        .with("rts:sequence", condition.sequence.to_string())
        .holding(wait)
        .holding([context(
            "rts:TargetComponent",
            &condition.target,
            components,
        )])
}

/// An execution context: that of a component.
fn context(element: &'static str, instance: &str, components: &Components<'_>) -> Tag {
    let component = components.get(instance).copied();
    let id = component.map_or("0", |found| &found.execution_context.id);
    target(Tag::new(element).with("rts:id", id), component, instance)
}
