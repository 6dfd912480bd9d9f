//! Orders: targets exist, numbers are numbers.

use super::Check;
use crate::rts_profile::model::{Condition, Order, Preceding};
use crate::rts_profile::{parse_timing, parse_whole};
use crate::span::Text;

pub(super) fn order<'a>(check: &mut Check<'a>, order: &'a Order) {
    let owner = format!("a condition of {}", order.kind.element());
    for condition in &order.conditions {
        self::condition(check, condition, &owner);
    }
}

fn condition<'a>(check: &mut Check<'a>, condition: &'a Condition, owner: &str) {
    if let Some(sequence) = check.required(&condition.sequence, "sequence", owner, condition.span) {
        whole(check, sequence, &format!("the sequence of {owner}"));
    }
    match &condition.target {
        Some(target) => {
            check.instance(target, owner);
        }
        None => {
            let element = check.read.spelled("TargetComponent");
            check.error(
                "missing-target",
                format!("{owner} has no target component"),
                condition.span,
                format!("add `{element}` with the instance name"),
            );
        }
    }
    if let Some(time) = &condition.wait_time {
        whole(check, time, &format!("the waiting time of {owner}"));
    }
    if let Some(preceding) = &condition.preceding {
        self::preceding(check, preceding, owner);
    }
}

fn preceding<'a>(check: &mut Check<'a>, preceding: &'a Preceding, owner: &str) {
    if let Some(timing) = &preceding.sending_timing
        && parse_timing(&timing.value).is_none()
    {
        let message = format!(
            "the sending timing `{}` of {owner} is not known",
            timing.trimmed()
        );
        check.error(
            "bad-timing",
            message,
            timing.span,
            "write `SYNC`, `ASYNC` or `NO_SYNC`",
        );
    }
    if let Some(timeout) = &preceding.timeout {
        whole(check, timeout, &format!("the time-out of {owner}"));
    }
    for component in &preceding.components {
        check.instance(component, owner);
    }
    if preceding.components.is_empty() {
        let message = format!("{owner} waits for no component");
        check.warning(
            "empty-preceding",
            message,
            preceding.span,
            "name the components, or remove the element",
        );
    }
}

fn whole(check: &mut Check<'_>, text: &Text, what: &str) {
    if parse_whole(&text.value).is_none() {
        let message = format!(
            "{what} is `{}`, which is not a whole number",
            text.trimmed()
        );
        check.error(
            "bad-number",
            message,
            text.span,
            "write a number from 0 to 4294967295; times are milliseconds",
        );
    }
}
