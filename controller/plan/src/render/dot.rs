//! The steps as a graph in Graphviz's language.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::names::tame;
use super::steps::milliseconds;
use crate::plan::{Plan, Step, StepId};

/// A digraph: steps are nodes, one cluster for each node of the robot. Solid: must have succeeded; dashed: must have
/// started; dotted: must have ended. The critical path is bold.
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
            let style = match (how, critical.joins(before, step.id)) {
                (How::Needs, false) => "",
                (How::Needs, true) => " [style=bold]",
                (How::Start, false) => " [style=dashed]",
                (How::Start, true) => " [style=\"dashed,bold\"]",
                (How::End, false) => " [style=dotted]",
                (How::End, true) => " [style=\"dotted,bold\"]",
            };
            let _ = writeln!(text, "  \"{before}\" -> \"{}\"{style};", step.id);
        }
    }
    text.push_str("}\n");
    text
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
