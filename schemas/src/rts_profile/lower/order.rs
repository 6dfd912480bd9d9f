//! The seven orders.

use crate::composite::Composites;
use crate::rts_profile::ReadProfile;
use crate::rts_profile::model::{self, OrderKind, Preceding};
use crate::system::{CompositeSpec, Condition, Orders, SendingTiming, WaitFor};

pub(super) fn orders(read: &ReadProfile, composites: &[CompositeSpec]) -> Orders {
    let composites = Composites::of(composites);
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
        let conditions = order.conditions.iter();
        list.extend(conditions.flat_map(|condition| self::conditions(condition, &composites)));
    }
    orders
}

/// One condition of the file; two when it has both a time and predecessors, since conditions are ANDed. One of a composite
/// is one of each of its members.
pub(super) fn conditions(
    condition: &model::Condition,
    composites: &Composites<'_>,
) -> Vec<Condition> {
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
        condition
            .preceding
            .as_ref()
            .and_then(|said| preceding(said, composites)),
    ];
    let waits: Vec<Option<WaitFor>> = match waits {
        [None, None] => vec![None],
        waits => waits.into_iter().flatten().map(Some).collect(),
    };
    let targets = composites.leaves(target.trimmed()).into_iter();
    let with = |target: &str, wait: &Option<WaitFor>| Condition {
        target: target.to_owned(),
        sequence,
        wait: wait
            .clone()
            .and_then(|wait| others(wait, target, condition)),
    };
    targets
        .flat_map(|target| waits.iter().map(move |wait| with(target, wait)))
        .collect()
}

/// What a member waits for that waits for its composite: the other members. Itself only where the file says just that.
fn others(wait: WaitFor, target: &str, condition: &model::Condition) -> Option<WaitFor> {
    let WaitFor::Preceding {
        timing,
        timeout_ms,
        mut components,
    } = wait
    else {
        return Some(wait);
    };
    let said = condition.preceding.as_ref();
    let mut named = said.into_iter().flat_map(|said| &said.components);
    let itself = named.any(|other| {
        let name = other.instance_name.as_ref();
        name.is_some_and(|name| name.trimmed() == target)
    });
    components.retain(|component| itself || component != target);
    (!components.is_empty()).then_some(WaitFor::Preceding {
        timing,
        timeout_ms,
        components,
    })
}

fn preceding(preceding: &Preceding, composites: &Composites<'_>) -> Option<WaitFor> {
    let timing = match &preceding.sending_timing {
        Some(text) => parse_timing(&text.value)?,
        None => SendingTiming::Sync,
    };
    let components: Vec<String> = preceding
        .components
        .iter()
        .filter_map(|target| Some(composites.leaves(target.instance_name.as_ref()?.trimmed())))
        .flatten()
        .map(str::to_owned)
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
