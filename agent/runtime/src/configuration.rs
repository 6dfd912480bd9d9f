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
}

macro_rules! numbers {
    ($($number:ty: $expected:literal),* $(,)?) => {$(
        impl ParameterValue for $number {
            fn expected() -> String {
                $expected.into()
            }

            fn parse(text: &str) -> Option<Self> {
                <$number>::from_str(text.trim()).ok()
            }

            // Debug, not Display: it writes 1.0 as `1.0`, which is how OpenRTM's profiles have it.
            fn text(&self) -> String {
                format!("{self:?}")
            }
        }
    )*};
}

numbers! {
    u8: "an integer from 0 to 255",
    i16: "a 16-bit integer",
    i32: "a 32-bit integer",
    i64: "a 64-bit integer",
    u16: "a 16-bit unsigned integer",
    u32: "a 32-bit unsigned integer",
    u64: "a 64-bit unsigned integer",
    f32: "a number",
    f64: "a number",
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
}

/// A value was refused; the parameter keeps what it had.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ParameterError {
    /// No such parameter.
    #[error("no parameter `{name}`; the type has {known}")]
    Unknown {
        /// Name that was asked for.
        name: String,
        /// Names that exist.
        known: String,
    },
    /// The text is no value of the type.
    #[error("parameter `{name}`: cannot read `{text}`, expected {expected}")]
    Text {
        /// Parameter.
        name: String,
        /// Refused text.
        text: String,
        /// What a user may write.
        expected: String,
    },
    /// The value is not allowed.
    #[error("parameter `{name}`: `{text}` is refused: {reason}")]
    Check {
        /// Parameter.
        name: String,
        /// Refused text.
        text: String,
        /// Why.
        reason: String,
    },
}

type Check<T> = Box<dyn Fn(&T) -> Result<(), String> + Send>;

struct Slot<T> {
    value: T,
    changed: bool,
    check: Option<Check<T>>,
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
}

impl<T: ParameterValue> Assign for Config<T> {
    fn assign(&self, text: &str) -> Result<(), ParameterError> {
        let value = T::parse(text).ok_or_else(|| ParameterError::Text {
            name: self.name.into(),
            text: text.into(),
            expected: T::expected(),
        })?;
        let mut slot = self.lock();
        if let Some(check) = &slot.check {
            check(&value).map_err(|reason| ParameterError::Check {
                name: self.name.into(),
                text: text.into(),
                reason,
            })?;
        }
        slot.value = value;
        slot.changed = true;
        Ok(())
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
            "parameter `gain`: cannot read `fast`, expected a number"
        );
        assert_eq!(gain.get(), 1.0);
        let list = Config::new("list", vec![1, 2]);
        assert_eq!(
            list.assign("1,,2").unwrap_err().to_string(),
            "parameter `list`: cannot read `1,,2`, expected a comma-separated list, each item a 32-bit integer"
        );
    }

    #[test]
    fn a_check_refuses_with_its_reason() {
        let positive = |v: &f64| (*v > 0.0).then_some(()).ok_or("must be above 0".to_owned());
        let alpha = Config::new("alpha", 0.1).check(positive);
        assert_eq!(
            alpha.assign("-1").unwrap_err().to_string(),
            "parameter `alpha`: `-1` is refused: must be above 0"
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
