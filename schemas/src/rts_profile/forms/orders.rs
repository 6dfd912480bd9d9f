//! In which order components change state.

use super::{Property, RTS, RTS_EXT, XSI};
use crate::form::profile_form;

profile_form! {
    /// An order: which components, one after the other.
    pub struct Order {
        /// The conditions, one for each component.
        targets: many<Condition> = RTS "targets" "targets";
    }
}

profile_form! {
    /// When one component has its turn.
    pub struct Condition {
        /// `rtsExt:condition_ext`, when it has properties.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// A whole number; smaller ones go first, gaps are allowed.
        sequence: number = RTS "sequence" "sequence";
        /// Wait so long before.
        wait_time: one<WaitTime> = RTS "WaitTime" "condition/waitTime";
        /// Wait for others before.
        preceding: one<Preceding> = RTS "Preceding" "condition/preceding";
        /// The component that waits.
        target_component: one<TargetExecutionContext> = RTS "TargetComponent" "targetComponent";
        /// Properties of the condition.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A time to wait.
    pub struct WaitTime {
        /// Milliseconds.
        wait_time: number = RTS "waitTime" "waitTime";
    }
}

profile_form! {
    /// Components to wait for.
    pub struct Preceding {
        /// `SYNC`: until they are in the state; `ASYNC`: until they were told.
        sending_timing: attribute = RTS "sendingTiming" "sendingTiming";
        /// Milliseconds to wait at most; 0 for ever.
        timeout: number = RTS "timeout" "timeout";
        /// The components.
        components: many<TargetExecutionContext> = RTS "PrecedingComponents" "precedingComponents";
    }
}

profile_form! {
    /// An execution context of a component.
    pub struct TargetExecutionContext {
        /// `rtsExt:target_component_ext`, when it has properties.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the execution context.
        id: attribute = RTS "id" "id";
        /// Id of the component.
        component_id: attribute = RTS "componentId" "componentId";
        /// Instance name of the component.
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Properties of the reference.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}
