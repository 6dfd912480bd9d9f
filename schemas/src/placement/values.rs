//! Values that the keys take, with their bounds.

use std::ops::RangeInclusive;

use bytesize::ByteSize;
use jiff::SignedDuration;
use semver::VersionReq;
use serde_json::{Value as Json, json};

use crate::diagnostic::Finding;
use crate::names;
use crate::system::{
    DriftPolicy, ExecutionKind, MAX_RATE, MIN_RATE, OnDisconnect, OnHang, RestartPolicy, StandIn,
    StandInFault, rate_problem,
};
use crate::yaml_type::{Scalar, Words};

/// Milliseconds that a time may have.
const TIMES: RangeInclusive<u64> = 100..=24 * 60 * 60 * 1000;

/// Bytes that a limit may have: 1 MiB to 1 PiB.
const MEMORY: RangeInclusive<u64> = 1 << 20..=1 << 50;

/// Longest range of versions, in bytes.
const VERSION: usize = 128;

/// Highest number of a processor.
const LAST_CPU: u32 = 1023;

/// Places among the components of an execution context.
const ORDERS: RangeInclusive<i32> = -1_000_000..=1_000_000;

/// Longest value of a parameter, in bytes: as the controller stores it.
const VALUE: usize = 1024 * 1024;

macro_rules! value {
    ($(#[doc = $doc:literal])* $name:ident($inner:ty)) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, PartialEq, Eq)]
        pub struct $name(pub $inner);

        impl From<$name> for $inner {
            fn from(value: $name) -> Self {
                value.0
            }
        }

        impl From<$inner> for $name {
            fn from(value: $inner) -> Self {
                Self(value)
            }
        }
    };
}

value! {
    /// Name, address or alias of a node.
    NodeName(String)
}
value! {
    /// Name of a manager.
    ManagerName(String)
}
value! {
    /// Number of restarts.
    RestartLimit(u32)
}
value! {
    /// Milliseconds.
    Time(u64)
}
value! {
    /// Name of a package.
    PackageName(String)
}
value! {
    /// Versions of a package, as Cargo spells them: `1.2` is any from 1.2 on and below 2.
    VersionRange(String)
}
value! {
    /// Processors as cpuset(7) lists them, in their order: `0-3,6`.
    Cpus(String)
}
value! {
    /// Name of an execution context.
    ContextName(String)
}
value! {
    /// Place among the components of an execution context.
    ContextOrder(i32)
}
value! {
    /// SCHED_FIFO priority.
    Priority(u8)
}
value! {
    /// Bytes.
    MemoryLimit(u64)
}
value! {
    /// Value of a parameter, or name of a set.
    Value(String)
}

impl Scalar for NodeName {
    const EXPECTED: &'static str = "the name of a node, such as `local`";

    fn parse(text: &str) -> Option<Self> {
        // A node is named by a host name or address, so dots and colons are allowed.
        let fits = (1..=253).contains(&text.len())
            && text
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | ':'))
            && text.starts_with(|c: char| c.is_ascii_alphanumeric());
        fits.then(|| Self(text.to_owned()))
    }

    fn spelled(&self) -> String {
        self.0.clone()
    }

    fn schema() -> Json {
        json!({"type": "string", "pattern": "^[A-Za-z0-9][A-Za-z0-9._:-]*$", "maxLength": 253})
    }
}

impl Scalar for ManagerName {
    const EXPECTED: &'static str =
        "up to 63 letters, digits, `-`, `_` and `.`, the first a letter or digit";

    fn parse(text: &str) -> Option<Self> {
        names::is_manager_name(text).then(|| Self(text.to_owned()))
    }

    fn spelled(&self) -> String {
        self.0.clone()
    }

    fn schema() -> Json {
        json!({"type": "string", "pattern": "^[A-Za-z0-9][A-Za-z0-9._-]{0,62}$"})
    }

    fn fault(key: &str, text: &str) -> Finding {
        let mut help = format!("expected: {}", Self::EXPECTED);
        if let Some(near) = names::manager_name(text) {
            help.push_str(&format!("; for example `{near}`"));
        }
        let message = format!("`{text}` is not a value of `{key}`");
        Finding::error("bad-placement-value", message).help(help)
    }
}

impl Scalar for RestartLimit {
    const EXPECTED: &'static str = "a whole number from 1 to 1000";

