//! The limits of what a person changes by hand: those of what is stored, since it may become a part of that.

use rts_agent_api::messages::{Act, MAX_TICKS};
use rts_controller_api::{Problem, ProblemError};

use super::check::{MAX_NAME, MAX_VALUE, escaped};
use super::refuse;

/// Refuses names and values that could not be stored.
pub fn act(act: &Act) -> Result<(), Problem> {
    let (what, names, values) = match act {
        Act::Configure {
            set,
            values,
            active,
            ..
        } => ("values", vec![set.as_ref(), active.as_ref()], values),
        Act::Connect {
            name, properties, ..
        } => ("properties", vec![name.as_ref()], properties),
        Act::Disconnect { connector, .. } => {
            return refuse(too_long("/act/connector", connector, MAX_NAME));
        }
        Act::Tick { cycles, .. } if !(1..=MAX_TICKS).contains(cycles) => {
            let detail = format!("{cycles} cycles are not from 1 to {MAX_TICKS}");
            return refuse(vec![ProblemError {
                pointer: "/act/cycles".to_owned(),
                code: "bad-number".to_owned(),
                detail,
                help: None,
            }]);
        }
        Act::Tick { .. } => return Ok(()),
        Act::Activate { .. } | Act::Deactivate { .. } | Act::Reset { .. } => return Ok(()),
    };
    let names = names.into_iter().flatten();
    let mut faults: Vec<_> = names
        .flat_map(|name| too_long("/act", name, MAX_NAME))
        .collect();
    for (key, value) in values {
        let long_key = too_long(&format!("/act/{what}"), key, MAX_NAME);
        if long_key.is_empty() {
            let at = format!("/act/{what}/{}", escaped(key));
            faults.extend(too_long(&at, value, MAX_VALUE));
        }
        faults.extend(long_key);
    }
    faults.truncate(super::check::MAX_FAULTS);
    refuse(faults)
}

fn too_long(pointer: &str, text: &str, limit: usize) -> Vec<ProblemError> {
    if text.len() <= limit {
        return Vec::new();
    }
    vec![ProblemError {
        pointer: pointer.to_owned(),
        code: "too-long".to_owned(),
        detail: format!(
            "{pointer} has a text of {} bytes; {limit} can be stored",
            text.len()
        ),
        help: Some("put large data into a file, and its path into the parameter".to_owned()),
    }]
}
