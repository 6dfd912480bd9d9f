//! The placement keys `rtsctl.*`: one meaning, whether they stand in a profile or in an overlay.

use crate::names;
use crate::suggest;
use crate::system::{ComponentSpec, OnDisconnect, RestartPolicy};

/// The prefix of the keys in a profile; an overlay may leave it away.
pub const PREFIX: &str = "rtsctl.";

/// The keys, without their prefix.
pub const KEYS: [&str; 6] = [
    "node",
    "manager",
    "isolated",
    "restart",
    "onDisconnect",
    "resetOnError",
];

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
        "onDisconnect" => component.policy.on_disconnect = on_disconnect(value)?,
        "resetOnError" => component.policy.reset_on_error = boolean("resetOnError", value)?,
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

/// What a valid value means in this version, when that is not what it says: `onDisconnect` other than `keep`, and
/// `restart: on-failure`.
pub(crate) fn not_carried_out(key: &str, value: &str) -> Option<&'static str> {
    match key {
        "onDisconnect" if on_disconnect(value).is_ok_and(|policy| policy != OnDisconnect::Keep) => {
            Some("the component goes on when a peer is lost")
        }
        "restart" if restart(value).is_ok_and(|policy| policy == RestartPolicy::OnFailure) => {
            Some("it is started again however it ended, as with `always`")
        }
        _ => None,
    }
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