    fn parse(text: &str) -> Option<Self> {
        let parsed = text.parse().ok();
        parsed.filter(|limit| (1..=1000).contains(limit)).map(Self)
    }

    fn spelled(&self) -> String {
        self.0.to_string()
    }

    fn schema() -> Json {
        json!({"type": "integer", "minimum": 1, "maximum": 1000})
    }

    fn write(&self) -> Json {
        self.0.into()
    }
}

impl Scalar for Time {
    const EXPECTED: &'static str =
        "a time from 100 ms to 24 h with its unit, such as `500ms`, `10s` or `5m`";

    fn parse(text: &str) -> Option<Self> {
        milliseconds(text).filter(|ms| TIMES.contains(ms)).map(Self)
    }

    fn spelled(&self) -> String {
        spelled_time(self.0)
    }

    fn schema() -> Json {
        time_schema()
    }
}

/// A time with its unit, in whole milliseconds.
pub(crate) fn milliseconds(text: &str) -> Option<u64> {
    let time = text.parse::<SignedDuration>().ok()?;
    u64::try_from(time.as_millis()).ok()
}

/// Milliseconds in the largest unit that leaves a whole number.
pub(crate) fn spelled_time(ms: u64) -> String {
    in_largest(ms, &[("h", 3_600_000), ("m", 60_000), ("s", 1000)], "ms")
}

/// The schema of times, which leaves their bounds to the reader.
pub(crate) fn time_schema() -> Json {
    json!({"type": "string", "pattern": "^[0-9.]+ ?[A-Za-z]+( ?[0-9.]+ ?[A-Za-z]+)*$"})
}

/// A number in the first of the units that leaves a whole number.
fn in_largest(number: u64, units: &[(&str, u64)], smallest: &str) -> String {
    let whole = units
        .iter()
        .find(|(_, unit)| number > 0 && number.is_multiple_of(*unit));
    match whole {
        Some((name, unit)) => format!("{}{name}", number / unit),
        None => format!("{number}{smallest}"),
    }
}

impl Scalar for PackageName {
    const EXPECTED: &'static str =
        "up to 128 letters, digits, `-`, `_`, `.`, `+`, `@` and `/`, the first a letter or digit";

    fn parse(text: &str) -> Option<Self> {
        let fits = (1..=128).contains(&text.len())
            && text.chars().all(|c| {
                c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '+' | '@' | '/')
            })
            && text.starts_with(|c: char| c.is_ascii_alphanumeric());
        fits.then(|| Self(text.to_owned()))
    }

    fn spelled(&self) -> String {
        self.0.clone()
    }

    fn schema() -> Json {
        json!({"type": "string", "pattern": "^[A-Za-z0-9][A-Za-z0-9._+@/-]{0,127}$"})
    }
}

impl Scalar for VersionRange {
    const EXPECTED: &'static str =
        "a version or a range of versions, such as `\"1.2.0\"` or `\">=1.2, <2\"`";

    fn parse(text: &str) -> Option<Self> {
        let fits = text.len() <= VERSION && VersionReq::parse(text).is_ok();
        fits.then(|| Self(text.to_owned()))
    }

    fn spelled(&self) -> String {
        self.0.clone()
    }

    fn schema() -> Json {
        let part = r"[0-9*xX]+(\.[0-9*xX]+){0,2}(-[0-9A-Za-z.-]+)?(\+[0-9A-Za-z.-]+)?";
        let one = format!(" *(>=|<=|[<>=~^])? *{part} *");
        let text =
            json!({"type": "string", "pattern": format!("^{one}(,{one})*$"), "maxLength": VERSION});
        json!({"anyOf": [text, {"type": "number"}]})
    }
}

impl Cpus {
    /// Reads a list; none when it is none.
    pub fn read(text: &str) -> Option<Self> {
        Some(Self::of(
            text.split(',').map(range).collect::<Option<Vec<_>>>()?,
        ))
    }

    /// These processors.
    pub fn of_numbers(numbers: impl IntoIterator<Item = u32>) -> Self {
        Self::of(numbers.into_iter().map(|number| (number, number)).collect())
    }

