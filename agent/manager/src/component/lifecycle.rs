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
    /// Its execution context starts.
    StartUp,
    /// Start to execute.
    Activate,
    /// First half of a cycle.
    Execute,
    /// Second half of a cycle.
    UpdateState,
    /// A cycle in Error.
    Dwell,
    /// Its rate is another one now.
    ChangeRate,
    /// Parameters were set.
    Configure,
    /// Stop to execute.
    Deactivate,
    /// A callback failed while it was active or was being activated or deactivated, or one that was told of a change.
    Abort,
    /// Leave Error.
    Reset,
    /// Its execution context stops.
    ShutDown,
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

/// The table. From Created, Inactive or Active to Error it goes by `Abort`, whose callback is called as well.
pub fn verdict(state: State, transition: Transition) -> Verdict {
    use State::{Active, Created, Error, Inactive};
    use Transition::{
        Abort, Activate, ChangeRate, Configure, Deactivate, Dwell, Execute, Finalize, Initialize,
        Reset, ShutDown, StartUp, UpdateState,
    };
    let call = |callback, then, otherwise| Verdict::Call {
        callback,
        then,
        otherwise,
    };
    match (transition, state) {
        (Initialize, Created) => call(callback::ON_INITIALIZE, Inactive, Created),
        (StartUp, Inactive) => call(callback::ON_STARTUP, Inactive, Inactive),
        (Activate, Inactive) => call(callback::ON_ACTIVATED, Active, Error),
        (Execute, Active) => call(callback::ON_EXECUTE, Active, Error),
        (UpdateState, Active) => call(callback::ON_STATE_UPDATE, Active, Error),
        (Dwell, Error) => call(callback::ON_ERROR, Error, Error),
        (ChangeRate, Inactive | Active | Error) => call(callback::ON_RATE_CHANGED, state, Error),
        (Configure, Inactive | Active | Error) => call(callback::ON_CONFIGURED, state, Error),
        (Deactivate, Active) => call(callback::ON_DEACTIVATED, Inactive, Error),
        (Abort, Inactive | Active) => call(callback::ON_ABORTING, Error, Error),
        (Reset, Error) => call(callback::ON_RESET, Inactive, Error),
        (ShutDown, Inactive | Error) => call(callback::ON_SHUTDOWN, state, state),
        (Finalize, Inactive | Error) => call(callback::ON_FINALIZE, Created, Created),
        (Initialize, Inactive | Active | Error)
        | (Activate, Active)
        | (Execute | UpdateState, Created | Inactive | Error)
        | (Dwell, Created | Inactive | Active)
        | (ChangeRate | Configure, Created)
        | (Deactivate, Inactive | Error)
        | (Abort, Error)
        | (Reset, Inactive)
        | (ShutDown | Finalize, Created) => Verdict::Already,
        (StartUp, Active | Error) => Verdict::Refused("its execution context runs already"),
        (Activate, Error) => Verdict::Refused("it is in Error: reset it first"),
        (Reset, Active) => Verdict::Refused("it is Active: there is nothing to reset"),
        (ShutDown | Finalize, Active) => Verdict::Refused("it is Active: deactivate it first"),
        (StartUp | Activate | Deactivate | Reset | Abort, Created) => {
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
        for transition in [
            Initialize,
            StartUp,
            Activate,
            Execute,
            UpdateState,
            Dwell,
            ChangeRate,
            Configure,
            Deactivate,
            Abort,
            Reset,
            ShutDown,
            Finalize,
        ] {
            for state in [State::Created, State::Inactive, State::Active, State::Error] {
                let outcome = match verdict(state, transition) {
                    Verdict::Call {
                        callback,
                        then,
                        otherwise,
                    } => {
                        let by = match (state, otherwise) {
                            (State::Error, _) => "",
                            (_, State::Error) if transition != Abort => " by Abort",
                            _ => "",
                        };
                        let name = callback_name(callback);
                        format!("{name} -> {then:?}, else {otherwise:?}{by}")
                    }
                    Verdict::Already => "nothing to do".to_owned(),
                    Verdict::Refused(why) => format!("refused: {why}"),
                };
                text += &format!("{transition:?} {state:?}: {outcome}\n");
            }
        }
        insta::assert_snapshot!(text);
    }

    #[test]
    fn every_callback_is_in_the_table() {
        use Transition::*;
        let all = [
            Initialize,
            StartUp,
            Activate,
            Execute,
            UpdateState,
            Dwell,
            ChangeRate,
            Configure,
            Deactivate,
            Abort,
            Reset,
            ShutDown,
            Finalize,
        ];
        let states = [State::Created, State::Inactive, State::Active, State::Error];
        let called: std::collections::BTreeSet<u32> = all
            .into_iter()
            .flat_map(|transition| states.map(|state| verdict(state, transition)))
            .filter_map(|verdict| match verdict {
                Verdict::Call { callback, .. } => Some(callback),
                _ => None,
            })
            .collect();
        assert!(called.into_iter().eq(0..callback::CALLBACKS));
    }
}
