//! Which values a parameter or a port allows.

use super::RTC;
use crate::form::profile_form;

profile_form! {
    /// Which values are allowed: exactly one of three kinds.
    pub struct Constraint {
        /// A constraint of one value: a comparison, or several that are joined.
        unit: one<ConstraintUnit> = RTC "ConstraintUnitType" "constraintUnitType|constraintUnit";
        /// Constraints of the items of a list, the first for the first item, and so on.
        list: one<Constraints> = RTC "ConstraintListType" "constraintListType|constraintList";
        /// Constraints of named items: each has a `key`.
        hash: one<Constraints> = RTC "ConstraintHashType" "constraintHashType|constraintHash";
    }
}

profile_form! {
    /// Several constraints, which the element around them joins.
    pub struct Constraints {
        /// The constraints; `not` has exactly one, `and` and `or` have at least one.
        constraints: many<Constraint> = RTC "Constraint" "constraint|constraints";
    }
}

profile_form! {
    /// A constraint of one value: exactly one of these comparisons, or several of them joined.
    pub struct ConstraintUnit {
        /// Name of the item that it is for. Only in a hash.
        key: attribute = RTC "key" "key";
        /// A constraint that must not hold.
        not: one<Constraints> = RTC "Not" "not";
        /// Constraints of which all must hold: `0 <= x` and `x < 10`.
        and: one<Constraints> = RTC "And" "and";
        /// Constraints of which at least one must hold: `x = 1` or `x = 2`.
        or: one<Constraints> = RTC "Or" "or";
        /// There must be no value at all.
        is_null: one<PropertyIsNull> = RTC "propertyIsNullType" "propertyIsNullType|propertyIsNull";
        /// The value must be equal to the literal.
        is_equal_to: one<Comparison> = RTC "propertyIsEqualTo" "propertyIsEqualTo";
        /// The value must not be equal to the literal.
        is_not_equal_to: one<Comparison> = RTC "propertyIsNotEqualTo" "propertyIsNotEqualTo";
        /// The value must be less than the literal.
        is_less_than: one<Comparison> = RTC "propertyIsLessThan" "propertyIsLessThan";
        /// The value must be greater than the literal.
        is_greater_than: one<Comparison> = RTC "propertyIsGreaterThan" "propertyIsGreaterThan";
        /// The value must be less than the literal or equal to it.
        is_less_than_or_equal_to: one<Comparison> = RTC "propertyIsLessThanOrEqualTo" "propertyIsLessThanOrEqualTo";
        /// The value must be greater than the literal or equal to it.
        is_greater_than_or_equal_to: one<Comparison> = RTC "propertyIsGreaterThanOrEqualTo" "propertyIsGreaterThanOrEqualTo";
        /// The value must fit a pattern with wild cards.
        is_like: one<PropertyIsLike> = RTC "propertyIsLike" "propertyIsLike";
        /// The value must lie between two values, or be equal to one of them.
        is_between: one<PropertyIsBetween> = RTC "propertyIsBetween" "propertyIsBetween";
    }
}

profile_form! {
    /// The comparison that there is no value.
    pub struct PropertyIsNull {
        /// An empty element, which only the schema needs.
        ///
        /// - Required: by the schema
        is_null: text = RTC "propertyIsNull" "propertyIsNull";
    }
}

profile_form! {
    /// A comparison with one value.
    pub struct Comparison {
        /// Whether capital and small letters are different.
        ///
        /// - Values: `true`, `false`
        /// - Required: by the schema
        match_case: boolean = RTC "matchCase" "matchCase";
        /// The value to compare with, as text: `1.5`.
        ///
        /// - Required: by the schema
        literal: text = RTC "Literal" "literal";
    }
}

profile_form! {
    /// A comparison with a pattern.
    pub struct PropertyIsLike {
        /// The letter that stands for any text in the pattern, as `*`.
        ///
        /// - Required: by the schema
        wild_card: attribute = RTC "wildCard" "wildCard";
        /// The letter that stands for any one letter in the pattern, as `?`.
        ///
        /// - Required: by the schema
        single_char: attribute = RTC "singleChar" "singleChar";
        /// The letter that takes the meaning from the next one, as `\`.
        ///
        /// - Required: by the schema
        escape_char: attribute = RTC "escapeChar" "escapeChar";
        /// The pattern that the value must fit.
        ///
        /// - Required: by the schema
        literal: text = RTC "Literal" "literal";
    }
}

profile_form! {
    /// A comparison with two values.
    pub struct PropertyIsBetween {
        /// The least value that is allowed, as text.
        ///
        /// - Required: by the schema
        lower_boundary: text = RTC "LowerBoundary" "lowerBoundary";
        /// The greatest value that is allowed, as text.
        ///
        /// - Required: by the schema
        upper_boundary: text = RTC "UpperBoundary" "upperBoundary";
    }
}
