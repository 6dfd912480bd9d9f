//! `rtcDoc:Doc`, which differs by what it documents.

use super::RTC_DOC;
use crate::form::profile_form;

profile_form! {
    /// Documentation of a component.
    pub struct BasicDoc {
        /// What it does.
        description: attribute = RTC_DOC "description" "description";
        /// What goes in and out.
        inout: attribute = RTC_DOC "inout" "inout";
        /// How it works.
        algorithm: attribute = RTC_DOC "algorithm" "algorithm";
        /// Who made it.
        creator: attribute = RTC_DOC "creator" "creator";
        /// License.
        license: attribute = RTC_DOC "license" "license";
        /// Where to read more.
        reference: attribute = RTC_DOC "reference" "reference";
    }
}

profile_form! {
    /// Documentation of an action.
    pub struct ActionDoc {
        /// What it does.
        description: attribute = RTC_DOC "description" "description";
        /// What must hold before.
        pre_condition: attribute = RTC_DOC "preCondition" "preCondition";
        /// What holds after.
        post_condition: attribute = RTC_DOC "postCondition" "postCondition";
    }
}

profile_form! {
    /// Documentation of a configuration parameter.
    pub struct ConfigurationDoc {
        /// Name of the value.
        dataname: attribute = RTC_DOC "dataname" "dataname";
        /// The default value.
        default_value: attribute = RTC_DOC "defaultValue" "defaultValue";
        /// What it is for.
        description: attribute = RTC_DOC "description" "description";
        /// Unit.
        unit: attribute = RTC_DOC "unit" "unit";
        /// Range of values.
        range: attribute = RTC_DOC "range" "range";
        /// Which values are allowed.
        constraint: attribute = RTC_DOC "constraint" "constraint";
    }
}

profile_form! {
    /// Documentation of a data port.
    pub struct DataPortDoc {
        /// What it is for.
        description: attribute = RTC_DOC "description" "description";
        /// The data type.
        data_type: attribute = RTC_DOC "type" "type";
        /// How many values a sample has.
        number: attribute = RTC_DOC "number" "number";
        /// What the values mean.
        semantics: attribute = RTC_DOC "semantics" "semantics";
        /// Unit.
        unit: attribute = RTC_DOC "unit" "unit";
        /// How often a sample comes (spelled so in the schema).
        occerrence: attribute = RTC_DOC "occerrence" "occerrence|occurrence";
        /// How it is used.
        operation: attribute = RTC_DOC "operation" "operation";
    }
}

profile_form! {
    /// Documentation of an event.
    pub struct EventDoc {
        /// What it is for.
        description: attribute = RTC_DOC "description" "description";
        /// The data type.
        data_type: attribute = RTC_DOC "type" "type";
        /// How many values it has.
        number: attribute = RTC_DOC "number" "number";
        /// What the values mean.
        semantics: attribute = RTC_DOC "semantics" "semantics";
        /// Unit.
        unit: attribute = RTC_DOC "unit" "unit";
        /// How it is used.
        operation: attribute = RTC_DOC "operation" "operation";
    }
}

profile_form! {
    /// Documentation of a service port.
    pub struct ServicePortDoc {
        /// What it is for.
        description: attribute = RTC_DOC "description" "description";
        /// Its interfaces.
        ifdescription: attribute = RTC_DOC "ifdescription" "ifdescription";
    }
}

profile_form! {
    /// Documentation of a service interface.
    pub struct ServiceInterfaceDoc {
        /// What it is for.
        description: attribute = RTC_DOC "description" "description";
        /// Arguments of its operations.
        argument: attribute = RTC_DOC "docArgument" "docArgument";
        /// Results of its operations.
        result: attribute = RTC_DOC "docReturn" "docReturn";
        /// Exceptions of its operations.
        exception: attribute = RTC_DOC "docException" "docException";
        /// What must hold before.
        pre_condition: attribute = RTC_DOC "docPreCondition" "docPreCondition";
        /// What holds after.
        post_condition: attribute = RTC_DOC "docPostCondition" "docPostCondition";
    }
}
