//! The steps as a flow chart in Mermaid's language.

use std::fmt::Write as _;

use super::dot::{Critical, How, by_node, edges, label, limits};
use super::names::tame;
use crate::plan::{Plan, StepId};

/// A flow chart: steps are nodes, one sub-graph for each node of the robot. `-->`: must have succeeded; `-.->`: must have
/// started; `--o`: must have ended; with a label: for how long that is waited for. The critical path is thick.
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
    // Edges are known by their number, from 0.
    let (mut count, mut thick) = (0, Vec::new());
    for step in &plan.steps {
        for (before, how) in edges(step) {
            let label = limits(step, before).map(|limit| format!("|\"{}\"|", escaped(&limit)));
            let (arrow, label) = (arrow(how), label.unwrap_or_default());
            let _ = writeln!(text, "  s{before} {arrow}{label} s{}", step.id);
            if critical.joins(before, step.id) {
                thick.push(count.to_string());
            }
            count += 1;
        }
    }
    if !thick.is_empty() {
        let _ = writeln!(text, "  linkStyle {} stroke-width:4px;", thick.join(","));
    }
    text.push_str(&bold(plan));
    text
}

fn arrow(how: How) -> &'static str {
    match how {
        How::Needs => "-->",
        How::Start => "-.->",
        How::End => "--o",
    }
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
