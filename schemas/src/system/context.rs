//! Execution contexts, of one component or shared.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Lowest rate of an execution context, in Hz.
pub const MIN_RATE: f64 = 0.001;

/// Highest rate of an execution context, in Hz; real profiles ask for it to mean "as fast as it can".
pub const MAX_RATE: f64 = 1_000_000.0;

/// Why a number cannot be a rate in Hz; `None` when it can.
pub fn rate_problem(rate: f64) -> Option<String> {
    // A comparison with NaN is false.
    let fits = (MIN_RATE..=MAX_RATE).contains(&rate);
    (!fits).then(|| format!("a rate is a number of hertz from {MIN_RATE} to {MAX_RATE}"))
}

/// An execution context (OMG RTC 1.0, 5.2.2.5).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ExecutionContextSpec {
    /// Id as the profile writes it (`0`).
    #[serde(default = "zero")]
    pub id: String,
    /// What drives it.
    #[serde(default)]
    pub kind: ExecutionKind,
    /// Rate in Hz, from [`MIN_RATE`] to [`MAX_RATE`]; `None` leaves the module's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Name of the one that it shares with other components of its manager (`rtsctl.executionContext.name`); none for one of
    /// its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Place among the components of a shared one: lower numbers run first, those with the same by name
    /// (`rtsctl.executionContext.order`).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub order: i32,
    /// The composite whose members share their state with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_state: Option<String>,
}

impl Default for ExecutionContextSpec {
    fn default() -> Self {
        Self {
            id: zero(),
            kind: ExecutionKind::default(),
            rate: None,
            name: None,
            order: 0,
            shared_state: None,
        }
    }
}

impl ExecutionContextSpec {
    /// The one that it shares with others, as a plan tells it; none for one of its own.
    pub fn shared(&self) -> Option<SharedExecutionContext> {
        let name = self.name.clone()?;
        Some(SharedExecutionContext {
            name,
            order: self.order,
            shared_state: self.shared_state.clone(),
        })
    }
}

/// An execution context that components of one manager share, at one of them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SharedExecutionContext {
    /// Its name.
    pub name: String,
    /// Place among its components: lower numbers run first, those with the same by name.
    #[serde(default)]
    pub order: i32,
    /// The composite whose members share their state with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_state: Option<String>,
}

/// `ExecutionKind` of OMG RTC 1.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub enum ExecutionKind {
    /// `on_execute` at a fixed rate.
    #[default]
    Periodic,
    /// `on_execute` when an event arrives.
    EventDriven,
    /// Anything else, such as a simulator that ticks it.
    Other,
}

impl ExecutionKind {
    /// As the control protocol writes it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Periodic => "periodic",
            Self::EventDriven => "eventDriven",
            Self::Other => "other",
        }
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
fn is_zero(number: &i32) -> bool {
    *number == 0
}

fn zero() -> String {
    "0".to_owned()
}
