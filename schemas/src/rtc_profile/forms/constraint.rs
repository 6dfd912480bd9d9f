//! Which values a parameter or a port allows.

use super::RTC;
use crate::form::profile_form;

profile_form! {
    /// Which values are allowed: one of three kinds.
    pub struct Constraint {
        /// For one value.
        unit: one<ConstraintUnit> = RTC "ConstraintUnitType" "constraintUnitType|constraintUnit";
        /// For the items of a list, one after the other.
        list: one<Constraints> = RTC "ConstraintListType" "constraintListType|constraintList";
        /// For named items.
        hash: one<Constraints> = RTC "ConstraintHashType" "constraintHashType|constraintHash";
    }
}

profile_form! {
    /// Several constraints.
    pub struct Constraints {
        /// The constraints.
        constraints: many<Constraint> = RTC "Constraint" "constraint|constraints";
    }
}

profile_form! {
    /// A constraint of one value: a comparison, or several that are joined.
    pub struct ConstraintUnit {
        /// Name of the item, in a hash.
        key: attribute = RTC "key" "key";
        /// What must not hold.
        not: one<Constraints> = RTC "Not" "not";
        /// All of them hold.
        and: one<Constraints> = RTC "And" "and";
        /// At least one of them holds.
        or: one<Constraints> = RTC "Or" "or";
        /// There is no value.
        is_null: one<PropertyIsNull> = RTC "propertyIsNullType" "propertyIsNullType|propertyIsNull";
        /// Equal.
        is_equal_to: one<Comparison> = RTC "propertyIsEqualTo" "propertyIsEqualTo";
        /// Not equal.
        is_not_equal_to: one<Comparison> = RTC "propertyIsNotEqualTo" "propertyIsNotEqualTo";
        /// Less.
        is_less_than: one<Comparison> = RTC "propertyIsLessThan" "propertyIsLessThan";
        /// Greater.
        is_greater_than: one<Comparison> = RTC "propertyIsGreaterThan" "propertyIsGreaterThan";
        /// Less or equal.
        is_less_than_or_equal_to: one<Comparison> = RTC "propertyIsLessThanOrEqualTo" "propertyIsLessThanOrEqualTo";
        /// Greater or equal.
        is_greater_than_or_equal_to: one<Comparison> = RTC "propertyIsGreaterThanOrEqualTo" "propertyIsGreaterThanOrEqualTo";
        /// Like a pattern.
        is_like: one<PropertyIsLike> = RTC "propertyIsLike" "propertyIsLike";
        /// Between two values, or equal to one of them.
        is_between: one<PropertyIsBetween> = RTC "propertyIsBetween" "propertyIsBetween";
    }
}

profile_form! {
    /// There is no value.
    pub struct PropertyIsNull {
        /// Empty.
        is_null: text = RTC "propertyIsNull" "propertyIsNull";
    }
}

profile_form! {
    /// A comparison with one value.
    pub struct Comparison {
        /// `false` if capital and small letters are the same.
        match_case: boolean = RTC "matchCase" "matchCase";
        /// The value.
        literal: text = RTC "Literal" "literal";
    }
}

profile_form! {
    /// A comparison with a pattern.
    pub struct PropertyIsLike {
        /// Stands for any text.
        wild_card: attribute = RTC "wildCard" "wildCard";
        /// Stands for any letter.
        single_char: attribute = RTC "singleChar" "singleChar";
        /// Takes the meaning from the next letter.
        escape_char: attribute = RTC "escapeChar" "escapeChar";
        /// The pattern.
        literal: text = RTC "Literal" "literal";
    }
}

profile_form! {
    /// A comparison with two values.
    pub struct PropertyIsBetween {
        /// The least value.
        lower_boundary: text = RTC "LowerBoundary" "lowerBoundary";
        /// The greatest value.
        upper_boundary: text = RTC "UpperBoundary" "upperBoundary";
    }
}
