//! The placement keys `rtsctl.*`: one meaning, whether they stand in a profile or in an overlay.

use std::ops::RangeInclusive;

use jiff::SignedDuration;

use crate::names;
use crate::suggest;
use crate::system::{ComponentSpec, DriftPolicy, OnDisconnect, OnHang, RestartPolicy};

mod settings;

pub use settings::settings;

/// The prefix of the keys in a profile; an overlay may leave it away.
pub const PREFIX: &str = "rtsctl.";

/// The keys, without their prefix.
pub const KEYS: [&str; 12] = [
    "node",
    "manager",
    "isolated",
    "restart",
    "restartLimit",
    "restartWindow",
    "startTimeout",
    "livenessTimeout",
    "onHang",
    "onDisconnect",
    "resetOnError",
    "drift",
];

/// Restarts that `restartLimit` may allow.
const RESTARTS: RangeInclusive<u32> = 1..=1000;

/// Milliseconds that a time may have.
const TIMES: RangeInclusive<u64> = 100..=24 * 60 * 60 * 1000;

/// Why a key or its value is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlacementError {
    /// Not one of [`KEYS`].
    #[error("`{key}` is not a placement key")]
    UnknownKey {
        /// As written, without prefix.
        key: String,
    },
    /// The value is none of those that the key takes.
    #[error("`{value}` is not a value of `{key}`")]
    BadValue {
        /// The key.
        key: &'static str,
        /// As written.
        value: String,
        /// What it takes.
        expected: String,
    },
}

impl PlacementError {
    /// Stable code of the finding.
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnknownKey { .. } => "unknown-placement-key",
            Self::BadValue { .. } => "bad-placement-value",
        }
    }

    /// How to mend it.
    pub fn help(&self) -> String {
        match self {
            Self::UnknownKey { key } => suggest::advice(key, "keys", &KEYS),
            Self::BadValue { expected, .. } => format!("expected: {expected}"),
        }
    }
}

/// Sets one placement key of a component; `key` is without prefix. A later call wins.
///
/// # Errors
/// Unknown key, or a value that the key does not take; the component is then unchanged.
pub fn set(component: &mut ComponentSpec, key: &str, value: &str) -> Result<(), PlacementError> {
    let value = value.trim();
    match key {
        "node" => component.placement.node = Some(node(value)?),
        "manager" => {
            component.placement.manager = Some(manager(value)?);
            component.placement.isolated = false;
        }
        "isolated" => {
            component.placement.isolated = boolean("isolated", value)?;
            if component.placement.isolated {
                component.placement.manager = None;
            }
        }
        "restart" => component.policy.restart = restart(value)?,
        "restartLimit" => component.policy.restart_limit = Some(limit(value)?),
        "restartWindow" => {
            component.policy.restart_window_ms = Some(time("restartWindow", value)?);
        }
        "startTimeout" => component.policy.start_timeout_ms = Some(time("startTimeout", value)?),
        "livenessTimeout" => {
            component.policy.liveness_timeout_ms = Some(time("livenessTimeout", value)?);
        }
        "onHang" => component.policy.on_hang = on_hang(value)?,
        "onDisconnect" => component.policy.on_disconnect = on_disconnect(value)?,
        "resetOnError" => component.policy.reset_on_error = boolean("resetOnError", value)?,
        "drift" => component.policy.drift = drift(value)?,
        _ => {
            return Err(PlacementError::UnknownKey {
                key: key.to_owned(),
            });
        }
    }
    Ok(())
}

fn bad(key: &'static str, value: &str, expected: impl Into<String>) -> PlacementError {
    PlacementError::BadValue {
        key,
        value: value.to_owned(),
        expected: expected.into(),
    }
}

/// A node is named by a host name or address, so dots and colons are allowed.
fn node(value: &str) -> Result<String, PlacementError> {
    let fits = (1..=253).contains(&value.len())
        && value
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | ':'))
        && value.starts_with(|c: char| c.is_ascii_alphanumeric());
    if fits {
        Ok(value.to_owned())
    } else {
        Err(bad("node", value, "the name of a node, such as `local`"))
    }
}

fn manager(value: &str) -> Result<String, PlacementError> {
    if names::is_manager_name(value) {
        return Ok(value.to_owned());
    }
    let mut expected =
        "up to 63 letters, digits, `-`, `_` and `.`, the first a letter or digit".to_owned();
    if let Some(near) = names::manager_name(value) {
        expected.push_str(&format!("; for example `{near}`"));
    }
    Err(bad("manager", value, expected))
}

