//! The steps as a graph in Graphviz's language.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::names::tame;
use super::steps::{milliseconds, within};
use crate::plan::{Plan, Step, StepId};

/// A digraph: steps are nodes, one cluster for each node of the robot. Solid: must have succeeded; dashed: must have
/// started; dotted: must have ended; with a label: for how long that is waited for. The critical path is bold.
pub fn render(plan: &Plan) -> String {
    let mut text = String::from(HEAD);
    let critical = Critical::of(plan);
    for (number, (node, steps)) in by_node(plan).into_iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  subgraph \"cluster_{number}\" {{\n    label={};",
            quoted(node)
        );
        for step in steps {
            let bold = if critical.has(step.id) {
                ", style=bold"
            } else {
                ""
            };
            let label = quoted(&label(step, "\n"));
            let _ = writeln!(text, "    \"{}\" [label={label}{bold}];", step.id);
        }
        text.push_str("  }\n");
    }
    for step in &plan.steps {
        for (before, how) in edges(step) {
            let looks = looks(step, before, how, critical.joins(before, step.id));
            let _ = writeln!(text, "  \"{before}\" -> \"{}\"{looks};", step.id);
        }
    }
    text.push_str("}\n");
    text
}

/// ` [style="dashed,bold", label="at most 300 ms, then fails"]`; empty for the usual way.
fn looks(step: &Step, before: StepId, how: How, critical: bool) -> String {
    let style = match (how, critical) {
        (How::Needs, false) => None,
        (How::Needs, true) => Some("style=bold".to_owned()),
        (How::Start, false) => Some("style=dashed".to_owned()),
        (How::Start, true) => Some("style=\"dashed,bold\"".to_owned()),
        (How::End, false) => Some("style=dotted".to_owned()),
        (How::End, true) => Some("style=\"dotted,bold\"".to_owned()),
    };
    let label = limits(step, before).map(|limit| format!("label={}", quoted(&limit)));
    let looks: Vec<String> = style.into_iter().chain(label).collect();
    match looks.is_empty() {
        true => String::new(),
        false => format!(" [{}]", looks.join(", ")),
    }
}

const HEAD: &str =
    "digraph \"plan\" {\n  rankdir=LR;\n  node [shape=box, fontname=\"sans-serif\"];\n";

/// In which way one step stands before another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum How {
    Needs,
    Start,
    End,
}

/// The steps before a step, each once in each way.
pub(super) fn edges(step: &Step) -> Vec<(StepId, How)> {
    let lists = [
        (&step.needs, How::Needs),
        (&step.after_start_of, How::Start),
        (&step.after_end_of, How::End),
    ];
    let pairs = |(ids, how): (&Vec<StepId>, How)| {
        let ids: BTreeSet<StepId> = ids.iter().copied().collect();
        ids.into_iter().map(move |id| (id, how))
    };
    lists.into_iter().flat_map(pairs).collect()
}

/// How long a step waits for one before it, and what then (`at most 300 ms, then fails`). None without a limit.
pub(super) fn limits(step: &Step, before: StepId) -> Option<String> {
    let limits = step.limits.iter().filter(|l| l.steps.contains(&before));
    let limits: Vec<String> = limits.map(|l| within(l, "")).collect();
    (!limits.is_empty()).then(|| limits.join("; "))
}

/// The steps of each node, in the order of the nodes' names.
pub(super) fn by_node(plan: &Plan) -> Vec<(&str, Vec<&Step>)> {
    let mut nodes = std::collections::BTreeMap::<&str, Vec<&Step>>::new();
    for step in &plan.steps {
        nodes.entry(&step.node).or_default().push(step);
    }
    nodes.into_iter().collect()
}

/// `3 Create`, then `component/Sine0`, then what it waits.
pub(super) fn label(step: &Step, newline: &str) -> String {
    let (id, kind, target) = (step.id, step.work.kind(), tame(&step.target));
    let mut text = format!("{id} {kind}{newline}{target}");
    if step.wait_ms > 0 {
        let time = milliseconds(u64::from(step.wait_ms));
        text.push_str(&format!("{newline}waits {time}"));
    }
    text
}

/// The critical path, to be asked.
pub(super) struct Critical {
    steps: BTreeSet<StepId>,
    pairs: BTreeSet<(StepId, StepId)>,
}

impl Critical {
    pub fn of(plan: &Plan) -> Self {
        let path = &plan.critical_path;
        Self {
            steps: path.iter().copied().collect(),
            pairs: path.windows(2).map(|pair| (pair[0], pair[1])).collect(),
        }
    }

    pub fn has(&self, step: StepId) -> bool {
        self.steps.contains(&step)
    }

    pub fn joins(&self, before: StepId, after: StepId) -> bool {
        self.pairs.contains(&(before, after))
    }
}

/// A quoted string: everything but the quote and the backslash stands for itself.
fn quoted(text: &str) -> String {
    let text = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{}\"", text.replace('\n', "\\n"))
}
