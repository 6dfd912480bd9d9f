//! In which order components change state.

use super::{Property, RTS, RTS_EXT, XSI};
use crate::form::profile_form;

profile_form! {
    /// An order: which components, one after the other.
    pub struct Order {
        /// The conditions: one for each component that has a place in the order. The others go at once.
        targets: many<Condition> = RTS "targets" "targets";
    }
}

profile_form! {
    /// When one component has its turn.
    pub struct Condition {
        /// Type of the element in the schema: `rtsExt:condition_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Place in the order: a whole number. Smaller ones go first, equal ones together; gaps are allowed.
        ///
        /// - Required: by the schema
        sequence: number = RTS "sequence" "sequence";
        /// A time to wait before the component has its turn. Not together with `preceding`.
        wait_time: one<WaitTime> = RTS "WaitTime" "condition/waitTime";
        /// Other components to wait for before the component has its turn. Not together with `waitTime`.
        preceding: one<Preceding> = RTS "Preceding" "condition/preceding";
        /// The component that has its turn, and its execution context.
        ///
        /// - Required: by the schema
        target_component: one<TargetExecutionContext> = RTS "TargetComponent" "targetComponent";
        /// Properties of the condition. They are kept, and have no effect.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}

profile_form! {
    /// A time to wait.
    pub struct WaitTime {
        /// How long to wait: a whole number.
        ///
        /// - Unit: milliseconds
        wait_time: number = RTS "waitTime" "waitTime";
    }
}

profile_form! {
    /// Components to wait for.
    pub struct Preceding {
        /// What to wait for: that the others are in the state (`SYNC`), or only that they were told (`ASYNC`; the
        /// `NO_SYNC` of rtshell means the same).
        ///
        /// - Values: `SYNC`, `ASYNC`
        sending_timing: attribute = RTS "sendingTiming" "sendingTiming";
        /// How long to wait at most. With 0 there is no limit but that of the whole operation.
        ///
        /// - Default: `0`
        /// - Unit: milliseconds
        timeout: number = RTS "timeout" "timeout";
        /// The components to wait for: all of them.
        components: many<TargetExecutionContext> = RTS "PrecedingComponents" "precedingComponents";
    }
}

profile_form! {
    /// An execution context of a component.
    pub struct TargetExecutionContext {
        /// Type of the element in the schema: `rtsExt:target_component_ext`. The schema wants it where the element has
        /// attributes or elements of the extension; readers do not need it.
        xsi_type: attribute = XSI "type" "xsi::type";
        /// Id of the execution context within the component: usually `0`. RT System Editor leaves it away; then the
        /// first context is meant.
        ///
        /// - Required: by the schema
        id: attribute = RTS "id" "id";
        /// Id of the component: `RTC:vendor:category:type:version`.
        ///
        /// - Required: by the schema
        component_id: attribute = RTS "componentId" "componentId";
        /// Instance name of the component.
        ///
        /// - Required: by the schema
        instance_name: attribute = RTS "instanceName" "instanceName";
        /// Properties of the reference. They are kept, and have no effect.
        properties: many<Property> = RTS_EXT "Properties" "rtsExt::properties|rtsExt::property";
    }
}
