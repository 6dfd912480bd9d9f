//! One change in words: on one line, and as a block with a line for each field.

use super::names::{data_type, field, tame, value};
use crate::in_place::GONE;
use crate::plan::{Action, Change, FieldChange};

/// Reasons that say no more than the sign does.
const PLAIN: [&str; 3] = ["is not there yet", "is not running", "is not connected"];

/// A change in words.
pub(super) struct Described {
    /// All of it.
    pub line: String,
    /// What stands beside the target above the lines of a block.
    pub head: String,
    /// Names and values.
    pub lines: Vec<(String, String)>,
}

/// In words. `on_node`: say the node too.
pub(super) fn describe(change: &Change, on_node: bool) -> Described {
    match change.action {
        Action::Add => added(change, on_node),
        Action::Remove => removed(change),
        Action::Change | Action::Restart => changed(change),
    }
}

fn added(change: &Change, on_node: bool) -> Described {
    let (lead, lines) = made_of(change, on_node, false, |field| field.new.as_deref());
    let plain = !lead.is_empty() && PLAIN.contains(&change.reason.as_str());
    let why = match plain {
        true => String::new(),
        false if lead.is_empty() && lines.is_empty() => tame(&change.reason).into_owned(),
        false => format!(" ({})", tame(&change.reason)),
    };
    Described {
        line: format!("{}{why}", listed(&lead, &lines)),
        head: format!("{lead}{why}"),
        lines,
    }
}

fn removed(change: &Change) -> Described {
    let (lead, lines) = made_of(change, false, true, |field| field.old.as_deref());
    let was = match listed(&lead, &lines) {
        was if was.is_empty() => was,
        was => format!(" (was {was})"),
    };
    Described {
        line: format!("{}{was}", tame(&change.reason)),
        head: tame(&change.reason).into_owned(),
        lines: match lead.is_empty() {
            true => lines,
            false => std::iter::once(("was".to_owned(), lead))
                .chain(lines)
                .collect(),
        },
    }
}

fn changed(change: &Change) -> Described {
    let why = why(change);
    let pair = |f: &FieldChange| {
        (
            name(f),
            format!("{} -> {}", side(f, &f.old), side(f, &f.new)),
        )
    };
    let lines: Vec<_> = change.fields.iter().map(pair).collect();
    if lines.is_empty() {
        return Described {
            line: why.clone(),
            head: why,
            lines,
        };
    }
    let fields: Vec<_> = lines
        .iter()
        .map(|(name, text)| format!("{name}: {text}"))
        .collect();
    let line = match why.is_empty() {
        true => fields.join(", "),
        false => format!("{} ({why})", fields.join(", ")),
    };
    Described {
        line,
        head: why,
        lines,
    }
}

/// The reason without what the fields say already.
fn why(change: &Change) -> String {
    let in_place = change.action == Action::Change && change.reason.ends_with("set in place");
    let by_hand = change.reason.contains("by hand");
    if change.fields.is_empty() || by_hand {
        return tame(&change.reason).into_owned();
    }
    if in_place {
        let why = match change.reason.contains(GONE) {
            true => "set in place; what is no longer in the profile goes back to its default",
            false => "set in place",
        };
        return why.to_owned();
    }
    tame(news(change)).into_owned()
}

/// `connected anew` of `rate changed: connected anew`, nothing of `type changed from A to B`: the field has that.
fn news(change: &Change) -> &str {
    let of = |field: &FieldChange| {
        let rest = change.reason.strip_prefix(field.field.as_str())?;
        let rest = rest.strip_prefix(" changed")?;
        Some(rest.split_once(": ").map_or("", |(_, rest)| rest))
    };
    let moved = |field: &FieldChange| {
        let (old, new) = (field.old.as_deref()?, field.new.as_deref()?);
        let same = change.reason == format!("moved from {} {old} to {new}", field.field);
        same.then_some("moved")
    };
    let mut fields = change.fields.iter();
    let news = fields.find_map(|field| of(field).or_else(|| moved(field)));
    news.unwrap_or(&change.reason)
}

/// `SineSource in hello.main on local, 100 Hz` and the configuration values; `TimedLong, push, flush` and other
/// properties; `on local`. `named`: with the names of the properties, of which a few may be there.
fn made_of<'a>(
    change: &'a Change,
    on_node: bool,
    named: bool,
    side: impl Fn(&'a FieldChange) -> Option<&'a str>,
) -> (String, Vec<(String, String)>) {
    let (mut lead, mut lines) = (String::new(), Vec::new());
    let mut say = |before: &str, text: &str| {
        if !lead.is_empty() || before != ", " {
            lead.push_str(before);
        }
        lead.push_str(&tame(text));
    };
    for field in &change.fields {
        let Some(new) = side(field) else { continue };
        match field.field.as_str() {
            "type" => say(", ", new),
            "manager" => say(" in ", &display(change, new)),
            "node" if on_node && change.target.starts_with("manager/") => say("on ", new),
            "node" => {}
            "rate" => say(", ", &format!("{new} Hz")),
            "dataType" => say(", ", &value(data_type(new))),
            "executionKind" => say(", ", new),
            "properties.dataport.dataflow_type"
            | "properties.dataport.subscription_type"
            | "properties.dataport.interface_type" => match named {
                true => say(", ", &format!("{} {}", name(field), value(new))),
                false => say(", ", &value(new)),
            },
            "configuration.active" if new == "default" => {}
            "properties.dataport.data_type" => {}
            _ => lines.push((name(field), value(&tame(new)).into_owned())),
        }
    }
    (lead, lines)
}

fn display(change: &Change, manager: &str) -> String {
    match &change.system {
        Some(system) => format!("{system}.{manager}"),
        None => manager.to_owned(),
    }
}

fn listed(lead: &str, lines: &[(String, String)]) -> String {
    let lead = Some(lead.to_owned()).filter(|lead| !lead.is_empty());
    let lines = lines.iter().map(|(name, value)| format!("{name}={value}"));
    lead.into_iter().chain(lines).collect::<Vec<_>>().join(", ")
}

fn name(change: &FieldChange) -> String {
    tame(&field(&change.field)).into_owned()
}

/// One side of a field that differs; `none` where there is nothing.
pub(super) fn side(change: &FieldChange, text: &Option<String>) -> String {
    match text {
        None => "none".to_owned(),
        Some(text) if change.field == "dataType" => value(&tame(data_type(text))).into_owned(),
        Some(text) => value(&tame(text)).into_owned(),
    }
}