    /// Their numbers, in their order.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        let ranges = self.0.split(',').filter_map(range);
        ranges.flat_map(|(first, last)| first..=last)
    }

    fn of(mut ranges: Vec<(u32, u32)>) -> Self {
        ranges.sort_unstable();
        let mut joined: Vec<(u32, u32)> = Vec::new();
        for (first, last) in ranges {
            match joined.last_mut() {
                Some((_, end)) if first <= *end + 1 => *end = last.max(*end),
                _ => joined.push((first, last)),
            }
        }
        let spelled = joined.into_iter().map(|(first, last)| match first == last {
            true => first.to_string(),
            false => format!("{first}-{last}"),
        });
        Self(spelled.collect::<Vec<_>>().join(","))
    }
}

impl Scalar for Cpus {
    const EXPECTED: &'static str =
        "numbers of processors from 0 to 1023 and ranges of them, such as `2-3,5`";

    fn parse(text: &str) -> Option<Self> {
        Self::read(text)
    }

    fn spelled(&self) -> String {
        self.0.clone()
    }

    fn schema() -> Json {
        let list = json!({"type": "string", "pattern": "^ *[0-9]+ *(- *[0-9]+ *)?(, *[0-9]+ *(- *[0-9]+ *)?)*$"});
        json!({"anyOf": [list, {"type": "integer", "minimum": 0, "maximum": LAST_CPU}]})
    }
}

/// `5` or `2-3`.
fn range(text: &str) -> Option<(u32, u32)> {
    let number = |text: &str| {
        let text = text.trim();
        let digits = text.bytes().all(|b| b.is_ascii_digit());
        let number = text.parse::<u32>().ok().filter(|_| digits);
        number.filter(|number| *number <= LAST_CPU)
    };
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let (first, last) = (number(first)?, number(last)?);
    (first <= last).then_some((first, last))
}

/// Hertz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rate(pub f64);

impl From<Rate> for f64 {
    fn from(rate: Rate) -> Self {
        rate.0
    }
}

impl Scalar for ContextName {
    const EXPECTED: &'static str = "a name of up to 128 bytes without `/`, such as `control`";

    fn parse(text: &str) -> Option<Self> {
        let fits = names::name_fault(text).is_none();
        fits.then(|| Self(text.to_owned()))
    }

    fn spelled(&self) -> String {
        self.0.clone()
    }

    fn schema() -> Json {
        json!({"type": "string", "minLength": 1, "maxLength": names::NAME_LIMIT, "pattern": "^[^/]+$"})
    }
}

impl Scalar for ContextOrder {
    const EXPECTED: &'static str = "a whole number from -1000000 to 1000000";

    fn parse(text: &str) -> Option<Self> {
        let parsed = text.parse().ok();
        parsed.filter(|order| ORDERS.contains(order)).map(Self)
    }

    fn spelled(&self) -> String {
        self.0.to_string()
    }

    fn schema() -> Json {
        json!({"type": "integer", "minimum": ORDERS.start(), "maximum": ORDERS.end()})
    }

    fn write(&self) -> Json {
        self.0.into()
    }
}

impl Scalar for Rate {
    const EXPECTED: &'static str = "a number of hertz from 0.001 to 1000000";

    fn parse(text: &str) -> Option<Self> {
        let rate = text.parse().ok();
        rate.filter(|rate| rate_problem(*rate).is_none()).map(Self)
    }

    fn spelled(&self) -> String {
        self.0.to_string()
    }

    fn schema() -> Json {
        json!({"type": "number", "minimum": MIN_RATE, "maximum": MAX_RATE})
    }

    fn write(&self) -> Json {
        self.0.into()
    }
}

impl Scalar for Priority {
    const EXPECTED: &'static str = "a whole number from 1 to 99";

    fn parse(text: &str) -> Option<Self> {
        let parsed = text.parse().ok();
        parsed
            .filter(|priority| (1..=99).contains(priority))
            .map(Self)
    }

    fn spelled(&self) -> String {
        self.0.to_string()
    }

    fn schema() -> Json {
        json!({"type": "integer", "minimum": 1, "maximum": 99})
    }

    fn write(&self) -> Json {
        self.0.into()
    }
}

impl Scalar for MemoryLimit {
    const EXPECTED: &'static str =
        "a size from 1 MiB to 1 PiB with its unit, such as `256MiB` or `2GiB`";

