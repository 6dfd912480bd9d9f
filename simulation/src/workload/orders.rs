//! Random orders: what waits comes later in the list of components, so that none of them make a circle.

use rts_schemas::system::{Condition, Orders, SendingTiming, SystemSpec, WaitFor};

use crate::seed::Stream;

/// Orders among the components of a system.
pub(super) fn random(stream: &Stream, spec: &SystemSpec) -> Orders {
    let names: Vec<&str> = spec
        .components
        .iter()
        .map(|c| c.instance.as_str())
        .collect();
    // On the way down the last of the list goes first.
    let back: Vec<&str> = names.iter().rev().copied().collect();
    Orders {
        start_up: list(stream, &names),
        shut_down: list(stream, &back),
        activation: list(stream, &names),
        deactivation: list(stream, &back),
        ..Orders::default()
    }
}

fn list(stream: &Stream, names: &[&str]) -> Vec<Condition> {
    if !stream.chance(0.35) {
        return Vec::new();
    }
    let sequenced = stream.chance(0.4);
    let mut conditions = Vec::new();
    for (nth, target) in names.iter().enumerate() {
        let before: Vec<String> = names[..nth]
            .iter()
            .filter(|_| stream.chance(0.4))
            .map(|name| (*name).to_owned())
            .collect();
        let timing = if stream.chance(0.75) {
            SendingTiming::Sync
        } else {
            SendingTiming::Async
        };
        let milliseconds = stream.between(1, 300) as u32;
        let timeout_ms = if stream.chance(0.2) { 8000 } else { 0 };
        let wait = if !before.is_empty() {
            Some(WaitFor::Preceding {
                timing,
                timeout_ms,
                components: before,
            })
        } else if stream.chance(0.1) {
            Some(WaitFor::Time { milliseconds })
        } else {
            None
        };
        if sequenced || wait.is_some() {
            conditions.push(Condition {
                target: (*target).to_owned(),
                sequence: if sequenced { nth as u32 / 2 } else { 0 },
                wait,
            });
        }
    }
    conditions
}

/// Takes a component out of all orders.
pub(super) fn forget(orders: &mut Orders, instance: &str) {
    let lists = [
        &mut orders.start_up,
        &mut orders.shut_down,
        &mut orders.activation,
        &mut orders.deactivation,
        &mut orders.resetting,
        &mut orders.initializing,
        &mut orders.finalizing,
    ];
    for list in lists {
        list.retain(|condition| condition.target != instance);
        for condition in list.iter_mut() {
            if let Some(WaitFor::Preceding { components, .. }) = &mut condition.wait {
                components.retain(|name| name != instance);
            }
            if matches!(&condition.wait, Some(WaitFor::Preceding { components, .. }) if components.is_empty())
            {
                condition.wait = None;
            }
        }
    }
}
