//! Where editors draw components: numbers are numbers. It has no effect on the system.

use super::Check;
use super::sink::said;
use crate::rts_profile::forms::{Location, Shape};
use crate::span::Text;
use crate::suggest;

/// To which side out-ports point, in any case.
const DIRECTIONS: [&str; 4] = ["RIGHT", "LEFT", "UP", "DOWN"];

pub(super) fn locations(check: &mut Check<'_>) {
    match &check.read.shape {
        Shape::V02(profile) => {
            for component in &profile.components {
                location(
                    check,
                    component.location.as_deref(),
                    &component.instance_name,
                );
            }
        }
        Shape::V01(profile) => {
            for component in &profile.components {
                location(
                    check,
                    component.location.as_deref(),
                    &component.instance_name,
                );
            }
        }
    }
}

fn location(check: &mut Check<'_>, location: Option<&Location>, instance: &Option<Text>) {
    let Some(location) = location else { return };
    let owner = instance.as_ref().map_or("", Text::trimmed);
    let numbers = [
        ("x", &location.x),
        ("y", &location.y),
        ("width", &location.width),
        ("height", &location.height),
    ];
    for (key, text) in numbers {
        if let Some(text) = said(text)
            && !text.trimmed().parse::<f64>().is_ok_and(f64::is_finite)
        {
            let message = format!(
                "`{}` is no number: `{key}` of the location of component `{owner}`",
                text.trimmed()
            );
            let help = "write a whole number of pixels; editors may refuse the file";
            check.warning("bad-number", message, text.span, help);
        }
    }
    if let Some(direction) = said(&location.direction)
        && !DIRECTIONS
            .iter()
            .any(|known| known.eq_ignore_ascii_case(direction.trimmed()))
    {
        let message = format!(
            "`{}` is no direction: where the ports of component `{owner}` are drawn",
            direction.trimmed()
        );
        let help = suggest::advice(direction.trimmed(), "known", &DIRECTIONS);
        check.warning("unknown-value", message, direction.span, help);
    }
}