    fn parse(text: &str) -> Option<Self> {
        let unit = text.ends_with(|c: char| c.is_ascii_alphabetic());
        let size = text.parse::<ByteSize>().ok().filter(|_| unit)?;
        MEMORY.contains(&size.as_u64()).then(|| Self(size.as_u64()))
    }

    fn spelled(&self) -> String {
        let units = [
            ("TiB", 1 << 40),
            ("GiB", 1 << 30),
            ("MiB", 1 << 20),
            ("KiB", 1 << 10),
        ];
        in_largest(self.0, &units, "B")
    }

    fn schema() -> Json {
        json!({"type": "string", "pattern": "^[0-9.]+ ?([KkMmGgTtPp]i?)?[Bb]?$"})
    }
}

impl Scalar for Value {
    const EXPECTED: &'static str = "a text, a number or a truth value";
    const BLANKS: bool = true;

    fn parse(text: &str) -> Option<Self> {
        (text.len() <= VALUE).then(|| Self(text.to_owned()))
    }

    fn spelled(&self) -> String {
        self.0.clone()
    }

    fn schema() -> Json {
        json!({"type": ["string", "number", "boolean"], "maxLength": VALUE})
    }

    fn fault(key: &str, text: &str) -> Finding {
        let message = format!("the value of `{key}` has {} bytes", text.len());
        Finding::error("bad-placement-value", message).help(format!("at most {VALUE}"))
    }
}

macro_rules! words {
    ($name:ident, $expected:literal, [$($variant:ident),*]) => {
        impl Words for $name {
            const ALL: &'static [Self] = &[$(Self::$variant),*];
            const EXPECTED: &'static str = $expected;

            fn word(self) -> &'static str {
                self.as_str()
            }
        }
    };
}

macro_rules! scalar_of_words {
    ($($name:ident),*) => {$(
        impl Scalar for $name {
            const EXPECTED: &'static str = <Self as Words>::EXPECTED;

            fn parse(text: &str) -> Option<Self> {
                Self::of_word(text)
            }

            fn spelled(&self) -> String {
                self.word().to_owned()
            }

            fn schema() -> Json {
                Self::schema_of_words()
            }
        }
    )*};
}

words!(
    RestartPolicy,
    "`always`, `on-failure` or `never`",
    [Always, OnFailure, Never]
);
impl Words for ExecutionKind {
    const ALL: &'static [Self] = &[Self::Periodic, Self::EventDriven, Self::Other];
    const EXPECTED: &'static str = "`periodic`, `event-driven` or `other`";

    fn word(self) -> &'static str {
        match self {
            Self::EventDriven => "event-driven",
            other => other.as_str(),
        }
    }
}

words!(OnHang, "`report` or `restart`", [Report, Restart]);
words!(
    OnDisconnect,
    "`keep`, `deactivate` or `stop`",
    [Keep, Deactivate, Stop]
);
words!(
    DriftPolicy,
    "`repair`, `ignore` or `adopt`",
    [Repair, Ignore, Adopt]
);
words!(
    StandIn,
    "`never`, `missing` or `always`; `true` is `always`",
    [Never, Missing, Always]
);
words!(
    StandInFault,
    "`initialize`, `activate` or `execute`",
    [Initialize, Activate, Execute]
);
scalar_of_words!(
    ExecutionKind,
    OnHang,
    OnDisconnect,
    DriftPolicy,
    StandInFault
);

impl Scalar for RestartPolicy {
    const EXPECTED: &'static str = <Self as Words>::EXPECTED;

    fn parse(text: &str) -> Option<Self> {
        match text.eq_ignore_ascii_case("onfailure") {
            true => Some(Self::OnFailure),
            false => Self::of_word(text),
        }
    }

    fn spelled(&self) -> String {
        self.word().to_owned()
    }

    fn schema() -> Json {
        Self::schema_of_words()
    }
}

impl Scalar for StandIn {
    const EXPECTED: &'static str = <Self as Words>::EXPECTED;

    fn parse(text: &str) -> Option<Self> {
        match super::parse_bool(text) {
            Some(true) => Some(Self::Always),
            Some(false) => Some(Self::Never),
            None => Self::of_word(text),
        }
    }

    fn spelled(&self) -> String {
        self.word().to_owned()
    }

    fn schema() -> Json {
        json!({"anyOf": [Self::schema_of_words(), {"type": "boolean"}]})
    }
}

#[cfg(test)]
mod tests;