fn boolean(key: &'static str, value: &str) -> Result<bool, PlacementError> {
    parse_bool(value).ok_or_else(|| bad(key, value, "`true` or `false`"))
}

/// `true`, `false`, `1` or `0`, as XML Schema has it, in any case.
pub fn parse_bool(value: &str) -> Option<bool> {
    match value.trim().to_ascii_lowercase().as_str() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// A whole number of restarts.
fn limit(value: &str) -> Result<u32, PlacementError> {
    let parsed = value.parse().ok().filter(|limit| RESTARTS.contains(limit));
    parsed.ok_or_else(|| bad("restartLimit", value, "a whole number from 1 to 1000"))
}

/// A time with its unit, in whole milliseconds.
fn time(key: &'static str, value: &str) -> Result<u64, PlacementError> {
    let parsed = value.parse::<SignedDuration>().ok();
    let ms = parsed.and_then(|time| u64::try_from(time.as_millis()).ok());
    ms.filter(|ms| TIMES.contains(ms)).ok_or_else(|| {
        let expected = "a time from 100 ms to 24 h with its unit, such as `500ms`, `10s` or `5m`";
        bad(key, value, expected)
    })
}

fn restart(value: &str) -> Result<RestartPolicy, PlacementError> {
    match value.to_ascii_lowercase().as_str() {
        "always" => Ok(RestartPolicy::Always),
        "on-failure" | "onfailure" => Ok(RestartPolicy::OnFailure),
        "never" => Ok(RestartPolicy::Never),
        _ => Err(bad("restart", value, "`always`, `on-failure` or `never`")),
    }
}

/// `keep`, `deactivate` or `stop`, in any case.
fn on_disconnect(value: &str) -> Result<OnDisconnect, PlacementError> {
    match value.to_ascii_lowercase().as_str() {
        "keep" => Ok(OnDisconnect::Keep),
        "deactivate" => Ok(OnDisconnect::Deactivate),
        "stop" => Ok(OnDisconnect::Stop),
        _ => Err(bad("onDisconnect", value, "`keep`, `deactivate` or `stop`")),
    }
}

/// `report` or `restart`, in any case.
fn on_hang(value: &str) -> Result<OnHang, PlacementError> {
    match value.to_ascii_lowercase().as_str() {
        "report" => Ok(OnHang::Report),
        "restart" => Ok(OnHang::Restart),
        _ => Err(bad("onHang", value, "`report` or `restart`")),
    }
}

/// `repair`, `ignore` or `adopt`, in any case.
fn drift(value: &str) -> Result<DriftPolicy, PlacementError> {
    match value.to_ascii_lowercase().as_str() {
        "repair" => Ok(DriftPolicy::Repair),
        "ignore" => Ok(DriftPolicy::Ignore),
        "adopt" => Ok(DriftPolicy::Adopt),
        _ => Err(bad("drift", value, "`repair`, `ignore` or `adopt`")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_a_unit_and_bounds() {
        let ms = |text| time("startTimeout", text).ok();
        let read = [
            "100ms", "500ms", "10s", "5m", "1h30m", "24h", "1.5s", "1 min",
        ]
        .map(ms);
        let expected = [
            100, 500, 10_000, 300_000, 5_400_000, 86_400_000, 1500, 60_000,
        ];
        assert_eq!(read, expected.map(Some));
        for text in [
            "",
            "10",
            "99ms",
            "0s",
            "-10s",
            "24h1ms",
            "1d",
            "1y",
            "ten",
            "99999999999999h",
        ] {
            assert_eq!(ms(text), None, "{text}");
        }
    }

    #[test]
    fn drift_takes_its_three_words_in_any_case() {
        let words = ["repair", "Ignore", " ADOPT "].map(|word| drift(word.trim()).unwrap());
        let expected = [DriftPolicy::Repair, DriftPolicy::Ignore, DriftPolicy::Adopt];
        assert_eq!(words, expected);
        let refused = drift("keep").unwrap_err();
        assert_eq!(refused.to_string(), "`keep` is not a value of `drift`");
        assert_eq!(refused.help(), "expected: `repair`, `ignore` or `adopt`");
    }

    #[test]
    fn limits_are_whole_numbers_from_1_to_1000() {
        assert_eq!([limit("1"), limit("1000")], [Ok(1), Ok(1000)]);
        for text in ["", "0", "1001", "-1", "1.5", "many", "99999999999"] {
            assert!(limit(text).is_err(), "{text}");
        }
    }
}
