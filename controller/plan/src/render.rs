//! A plan as text for people.

use std::fmt::Write as _;

use crate::in_place::GONE;
use crate::plan::{Action, Change, FieldChange, Plan, Restart};

/// Changes, restarts, what waits, remarks, and the summary line. Ends with a newline.
pub fn render(plan: &Plan) -> String {
    let mut text = String::new();
    let width = plan.changes.iter().map(|c| c.target.chars().count());
    let width = width.max().unwrap_or_default();
    for change in &plan.changes {
        let (sign, target) = (sign(change.action), &change.target);
        line(
            &mut text,
            format_args!("{sign} {target:width$}  {}", what(change)),
        );
    }
    for restart in &plan.restarts {
        line(
            &mut text,
            format_args!("restarts: {}", blast_radius(restart)),
        );
    }
    for waiting in &plan.waiting_on {
        let (target, reason) = (&waiting.target, &waiting.reason);
        line(&mut text, format_args!("waiting: {target}: {reason}"));
    }
    for note in &plan.notes {
        line(&mut text, format_args!("note: {note}"));
    }
    line(&mut text, format_args!("{}", summary(plan)));
    text
}

/// `Plan: 3 to add, 1 to change, 0 to remove`, and `, 1 to restart` when there is one.
pub fn summary(plan: &Plan) -> String {
    let count = |action| plan.changes.iter().filter(|c| c.action == action).count();
    let mut text = format!(
        "Plan: {} to add, {} to change, {} to remove",
        count(Action::Add),
        count(Action::Change),
        count(Action::Remove),
    );
    let restarts = count(Action::Restart);
    if restarts > 0 {
        text.push_str(&format!(", {restarts} to restart"));
    }
    text
}

impl std::fmt::Display for Plan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&render(self))
    }
}

fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{arguments}");
}

fn sign(action: Action) -> &'static str {
    match action {
        Action::Add => "+",
        Action::Change => "~",
        Action::Remove => "-",
        Action::Restart => "!",
    }
}

fn what(change: &Change) -> String {
    if change.fields.is_empty() {
        return change.reason.clone();
    }
    let fields: Vec<String> = change.fields.iter().map(field).collect();
    let in_place = change.action == Action::Change && change.reason.ends_with("set in place");
    let why = if in_place && change.reason.contains(GONE) {
        "set in place; what is no longer in the profile goes back to its default"
    } else if in_place {
        "set in place"
    } else {
        &change.reason
    };
    format!("{} ({why})", fields.join(", "))
}

fn field(change: &FieldChange) -> String {
    let text = |value: &Option<String>| value.clone().unwrap_or_else(|| "none".to_owned());
    let (name, old, new) = (&change.field, text(&change.old), text(&change.new));
    format!("{name}: {old} -> {new}")
}

fn blast_radius(restart: &Restart) -> String {
    let (manager, node) = (&restart.manager, &restart.node);
    let components = match restart.components.as_slice() {
        [] => "none".to_owned(),
        names => names.join(", "),
    };
    match restart.pid {
        Some(pid) => format!(
            "process {manager} (pid {pid}) on {node} stops; components made again: {components}"
        ),
        None => format!("process {manager} on {node} goes on; components made again: {components}"),
    }
}
