//! `rtcDoc:Doc`, which differs by what it documents.

use super::RTC_DOC;
use crate::form::profile_form;

profile_form! {
    /// Documentation of a component.
    pub struct BasicDoc {
        /// What the component does, for the people who use it.
        description: attribute = RTC_DOC "description" "description";
        /// What goes in and what comes out, in words.
        inout: attribute = RTC_DOC "inout" "inout";
        /// How it works: the algorithm in words.
        algorithm: attribute = RTC_DOC "algorithm" "algorithm";
        /// Who made it, with an address to write to.
        creator: attribute = RTC_DOC "creator" "creator";
        /// Under which license and conditions it may be used.
        license: attribute = RTC_DOC "license" "license";
        /// Where to read more: papers, manuals, addresses.
        reference: attribute = RTC_DOC "reference" "reference";
    }
}

profile_form! {
    /// Documentation of a callback.
    pub struct ActionDoc {
        /// What the component does in this callback.
        description: attribute = RTC_DOC "description" "description";
        /// What must hold before the callback is called.
        pre_condition: attribute = RTC_DOC "preCondition" "preCondition";
        /// What holds after the callback was called.
        post_condition: attribute = RTC_DOC "postCondition" "postCondition";
    }
}

profile_form! {
    /// Documentation of a configuration parameter.
    pub struct ConfigurationDoc {
        /// Name of the value, as people call it.
        dataname: attribute = RTC_DOC "dataname" "dataname";
        /// The value that it has first, in words.
        default_value: attribute = RTC_DOC "defaultValue" "defaultValue";
        /// What the parameter is for, and what it changes.
        description: attribute = RTC_DOC "description" "description";
        /// Unit of the value, as people write it.
        unit: attribute = RTC_DOC "unit" "unit";
        /// Range of the values that make sense.
        range: attribute = RTC_DOC "range" "range";
        /// Which values are allowed, in words.
        constraint: attribute = RTC_DOC "constraint" "constraint";
    }
}

profile_form! {
    /// Documentation of a data port.
    pub struct DataPortDoc {
        /// What the port is for, and what it carries.
        description: attribute = RTC_DOC "description" "description";
        /// The data type, in words where its name does not say it.
        data_type: attribute = RTC_DOC "type" "type";
        /// How many values one sample has.
        number: attribute = RTC_DOC "number" "number";
        /// What the values mean, one after the other.
        semantics: attribute = RTC_DOC "semantics" "semantics";
        /// Unit of the values, as people write it.
        unit: attribute = RTC_DOC "unit" "unit";
        /// How often a sample comes, which the schema spells so.
        occerrence: attribute = RTC_DOC "occerrence" "occerrence|occurrence";
        /// How the port is used: what to write when, and what to do with what was read.
        operation: attribute = RTC_DOC "operation" "operation";
    }
}

profile_form! {
    /// Documentation of an event.
    pub struct EventDoc {
        /// What the event is for, and who sends it.
        description: attribute = RTC_DOC "description" "description";
        /// The data type that comes with the event.
        data_type: attribute = RTC_DOC "type" "type";
        /// How many values come with one event.
        number: attribute = RTC_DOC "number" "number";
        /// What the values mean, one after the other.
        semantics: attribute = RTC_DOC "semantics" "semantics";
        /// Unit of the values, as people write it.
        unit: attribute = RTC_DOC "unit" "unit";
        /// How the event is used, and what follows from it.
        operation: attribute = RTC_DOC "operation" "operation";
    }
}

profile_form! {
    /// Documentation of a service port.
    pub struct ServicePortDoc {
        /// What the port is for, and who calls whom.
        description: attribute = RTC_DOC "description" "description";
        /// What its interfaces are, in words.
        ifdescription: attribute = RTC_DOC "ifdescription" "ifdescription";
    }
}

profile_form! {
    /// Documentation of a service interface.
    pub struct ServiceInterfaceDoc {
        /// What the interface is for, in words.
        description: attribute = RTC_DOC "description" "description";
        /// The arguments of its operations, and what they mean.
        argument: attribute = RTC_DOC "docArgument" "docArgument";
        /// The results of its operations, and what they mean.
        result: attribute = RTC_DOC "docReturn" "docReturn";
        /// The exceptions of its operations, and when they are raised.
        exception: attribute = RTC_DOC "docException" "docException";
        /// What must hold before an operation is called.
        pre_condition: attribute = RTC_DOC "docPreCondition" "docPreCondition";
        /// What holds after an operation was called.
        post_condition: attribute = RTC_DOC "docPostCondition" "docPostCondition";
    }
}
