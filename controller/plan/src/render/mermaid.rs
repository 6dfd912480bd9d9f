//! The steps as a flow chart in Mermaid's language.

use std::fmt::Write as _;

use super::dot::{Critical, How, by_node, edges, label};
use super::names::tame;
use crate::plan::{Plan, StepId};

/// A flow chart: steps are nodes, one sub-graph for each node of the robot. `-->`: must have succeeded; dashed: must
/// have started; dotted: must have ended. The critical path is thick.
pub fn render(plan: &Plan) -> String {
    let mut text = String::from("flowchart LR\n");
    let critical = Critical::of(plan);
    for (number, (node, steps)) in by_node(plan).into_iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  subgraph n{number} [\"{}\"]", escaped(&tame(node)));
        for step in steps {
            // Escaped before the line breaks are put in.
            let lines = label(step, "\n");
            let lines: Vec<String> = lines.split('\n').map(escaped).collect();
            let _ = writeln!(text, "    s{}[\"{}\"]", step.id, lines.join("<br/>"));
        }
        text.push_str("  end\n");
    }
    let mut styles = Vec::new();
    for step in &plan.steps {
        for (before, how) in edges(step) {
            let _ = writeln!(text, "  s{before} --> s{}", step.id);
            styles.push(style(how, critical.joins(before, step.id)));
        }
    }
    text.push_str(&link_styles(&styles));
    text.push_str(&bold(plan));
    text
}

/// How an edge is drawn; none for the usual way.
fn style(how: How, critical: bool) -> Option<&'static str> {
    match (how, critical) {
        (How::Needs, false) => None,
        (How::Needs, true) => Some("stroke-width:4px"),
        (How::Start, false) => Some("stroke-dasharray:8 4"),
        (How::Start, true) => Some("stroke-dasharray:8 4,stroke-width:4px"),
        (How::End, false) => Some("stroke-dasharray:2 4"),
        (How::End, true) => Some("stroke-dasharray:2 4,stroke-width:4px"),
    }
}

/// One line for each style: edges are known by their number, from 0.
fn link_styles(styles: &[Option<&'static str>]) -> String {
    let mut by_style = std::collections::BTreeMap::<&str, Vec<String>>::new();
    for (number, style) in styles.iter().enumerate() {
        if let Some(style) = style {
            by_style.entry(style).or_default().push(number.to_string());
        }
    }
    let line = |(style, numbers): (&str, Vec<String>)| {
        format!("  linkStyle {} {style};\n", numbers.join(","))
    };
    by_style.into_iter().map(line).collect()
}

fn bold(plan: &Plan) -> String {
    if plan.critical_path.is_empty() {
        return String::new();
    }
    let name = |id: &StepId| format!("s{id}");
    let steps: Vec<String> = plan.critical_path.iter().map(name).collect();
    format!(
        "  classDef critical stroke-width:4px\n  class {} critical\n",
        steps.join(",")
    )
}

/// Text between double quotes: Mermaid knows entities, and takes `#` for the beginning of one.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '#' => out.push_str("#35;"),
            '"' => out.push_str("#quot;"),
            '<' => out.push_str("#lt;"),
            '>' => out.push_str("#gt;"),
            '&' => out.push_str("#amp;"),
            '`' => out.push_str("#96;"),
            c => out.push(c),
        }
    }
    out
}
