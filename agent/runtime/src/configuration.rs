//! Typed configuration parameters: text in profiles, values in the component.

use std::fmt::{self, Debug};
use std::str::FromStr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A type that a parameter can have. Implemented for numbers, `bool`, `String` and lists of them (`1.0,2.0`).
pub trait ParameterValue: Clone + Send + 'static {
    /// What a user may write, after "expected" (`a number`).
    fn expected() -> String;

    /// Reads a value; `None` when the text is none.
    fn parse(text: &str) -> Option<Self>;

    /// Writes a value, such that `parse` reads it.
    fn text(&self) -> String;

    /// Name of the type in an RTC Profile, so that a wrong value is refused before anything starts; empty when it has
    /// none, and `parse` alone decides.
    fn type_name() -> String {
        String::new()
    }
}

/// Decimal, or hexadecimal after `0x`, with a sign or without. `rtsctl check` reads the same.
fn integer(text: &str) -> Option<i128> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, text.strip_prefix('+').unwrap_or(text)),
    };
    let hex = digits.strip_prefix("0x").or(digits.strip_prefix("0X"));
    let (digits, radix) = hex.map_or((digits, 10), |hex| (hex, 16));
    // A second sign is none.
    let begins = digits.starts_with(|c: char| c.is_digit(radix));
    let number = begins.then(|| i128::from_str_radix(digits, radix).ok())??;
    Some(sign * number)
}

fn whole<N: TryFrom<i128>>(text: &str) -> Option<N> {
    N::try_from(integer(text.trim())?).ok()
}

fn real<N: FromStr>(text: &str) -> Option<N> {
    N::from_str(text.trim()).ok()
}

macro_rules! numbers {
    ($($number:ty: $name:literal, $expected:literal, $read:path;)*) => {$(
        impl ParameterValue for $number {
            fn expected() -> String {
                $expected.into()
            }

            fn parse(text: &str) -> Option<Self> {
                $read(text)
            }

            // Debug, not Display: it writes 1.0 as `1.0`, which is how OpenRTM's profiles have it.
            fn text(&self) -> String {
                format!("{self:?}")
            }

            fn type_name() -> String {
                $name.into()
            }
        }
    )*};
}

numbers! {
    u8: "uint8_t", "an integer from 0 to 255", whole;
    i16: "short", "a 16-bit integer", whole;
    i32: "int", "a 32-bit integer", whole;
    i64: "long", "a 64-bit integer", whole;
    u16: "unsigned short", "a 16-bit unsigned integer", whole;
    u32: "unsigned int", "a 32-bit unsigned integer", whole;
    u64: "unsigned long", "a 64-bit unsigned integer", whole;
    f32: "float", "a number", real;
    f64: "double", "a number", real;
}

impl ParameterValue for bool {
    fn expected() -> String {
        "true or false".into()
    }

    fn parse(text: &str) -> Option<Self> {
        match text.trim().to_ascii_lowercase().as_str() {
            "true" | "1" | "yes" | "on" => Some(true),
            "false" | "0" | "no" | "off" => Some(false),
            _ => None,
        }
    }

    fn text(&self) -> String {
        self.to_string()
    }

    fn type_name() -> String {
        "bool".into()
    }
}

impl ParameterValue for String {
    fn expected() -> String {
        "a text".into()
    }

    fn parse(text: &str) -> Option<Self> {
        Some(text.to_owned())
    }

    fn text(&self) -> String {
        self.clone()
    }

    fn type_name() -> String {
        "string".into()
    }
}

/// Comma-separated; an empty text is an empty list.
impl<T: ParameterValue> ParameterValue for Vec<T> {
    fn expected() -> String {
        format!("a comma-separated list, each item {}", T::expected())
    }

    fn parse(text: &str) -> Option<Self> {
        if text.trim().is_empty() {
            return Some(Self::new());
        }
        text.split(',').map(|item| T::parse(item.trim())).collect()
    }

    fn text(&self) -> String {
        let items: Vec<_> = self.iter().map(T::text).collect();
        items.join(",")
    }

    fn type_name() -> String {
        match T::type_name() {
            item if item.is_empty() => item,
            item => format!("std::vector<{item}>"),
        }
    }
}

/// Why a value was refused; the parameter keeps what it had. Who sets it knows its name and the value.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ParameterError {
    /// No such parameter.
    #[error("there is no such parameter; the type has {known}")]
    Unknown {
        /// Names that exist.
        known: String,
    },
    /// The text is no value of the type.
    #[error("expected {expected}")]
    Text {
        /// What a user may write.
        expected: String,
    },
    /// The value is not allowed.
    #[error("{reason}")]
    Check {
        /// Why.
        reason: String,
    },
}

type Check<T> = Box<dyn Fn(&T) -> Result<(), String> + Send>;

struct Slot<T> {
    value: T,
    changed: bool,
    check: Option<Check<T>>,
    facts: Facts,
}

/// What a module tells of a parameter beside its name and default.
#[derive(Debug, Clone, Default)]
pub(crate) struct Facts {
    pub(crate) value_type: String,
    pub(crate) unit: &'static str,
    pub(crate) constraint: &'static str,
    pub(crate) description: &'static str,
}

/// A parameter of the component. Made by [`Declaration::parameter`](crate::Declaration::parameter).
///
/// The manager sets it between callbacks, so within a callback it never changes.
pub struct Config<T> {
    name: &'static str,
    slot: Arc<Mutex<Slot<T>>>,
}

