//! What happens when a component, its process or a peer fails, or a person changes it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Failure policies of a component.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Policy {
    /// When its process died (`rtsctl.restart`).
    #[serde(default)]
    pub restart: RestartPolicy,
    /// When a peer is lost (`rtsctl.onDisconnect`).
    #[serde(default)]
    pub on_disconnect: OnDisconnect,
    /// Reset it when it is in Error (`rtsctl.resetOnError`).
    #[serde(default)]
    pub reset_on_error: bool,
    /// Most restarts of it within [`Policy::restart_window_ms`] (`rtsctl.restartLimit`); none for no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restart_limit: Option<u32>,
    /// Milliseconds in which restarts are counted (`rtsctl.restartWindow`); none for [`RESTART_WINDOW_MS`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restart_window_ms: Option<u64>,
    /// Milliseconds that `on_initialize` and `on_activated` may take (`rtsctl.startTimeout`); none for
    /// [`START_TIMEOUT_MS`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_timeout_ms: Option<u64>,
    /// Milliseconds after which a callback that has not returned hangs (`rtsctl.livenessTimeout`); none for
    /// [`LIVENESS_TIMEOUT_MS`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub liveness_timeout_ms: Option<u64>,
    /// When it hangs (`rtsctl.onHang`).
    #[serde(default, skip_serializing_if = "OnHang::is_default")]
    pub on_hang: OnHang,
    /// When a person changed it, or a connector of its out-ports, by hand (`rtsctl.drift`).
    #[serde(default, skip_serializing_if = "DriftPolicy::is_default")]
    pub drift: DriftPolicy,
}

/// What happens when what runs was changed by hand since the system was applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DriftPolicy {
    /// It is put back.
    #[default]
    Repair,
    /// It is told and left.
    Ignore,
    /// It becomes part of the stored system.
    Adopt,
}

impl DriftPolicy {
    /// Left out when written, so that a text from before this field was known keeps its digest.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// As profiles and overlays write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Repair => "repair",
            Self::Ignore => "ignore",
            Self::Adopt => "adopt",
        }
    }
}

/// Default of [`Policy::restart_window_ms`].
pub const RESTART_WINDOW_MS: u64 = 600_000;

/// Default of [`Policy::start_timeout_ms`].
pub const START_TIMEOUT_MS: u64 = 10_000;

/// Default of [`Policy::liveness_timeout_ms`].
pub const LIVENESS_TIMEOUT_MS: u64 = 5_000;

/// What happens when a component hangs in a callback, or its manager does not answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnHang {
    /// It is told, and the system is not healthy.
    #[default]
    Report,
    /// Its manager process is replaced, with all that is in it.
    Restart,
}

impl OnHang {
    /// Left out when written, so that a text from before this field was known keeps its digest.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// As profiles and overlays write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Report => "report",
            Self::Restart => "restart",
        }
    }
}

/// Restart policy, as Kubernetes names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RestartPolicy {
    /// Whatever the exit status.
    #[default]
    Always,
    /// Only after a failure.
    OnFailure,
    /// Never.
    Never,
}

impl RestartPolicy {
    /// As profiles and overlays write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Always => "always",
            Self::OnFailure => "on-failure",
            Self::Never => "never",
        }
    }
}

/// What a component does when a connector's other end is lost. Its manager does it at once, with or without agent and
/// controller; the plan brings the component back in order once all its peers are there again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnDisconnect {
    /// Goes on.
    #[default]
    Keep,
    /// Is deactivated; activated again only when all its connectors are connected.
    Deactivate,
    /// Is deactivated, finalised and deleted; created again only when all its peers can be.
    Stop,
}

impl OnDisconnect {
    /// The word in profiles and messages.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Keep => "keep",
            Self::Deactivate => "deactivate",
            Self::Stop => "stop",
        }
    }
}
