//! The seven orders.

use crate::rts_profile::ReadProfile;
use crate::rts_profile::model::{self, OrderKind, Preceding};
use crate::system::{Condition, Orders, SendingTiming, WaitFor};

pub(super) fn orders(read: &ReadProfile) -> Orders {
    let mut orders = Orders::default();
    for order in &read.profile.orders {
        let list = match order.kind {
            OrderKind::StartUp => &mut orders.start_up,
            OrderKind::ShutDown => &mut orders.shut_down,
            OrderKind::Activation => &mut orders.activation,
            OrderKind::Deactivation => &mut orders.deactivation,
            OrderKind::Resetting => &mut orders.resetting,
            OrderKind::Initializing => &mut orders.initializing,
            OrderKind::Finalizing => &mut orders.finalizing,
        };
        list.extend(order.conditions.iter().flat_map(conditions));
    }
    orders
}

/// One condition of the file; two when it has both a time and predecessors, since conditions are ANDed.
pub(super) fn conditions(condition: &model::Condition) -> Vec<Condition> {
    let target = condition
        .target
        .as_ref()
        .and_then(|target| target.instance_name.as_ref());
    let sequence = condition
        .sequence
        .as_ref()
        .and_then(|text| parse_whole(&text.value));
    let (Some(target), Some(sequence)) = (target, sequence) else {
        return Vec::new();
    };
    let time = condition
        .wait_time
        .as_ref()
        .and_then(|text| parse_whole(&text.value));
    let waits = [
        time.map(|milliseconds| WaitFor::Time { milliseconds }),
        condition.preceding.as_ref().and_then(preceding),
    ];
    let with = |wait| Condition {
        target: target.trimmed().to_owned(),
        sequence,
        wait,
    };
    let found: Vec<Condition> = waits
        .into_iter()
        .flatten()
        .map(|wait| with(Some(wait)))
        .collect();
    if found.is_empty() {
        vec![with(None)]
    } else {
        found
    }
}

fn preceding(preceding: &Preceding) -> Option<WaitFor> {
    let timing = match &preceding.sending_timing {
        Some(text) => parse_timing(&text.value)?,
        None => SendingTiming::Sync,
    };
    let components: Vec<String> = preceding
        .components
        .iter()
        .filter_map(|target| Some(target.instance_name.as_ref()?.trimmed().to_owned()))
        .collect();
    (!components.is_empty()).then(|| WaitFor::Preceding {
        timing,
        timeout_ms: preceding
            .timeout
            .as_ref()
            .and_then(|text| parse_whole(&text.value))
            .unwrap_or(0),
        components,
    })
}

/// `SYNC`, `ASYNC` or `NO_SYNC`, in any case.
pub(crate) fn parse_timing(text: &str) -> Option<SendingTiming> {
    match text.trim().to_ascii_uppercase().as_str() {
        "SYNC" => Some(SendingTiming::Sync),
        "ASYNC" | "NO_SYNC" | "NOSYNC" => Some(SendingTiming::Async),
        _ => None,
    }
}

/// A whole number; editors also write `3.0`.
pub(crate) fn parse_whole(text: &str) -> Option<u32> {
    let text = text.trim();
    let whole = match text.split_once('.') {
        Some((whole, zeros)) if zeros.bytes().all(|b| b == b'0') => whole,
        _ => text,
    };
    whole.parse().ok()
}