impl<T: ParameterValue> Config<T> {
    pub(crate) fn new(name: &'static str, default: T) -> Self {
        let slot = Slot {
            value: default,
            changed: false,
            check: None,
            facts: Facts {
                value_type: T::type_name(),
                ..Facts::default()
            },
        };
        Self {
            name,
            slot: Arc::new(Mutex::new(slot)),
        }
    }

    /// Another handle of the same parameter, for who sets it.
    pub(crate) fn handle(&self) -> Self {
        Self {
            name: self.name,
            slot: Arc::clone(&self.slot),
        }
    }

    /// Refuses values for which `check` is an error (`must be above 0`). The default is not checked.
    #[must_use]
    pub fn check(self, check: impl Fn(&T) -> Result<(), String> + Send + 'static) -> Self {
        self.lock().check = Some(Box::new(check));
        self
    }

    /// Says which values are allowed, as an RTC Profile does: `0<=x<=10`, `x>0`, `(slow,fast)`. Managers refuse others
    /// before anything starts, and the module when its default is none of them.
    #[must_use]
    pub fn constraint(self, constraint: &'static str) -> Self {
        self.lock().facts.constraint = constraint;
        self
    }

    /// Says the unit (`m/s`), for people.
    #[must_use]
    pub fn unit(self, unit: &'static str) -> Self {
        self.lock().facts.unit = unit;
        self
    }

    /// Says in a line what it is for.
    #[must_use]
    pub fn description(self, line: &'static str) -> Self {
        self.lock().facts.description = line;
        self
    }

    /// The value now.
    pub fn get(&self) -> T {
        self.lock().value.clone()
    }

    /// The value now, borrowed: for a text or a list that need not be copied each cycle.
    pub fn with<R>(&self, see: impl FnOnce(&T) -> R) -> R {
        see(&self.lock().value)
    }

    /// Whether it was set since the last call.
    pub fn changed(&mut self) -> bool {
        std::mem::take(&mut self.lock().changed)
    }

    /// A panic in `with` or in a check leaves the value whole, so a poisoned lock is no reason to fail.
    fn lock(&self) -> MutexGuard<'_, Slot<T>> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T: ParameterValue + Debug> Debug for Config<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={:?}", self.name, self.lock().value)
    }
}

/// A parameter of any type that can be set from text.
pub(crate) trait Assign: Send {
    fn assign(&self, text: &str) -> Result<(), ParameterError>;

    fn facts(&self) -> Facts;
}

impl<T: ParameterValue> Assign for Config<T> {
    fn assign(&self, text: &str) -> Result<(), ParameterError> {
        let value = T::parse(text).ok_or_else(|| ParameterError::Text {
            expected: T::expected(),
        })?;
        let mut slot = self.lock();
        if let Some(check) = &slot.check {
            check(&value).map_err(|reason| ParameterError::Check { reason })?;
        }
        slot.value = value;
        slot.changed = true;
        Ok(())
    }

    fn facts(&self) -> Facts {
        self.lock().facts.clone()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_good_text_is_taken_and_seen_once_as_a_change() {
        let mut gain = Config::new("gain", 1.0);
        assert!(!gain.changed());
        gain.handle().assign(" 2.5 ").unwrap();
        assert_eq!(gain.get(), 2.5);
        assert!(gain.changed());
        assert!(!gain.changed());
    }

    #[test]
    fn a_bad_text_keeps_the_value_and_says_what_was_expected() {
        let gain = Config::new("gain", 1.0);
        assert_eq!(
            gain.assign("fast").unwrap_err().to_string(),
            "expected a number"
        );
        assert_eq!(gain.get(), 1.0);
        let list = Config::new("list", vec![1, 2]);
        assert_eq!(
            list.assign("1,,2").unwrap_err().to_string(),
            "expected a comma-separated list, each item a 32-bit integer"
        );
    }

    #[test]
    fn a_check_refuses_with_its_reason() {
        let positive = |v: &f64| (*v > 0.0).then_some(()).ok_or("must be above 0".to_owned());
        let alpha = Config::new("alpha", 0.1).check(positive);
        assert_eq!(
            alpha.assign("-1").unwrap_err().to_string(),
            "must be above 0"
        );
        assert_eq!(alpha.get(), 0.1);
    }

    #[test]
    fn texts_are_written_as_openrtm_has_them() {
        assert_eq!(1.0_f64.text(), "1.0");
        assert_eq!(vec![0.0, 1.0].text(), "0.0,1.0");
        assert_eq!(String::from("hoge").text(), "hoge");
        assert_eq!(<Vec<f64>>::parse(" "), Some(vec![]));
        assert_eq!(bool::parse("YES"), Some(true));
    }

    #[test]
    fn integers_are_decimal_or_hexadecimal() {
        assert_eq!(i32::parse(" 0x7f "), Some(127));
        assert_eq!(i16::parse("-0X10"), Some(-16));
        assert_eq!(u64::parse("0xffffffffffffffff"), Some(u64::MAX));
        assert_eq!(<Vec<u8>>::parse("0x1, 2,+3"), Some(vec![1, 2, 3]));
        for text in [
            "0x", "x7", "0x-1", "--1", "+-1", "0x100", "-1", "7f", "1.0", "",
        ] {
            assert_eq!(u8::parse(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(i in any::<i32>(), f in any::<f64>(), v in any::<Vec<f32>>(), b in any::<bool>()) {
            prop_assert_eq!(i32::parse(&i.text()), Some(i));
            prop_assert_eq!(f64::parse(&f.text()).map(f64::to_bits), Some(f.to_bits()));
            prop_assert_eq!(<Vec<f32>>::parse(&v.text()).map(|v| v.len()), Some(v.len()));
            prop_assert_eq!(bool::parse(&b.text()), Some(b));
        }
    }
}
