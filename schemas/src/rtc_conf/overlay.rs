//! The overlay that says which component is in which manager.

use std::fmt::Write;

/// An overlay with the manager of each component.
pub(super) fn write<'a>(name: &str, managers: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let mut text = String::from("apiVersion: rtsctl.dev/v1\nkind: Deployment\nmetadata:\n");
    // Writing into a string never fails.
    let _ = writeln!(text, "  name: {}\nspec:\n  components:", scalar(name));
    for (instance, manager) in managers {
        let _ = writeln!(
            text,
            "    {}:\n      manager: {}",
            scalar(instance),
            scalar(manager)
        );
    }
    text
}

/// A text that YAML takes for that text.
fn scalar(text: &str) -> String {
    let plain = text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    let special = ["true", "false", "null", "yes", "no", "on", "off", "y", "n"];
    if plain && !special.contains(&text.to_ascii_lowercase().as_str()) {
        return text.to_owned();
    }
    // JSON is YAML.
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::write;
    use crate::diagnostic::Source;
    use crate::yaml;

    proptest! {
        #[test]
        fn what_is_written_is_read(names in proptest::collection::btree_set("[!-~あ]([ -~]{0,9}[!-~])?", 0..5)) {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let text = write("a: b", names.iter().map(|name| (*name, "main")));
            let read = yaml::parse(&Source::new("made.yaml", text)).unwrap();
            let components = read.get("spec").and_then(|spec| spec.get("components")).unwrap();
            let found: Vec<&str> = components.entries().iter().map(|(key, _)| key.value.as_str()).collect();
            prop_assert_eq!(found, names);
            let manager = |(_, node): &(_, yaml::Node)| node.get("manager").and_then(yaml::Node::text);
            prop_assert!(components.entries().iter().all(|entry| manager(entry).unwrap().value == "main"));
        }
    }
}
