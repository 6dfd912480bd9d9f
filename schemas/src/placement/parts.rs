//! The keys one by one: their fields in the one model, and which of them are only kept.

use super::Settings;
use crate::diagnostic::Finding;
use crate::rts_profile::escaped;
use crate::span::Span;
use crate::yaml_type::{Leaf, leaves_of, rows_of};

/// The keys that a profile may have, without their prefix: `node`, `resources.cpus`. Configuration, and kind and
/// rate of the execution context, have their own places there.
pub fn keys() -> Vec<String> {
    let rows = rows_of::<Settings>().into_iter().map(|row| row.path);
    rows.filter(|path| !has_own_place(path)).collect()
}

/// What a profile says elsewhere than among the properties of a component.
fn has_own_place(path: &str) -> bool {
    let context = ["executionContext.kind", "executionContext.rate"];
    path.starts_with("configuration.") || context.contains(&path)
}

/// JSON pointer from a component to the field that a key sets, without the first slash.
pub fn pointer(path: &[&str]) -> String {
    match path {
        ["node" | "manager" | "isolated", ..] => format!("placement/{}", path[0]),
        ["package", ..] => "package/name".to_owned(),
        ["version", ..] => "package/version".to_owned(),
        ["standIn"] => "standIn/when".to_owned(),
        ["standIn", "data"] => "standIn/data".to_owned(),
        ["standIn", "data", port, ..] => format!("standIn/data/{}", escaped(port)),
        ["standIn", "fail", ..] => "standIn/fail".to_owned(),
        ["standIn", key, ..] => format!("standIn/{key}Ms"),
        ["resources", "memoryLimit", ..] => "resources/memoryLimitBytes".to_owned(),
        ["resources" | "configuration" | "executionContext", ..] => {
            let parts: Vec<String> = path.iter().map(|part| escaped(part)).collect();
            parts.join("/")
        }
        ["restartWindow" | "startTimeout" | "livenessTimeout", ..] => {
            format!("policy/{}Ms", path[0])
        }
        [key, ..] => format!("policy/{key}"),
        [] => String::new(),
    }
}

/// What this version keeps without carrying it out: a warning for each key, and where it stands.
pub fn later(said: &Settings) -> Vec<(Finding, Span)> {
    let leaves = leaves_of(said).into_iter();
    leaves
        .filter(is_later)
        .map(|leaf| {
            let key = leaf.path.join(".");
            let message = format!("`{key}` is kept, but this version does not carry it out yet");
            let help = match leaf.path.first().map(String::as_str) {
                Some("package" | "version") => {
                    "the module is taken from the module folders of its node (`rts-agent --modules`)"
                }
                _ => "the process may have what its agent may have",
            };
            (Finding::warning("not-carried-out", message).help(help), leaf.span)
        })
        .collect()
}

fn is_later(leaf: &Leaf) -> bool {
    match leaf.path.first().map(String::as_str) {
        _ if leaf.value.is_null() => false,
        Some("package" | "version") => true,
        Some("resources") => leaf.path.get(1).is_some_and(|key| key == "memoryLimit"),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placement::{KEYS, set};
    use crate::system::ComponentSpec;

    /// A value of each key that differs from what is there without it.
    fn other(key: &str) -> &'static str {
        match key {
            "isolated" | "resetOnError" | "resources.lockMemory" | "resources.required" => "true",
            "restart" => "never",
            "restartLimit" => "3",
            "onHang" => "restart",
            "onDisconnect" => "stop",
            "drift" => "adopt",
            "standIn" => "missing",
            "standIn.fail" => "execute",
            "standIn.data.NAME" => "[1]",
            "standIn.startupTime" | "standIn.crashAfter" => "3s",
            "resources.cpus" => "1",
            "executionContext.order" => "7",
            "resources.realtimePriority" => "50",
            "resources.memoryLimit" => "1GiB",
            key if key.ends_with("Timeout") || key.ends_with("Window") => "3s",
            _ => "x",
        }
    }

    #[test]
    fn each_key_sets_the_field_that_its_pointer_names() {
        let keys = keys();
        assert_eq!(keys.len(), KEYS.len() + 1 + 6 + 1);
        for key in &keys {
            let mut component = ComponentSpec::default();
            set(&mut component, key, other(key)).unwrap();
            let path: Vec<&str> = key.split('.').collect();
            let pointer = format!("/{}", pointer(&path));
            let field = |component: &ComponentSpec| {
                let json = serde_json::to_value(component).unwrap();
                json.pointer(&pointer).cloned()
            };
            let (before, after) = (field(&ComponentSpec::default()), field(&component));
            assert!(after.is_some() && before != after, "{key}: {after:?}");
        }
    }

    #[test]
    fn names_in_pointers_are_escaped() {
        let path = ["configuration", "sets", "a/b", "~x"];
        assert_eq!(pointer(&path), "configuration/sets/a~1b/~0x");
    }

    /// So an older program can read it, and its digest is what it was.
    #[test]
    fn what_is_not_said_is_not_written() {
        let json = serde_json::to_value(ComponentSpec::default()).unwrap();
        for key in ["package", "standIn", "resources"] {
            assert_eq!(json.get(key), None);
        }
    }
}
