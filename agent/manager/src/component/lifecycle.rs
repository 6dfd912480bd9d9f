//! The life cycle of a component as one table (OMG RTC 1.0, 5.2.2.3).

use rts_runtime::abi::callback;

/// State of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Made, not initialised.
    Created,
    /// Initialised; does nothing.
    Inactive,
    /// Its `on_execute` runs.
    Active,
    /// Stopped by its own failure.
    Error,
}

impl State {
    /// Name in the protocol.
    pub fn name(self) -> &'static str {
        match self {
            Self::Created => "Created",
            Self::Inactive => "Inactive",
            Self::Active => "Active",
            Self::Error => "Error",
        }
    }
}

/// What is to happen to a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transition {
    /// After its creation.
    Initialize,
    /// Start to execute.
    Activate,
    /// Stop to execute.
    Deactivate,
    /// A callback failed while it was active or was being activated or deactivated, or one that was told of a new rate.
    Abort,
    /// Leave Error.
    Reset,
    /// Before its deletion.
    Finalize,
}

/// What the table says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Call this; go there when it is OK, else there.
    Call {
        /// Number of the callback.
        callback: u32,
        /// State after OK.
        then: State,
        /// State after anything else.
        otherwise: State,
    },
    /// Nothing to do.
    Already,
    /// Not from this state: why, and what to do first.
    Refused(&'static str),
}

/// The table.
pub fn verdict(state: State, transition: Transition) -> Verdict {
    use State::{Active, Created, Error, Inactive};
    use Transition::{Abort, Activate, Deactivate, Finalize, Initialize, Reset};
    let call = |callback, then, otherwise| Verdict::Call {
        callback,
        then,
        otherwise,
    };
    match (transition, state) {
        (Initialize, Created) => call(callback::ON_INITIALIZE, Inactive, Created),
        (Activate, Inactive) => call(callback::ON_ACTIVATED, Active, Error),
        (Deactivate, Active) => call(callback::ON_DEACTIVATED, Inactive, Error),
        (Abort, Inactive | Active) => call(callback::ON_ABORTING, Error, Error),
        (Reset, Error) => call(callback::ON_RESET, Inactive, Error),
        (Finalize, Inactive | Error) => call(callback::ON_FINALIZE, Created, Created),
        (Initialize, Inactive | Active | Error)
        | (Activate, Active)
        | (Deactivate, Inactive | Error)
        | (Abort, Error)
        | (Reset, Inactive)
        | (Finalize, Created) => Verdict::Already,
        (Activate, Error) => Verdict::Refused("it is in Error: reset it first"),
        (Reset, Active) => Verdict::Refused("it is Active: there is nothing to reset"),
        (Finalize, Active) => Verdict::Refused("it is Active: deactivate it first"),
        (Activate | Deactivate | Reset | Abort, Created) => {
            Verdict::Refused("it is not initialised")
        }
    }
}

/// Name of a callback.
pub fn callback_name(number: u32) -> &'static str {
    match number {
        callback::ON_INITIALIZE => "on_initialize",
        callback::ON_FINALIZE => "on_finalize",
        callback::ON_STARTUP => "on_startup",
        callback::ON_SHUTDOWN => "on_shutdown",
        callback::ON_ACTIVATED => "on_activated",
        callback::ON_DEACTIVATED => "on_deactivated",
        callback::ON_ABORTING => "on_aborting",
        callback::ON_ERROR => "on_error",
        callback::ON_RESET => "on_reset",
        callback::ON_EXECUTE => "on_execute",
        callback::ON_STATE_UPDATE => "on_state_update",
        callback::ON_RATE_CHANGED => "on_rate_changed",
        callback::ON_CONFIGURED => "on_configured",
        _ => "an unknown callback",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table() {
        use Transition::*;
        let mut text = String::new();
        for transition in [Initialize, Activate, Deactivate, Abort, Reset, Finalize] {
            for state in [State::Created, State::Inactive, State::Active, State::Error] {
                let outcome = match verdict(state, transition) {
                    Verdict::Call {
                        callback,
                        then,
                        otherwise,
                    } => format!(
                        "{} -> {then:?}, else {otherwise:?}",
                        callback_name(callback)
                    ),
                    Verdict::Already => "nothing to do".to_owned(),
                    Verdict::Refused(why) => format!("refused: {why}"),
                };
                text += &format!("{transition:?} {state:?}: {outcome}\n");
            }
        }
        insta::assert_snapshot!(text, @r"
        Initialize Created: on_initialize -> Inactive, else Created
        Initialize Inactive: nothing to do
        Initialize Active: nothing to do
        Initialize Error: nothing to do
        Activate Created: refused: it is not initialised
        Activate Inactive: on_activated -> Active, else Error
        Activate Active: nothing to do
        Activate Error: refused: it is in Error: reset it first
        Deactivate Created: refused: it is not initialised
        Deactivate Inactive: nothing to do
        Deactivate Active: on_deactivated -> Inactive, else Error
        Deactivate Error: nothing to do
        Abort Created: refused: it is not initialised
        Abort Inactive: on_aborting -> Error, else Error
        Abort Active: on_aborting -> Error, else Error
        Abort Error: nothing to do
        Reset Created: refused: it is not initialised
        Reset Inactive: nothing to do
        Reset Active: refused: it is Active: there is nothing to reset
        Reset Error: on_reset -> Inactive, else Error
        Finalize Created: nothing to do
        Finalize Inactive: on_finalize -> Created, else Created
        Finalize Active: refused: it is Active: deactivate it first
        Finalize Error: on_finalize -> Created, else Created
        ");
    }
}
