//! Which actions of a component are implemented.

use super::{ActionDoc, RTC, RTC_DOC, XSI};
use crate::form::profile_form;

profile_form! {
    /// Which callbacks of the component are implemented, and what they do.
    pub struct Actions {
        /// The component was made. Here it declares its ports and parameters.
        on_initialize: one<Action> = RTC "OnInitialize" "onInitialize";
        /// The component is about to be taken away, and lets go of what it holds.
        on_finalize: one<Action> = RTC "OnFinalize" "onFinalize";
        /// Its execution context starts to run, before any component in it is active.
        on_startup: one<Action> = RTC "OnStartup" "onStartup";
        /// Its execution context stops running.
        on_shutdown: one<Action> = RTC "OnShutdown" "onShutdown";
        /// The component goes from Inactive to Active: it opens devices and resets its values.
        on_activated: one<Action> = RTC "OnActivated" "onActivated";
        /// The component goes from Active to Inactive: it closes what `onActivated` opened.
        on_deactivated: one<Action> = RTC "OnDeactivated" "onDeactivated";
        /// The component goes from Active to Error, since one of its callbacks failed.
        on_aborting: one<Action> = RTC "OnAborting" "onAborting";
        /// Called in each cycle while the component is in the state Error.
        on_error: one<Action> = RTC "OnError" "onError";
        /// The component is to leave the state Error; when this succeeds it is Inactive.
        on_reset: one<Action> = RTC "OnReset" "onReset";
        /// Called in each cycle while the component is Active: its main work.
        on_execute: one<Action> = RTC "OnExecute" "onExecute";
        /// Called after `onExecute` in each cycle, with the results of the cycle at hand.
        on_state_update: one<Action> = RTC "OnStateUpdate" "onStateUpdate";
        /// The rate of its execution context was changed while it ran.
        on_rate_changed: one<Action> = RTC "OnRateChanged" "onRateChanged";
        /// A state machine acts on an event.
        ///
        /// - Versions: since 0.2
        on_action: one<Action> = RTC "OnAction" "onAction";
        /// The mode of a component with several modes was changed.
        ///
        /// - Versions: since 0.2
        on_mode_changed: one<Action> = RTC "OnModeChanged" "onModeChanged";
    }
}

profile_form! {
    /// A callback of the component.
    pub struct Action {
        /// Type of the element in the schema: `rtcDoc:action_status_doc`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Whether the component does something in this callback. RTC Builder writes code only for those.
        ///
        /// - Values: `true`, `false`
        /// - Required: by the schema
        implemented: boolean = RTC "implemented" "implemented";
        /// Documentation for people: what it does, and what holds before and after.
        doc: one<ActionDoc> = RTC_DOC "Doc" "rtcDoc::doc";
    }
}
