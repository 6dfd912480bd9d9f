//! Which actions of a component are implemented.

use super::{ActionDoc, RTC, RTC_DOC, XSI};
use crate::form::profile_form;

profile_form! {
    /// Which actions are implemented, and what they do.
    pub struct Actions {
        /// It is made.
        on_initialize: one<Action> = RTC "OnInitialize" "onInitialize";
        /// It is taken away.
        on_finalize: one<Action> = RTC "OnFinalize" "onFinalize";
        /// Its execution context starts.
        on_startup: one<Action> = RTC "OnStartup" "onStartup";
        /// Its execution context stops.
        on_shutdown: one<Action> = RTC "OnShutdown" "onShutdown";
        /// It becomes Active.
        on_activated: one<Action> = RTC "OnActivated" "onActivated";
        /// It becomes Inactive.
        on_deactivated: one<Action> = RTC "OnDeactivated" "onDeactivated";
        /// It goes from Active to Error.
        on_aborting: one<Action> = RTC "OnAborting" "onAborting";
        /// Again and again while it is in Error.
        on_error: one<Action> = RTC "OnError" "onError";
        /// It leaves Error.
        on_reset: one<Action> = RTC "OnReset" "onReset";
        /// Again and again while it is Active.
        on_execute: one<Action> = RTC "OnExecute" "onExecute";
        /// After each `OnExecute`.
        on_state_update: one<Action> = RTC "OnStateUpdate" "onStateUpdate";
        /// The rate of its execution context changes.
        on_rate_changed: one<Action> = RTC "OnRateChanged" "onRateChanged";
        /// A state machine acts (since version 0.2).
        on_action: one<Action> = RTC "OnAction" "onAction";
        /// Its mode changes (since version 0.2).
        on_mode_changed: one<Action> = RTC "OnModeChanged" "onModeChanged";
    }
}

profile_form! {
    /// An action.
    pub struct Action {
        /// `rtcDoc:action_status_doc`, when it has documentation.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// `true` if the component does something in it.
        implemented: boolean = RTC "implemented" "implemented";
        /// Documentation.
        doc: one<ActionDoc> = RTC_DOC "Doc" "rtcDoc::doc";
    }
}
