//! Is the system that is applied the one that is stored under its name?

use rts_controller_api::Problem;
use rts_schemas::system::SystemSpec;

use crate::store::SystemRecord;

/// Refuses what would take another system's place unasked, and a system that is being taken down.
pub fn check(stored: &SystemRecord, spec: &SystemSpec, replace: bool) -> Result<(), Problem> {
    let name = stored.name();
    if stored.deleted.is_some() {
        return Err(Problem::conflict(
            "terminating",
            format!("system {name} is being taken down; apply again once it is gone"),
        ));
    }
    if replace {
        return Ok(());
    }
    let Some(why) = difference(stored, spec) else {
        return Ok(());
    };
    Err(Problem::conflict(
        "other-system",
        format!(
            "another system is stored as {name}: {why}; apply under another name (--name), or take its place (--replace)"
        ),
    ))
}

fn difference(stored: &SystemRecord, spec: &SystemSpec) -> Option<String> {
    let (old, new) = (identity(&stored.spec.full_id), identity(&spec.full_id));
    if let (Some(old), Some(new)) = (old, new)
        && old != new
    {
        return Some(format!(
            "its id is {}, not {}",
            stored.spec.full_id, spec.full_id
        ));
    }
    let old = &stored.spec.components;
    let shares = spec
        .components
        .iter()
        .any(|c| old.iter().any(|o| o.instance == c.instance));
    let both = !old.is_empty() && !spec.components.is_empty();
    (both && !shares).then(|| "the two share no component".to_owned())
}

/// Vendor and name of `RTSystem:vendor:name:version`; without them the whole id, less its version.
fn identity(full_id: &str) -> Option<(String, String)> {
    let full_id = full_id.trim();
    if full_id.is_empty() {
        return None;
    }
    let fields: Vec<&str> = full_id.split(':').collect();
    if let [_, vendor, name, _, ..] = fields.as_slice() {
        return Some(((*vendor).to_owned(), (*name).to_owned()));
    }
    let last = fields.last().copied().unwrap_or_default();
    let version = fields.len() > 1 && last.starts_with(|c: char| c.is_ascii_digit());
    let kept = if version {
        &fields[..fields.len() - 1]
    } else {
        &fields[..]
    };
    Some((String::new(), kept.join(":")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_no_part_of_the_identity() {
        assert_eq!(identity("RTSystem:v:n:1.0"), identity("RTSystem:v:n:2.0"));
        assert_ne!(identity("RTSystem:v:n:1.0"), identity("RTSystem:w:n:1.0"));
        assert_eq!(identity("RTSystem:a.b:1.0"), identity("RTSystem:a.b:1.1"));
        assert_eq!(identity(" "), None);
    }
}
