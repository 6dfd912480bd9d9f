//! Long names and values, as people read them.

use std::borrow::Cow;

/// Fields that are no configuration value: a value of such a name keeps the name of its set.
const FIELDS: [&str; 8] = [
    "active",
    "dataType",
    "executionKind",
    "manager",
    "node",
    "onDisconnect",
    "rate",
    "state",
];

/// `gain` for `configuration.default.gain`, `fast.gain` in another set, `dataflow_type` for
/// `properties.dataport.dataflow_type`. No two fields of one target get one name.
pub fn field(path: &str) -> Cow<'_, str> {
    if path == "configuration.active" {
        return Cow::Borrowed("active set");
    }
    if let Some(rest) = path.strip_prefix("configuration.") {
        let plain = |name: &&str| !name.contains('.') && *name != "type" && !FIELDS.contains(name);
        return Cow::Borrowed(rest.strip_prefix("default.").filter(plain).unwrap_or(rest));
    }
    match path.strip_prefix("properties.") {
        Some(key) => Cow::Borrowed(property(key)),
        None => Cow::Borrowed(path),
    }
}

/// `dataflow_type` for `dataport.dataflow_type`; what is below `dataport.` further down keeps its name.
pub fn property(key: &str) -> &str {
    let short = key.strip_prefix("dataport.");
    short.filter(|short| !short.contains('.')).unwrap_or(key)
}

/// `TimedLong` for `IDL:RTC/TimedLong:1.0` and `RTC::TimedLong`; other text as it is.
pub fn data_type(id: &str) -> &str {
    let name = match id.strip_prefix("IDL:") {
        Some(rest) => rest.rsplit_once(':').map_or(rest, |(name, _)| name),
        None => id,
    };
    let last = name.rsplit(['/', ':']).next();
    last.filter(|last| !last.is_empty()).unwrap_or(id)
}

/// The text with control characters escaped: what a profile says must not steer a terminal.
pub fn tame(text: &str) -> Cow<'_, str> {
    if !text.chars().any(char::is_control) {
        return Cow::Borrowed(text);
    }
    let escape = |c: char| match c.is_control() {
        true => c.escape_default().to_string(),
        false => c.to_string(),
    };
    Cow::Owned(text.chars().map(escape).collect())
}

/// A value beside others: quoted where its end could not be seen.
pub fn value(text: &str) -> Cow<'_, str> {
    let unclear = text.is_empty() || text.contains([' ', ',', '"']) || text == "none";
    match unclear {
        true => Cow::Owned(format!("\"{}\"", text.replace('"', "\\\""))),
        false => Cow::Borrowed(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_shortened_where_that_is_clear() {
        assert_eq!(field("configuration.default.gain"), "gain");
        assert_eq!(field("configuration.fast.gain"), "fast.gain");
        assert_eq!(field("configuration.default.rate"), "default.rate");
        assert_eq!(
            field("configuration.default.fast.gain"),
            "default.fast.gain"
        );
        assert_eq!(field("configuration.active"), "active set");
        assert_eq!(field("rate"), "rate");
        assert_eq!(field("properties.dataport.dataflow_type"), "dataflow_type");
        assert_eq!(
            field("properties.dataport.buffer.length"),
            "dataport.buffer.length"
        );
        assert_eq!(field("properties.x"), "x");
    }

    #[test]
    fn a_data_type_is_its_last_name() {
        for id in [
            "IDL:RTC/TimedLong:1.0",
            "RTC::TimedLong",
            "TimedLong",
            "IDL:TimedLong:1.0",
        ] {
            assert_eq!(data_type(id), "TimedLong", "{id}");
        }
        assert_eq!(data_type("odd/"), "odd/");
        assert_eq!(data_type(""), "");
    }

    #[test]
    fn values_cannot_steer_a_terminal_nor_hide_their_end() {
        assert_eq!(tame("a\u{1b}[2Jb\n"), "a\\u{1b}[2Jb\\n");
        assert_eq!(value("1.0"), "1.0");
        assert_eq!(value(""), "\"\"");
        assert_eq!(value("1, 2"), "\"1, 2\"");
        assert_eq!(value("none"), "\"none\"");
    }
}
