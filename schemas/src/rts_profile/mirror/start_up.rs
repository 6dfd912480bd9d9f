//! `StartUp` of version 0.1.

use super::target;
use crate::rts_profile::forms::v01;
use crate::rts_profile::model::{Condition, Preceding, Target};
use crate::span::Text;

/// `StartUp` of version 0.1 as a condition of the order `StartUp`: of several waits the first counts.
pub(super) fn start_up(component: &v01::Component) -> Option<Condition> {
    let from = component.start_up.as_ref()?;
    let first = from.conditions.first();
    let wait_time = first.and_then(|c| c.wait_time.as_ref()).map(|text| {
        let mut text = text.clone();
        if let Some(milliseconds) = duration(&text.value) {
            text.value = milliseconds.to_string();
        }
        text
    });
    let preceding = first.and_then(|c| c.preceding.as_ref()).map(|p| Preceding {
        span: p.span,
        // Version 0.1 says neither: a component that goes before is waited for.
        sending_timing: Some(Text::new("SYNC", p.span)),
        timeout: Some(Text::new("0", p.span)),
        components: p.components.iter().map(target).collect(),
    });
    Some(Condition {
        span: from.span,
        sequence: from.sequence.clone(),
        target: Some(Target {
            span: component.span,
            instance_name: component.instance_name.clone(),
            component_id: component.id.clone(),
            ..Target::default()
        }),
        wait_time,
        preceding,
    })
}

/// Milliseconds of a duration of XML Schema, in hours, minutes and seconds: `PT1M30.5S`.
pub(in crate::rts_profile) fn duration(text: &str) -> Option<u64> {
    let mut rest = text
        .trim()
        .strip_prefix("PT")
        .filter(|rest| !rest.is_empty())?;
    let mut total = 0.0;
    while !rest.is_empty() {
        let at = rest.find(['H', 'M', 'S'])?;
        let factor = match &rest[at..=at] {
            "H" => 3_600_000.0,
            "M" => 60_000.0,
            _ => 1000.0,
        };
        total += rest[..at].parse::<f64>().ok().filter(|n| *n >= 0.0)? * factor;
        rest = &rest[at + 1..];
    }
    (total <= 1e12).then_some(total.round() as u64)
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn durations_are_milliseconds() {
        assert_eq!(duration("PT1.5S"), Some(1500));
        assert_eq!(duration("PT1M30S"), Some(90_000));
        assert_eq!(duration("PT2H"), Some(7_200_000));
        for wrong in ["", "PT", "1S", "P1D", "PT1", "PT-1S", "PTxS"] {
            assert_eq!(duration(wrong), None, "{wrong}");
        }
    }
}
