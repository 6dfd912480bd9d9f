//! Differences as lines: a target on one line where it fits, else with a line for each field.

use std::collections::{BTreeMap, BTreeSet};

use super::describe::{Described, describe};
use super::names::tame;
use super::restarts::parts;
use super::{Layout, Tone, details, summary};
use crate::plan::{Action, Change, Plan, Restart};

/// What continues a line above stands this far in.
const INDENT: &str = "    ";

/// Everything but the steps, and the summary line. Ends with a newline.
pub fn render(plan: &Plan) -> String {
    render_with(plan, &Layout::default())
}

/// The same in another layout.
pub fn render_with(plan: &Plan, layout: &Layout<'_>) -> String {
    format!("{}{}\n", body(plan, layout), summary(plan))
}

/// Changes, restarts, drift, what waits and remarks, without the summary line. Each line ends with a newline.
pub fn body(plan: &Plan, layout: &Layout<'_>) -> String {
    let mut text = Text {
        layout,
        out: String::new(),
    };
    text.changes(plan);
    for restart in &plan.restarts {
        text.restart(restart);
    }
    for drift in &plan.drift {
        let line = super::drift(drift);
        text.line(Tone::Attention, "drift:", &line);
    }
    for waiting in &plan.waiting_on {
        let line = format!("{}: {}", waiting.target, waiting.reason);
        text.line(Tone::Attention, "waiting:", &tame(&line));
    }
    for note in &plan.notes {
        text.line(Tone::Heading, "note:", &tame(note));
    }
    text.out
}

struct Text<'l> {
    layout: &'l Layout<'l>,
    out: String,
}

/// How wide the columns of some changes are.
struct Columns {
    target: usize,
    node: usize,
    /// Several nodes take part: each line says which is meant.
    nodes: bool,
}

impl Text<'_> {
    fn changes(&mut self, plan: &Plan) {
        let changes = shortened(plan);
        let nodes = nodes(plan);
        let mut systems: BTreeMap<_, Vec<&Change>> = BTreeMap::new();
        for change in &changes {
            let system = change.system.as_deref();
            // What belongs to no system stands last.
            let of = systems.entry((system.is_none(), system)).or_default();
            of.push(change);
        }
        let several = systems.len() > 1;
        for ((_, system), changes) in systems {
            if several {
                let heading = match system {
                    Some(name) => format!("system {name}:"),
                    None => "of no system:".to_owned(),
                };
                self.line(Tone::Heading, &heading, "");
            }
            let node = |c: &'_ Change| match c.node.as_deref() {
                Some(node) => node.to_owned(),
                None => nodes
                    .get(c.target.as_str())
                    .copied()
                    .unwrap_or_default()
                    .to_owned(),
            };
            let widest = |of: &dyn Fn(&Change) -> usize| {
                let widths = changes.iter().map(|c| of(c));
                widths.max().unwrap_or_default()
            };
            let columns = Columns {
                target: widest(&|c| c.target.chars().count()),
                node: widest(&|c| node(c).chars().count()),
                nodes: nodes.values().collect::<BTreeSet<_>>().len() > 1,
            };
            for change in &changes {
                self.change(change, &node(change), &columns);
            }
        }
    }

    fn change(&mut self, change: &Change, node: &str, columns: &Columns) {
        let (tone, sign) = sign(change.action);
        let (target, width) = (tame(&change.target), columns.target);
        let mut place = format!("{target:width$}");
        if columns.nodes {
            let width = columns.node;
            place.push_str(&format!("  {node:width$}"));
        }
        let said = describe(change, !columns.nodes);
        let taken = 4 + place.chars().count();
        if self.fits(change, &said, taken) {
            return self.line(tone, sign, &format!("{place}  {}", said.line));
        }
        self.line(tone, sign, &format!("{place}  {}", said.head));
        self.pairs(&said.lines);
    }

    fn fits(&self, change: &Change, said: &Described, taken: usize) -> bool {
        let changes = matches!(change.action, Action::Change | Action::Restart);
        let short = !changes || said.lines.len() <= self.layout.inline;
        let wide = taken + said.line.chars().count() > self.layout.width;
        said.lines.is_empty() || (short && !wide)
    }

    /// Names and values under a line, aligned.
    fn pairs<S: AsRef<str>>(&mut self, pairs: &[(S, String)]) {
        let widths = pairs.iter().map(|(name, _)| name.as_ref().chars().count());
        let width = widths.max().unwrap_or_default();
        for (name, text) in pairs {
            let line = format!("{INDENT}{:width$}  {text}\n", name.as_ref());
            self.out.push_str(&line);
        }
    }

    fn restart(&mut self, restart: &Restart) {
        let (head, parts) = parts(restart);
        let whole = super::restart(restart);
        let fits = whole.chars().count() <= self.layout.width;
        let line = if fits { &whole } else { &head };
        let rest = line.strip_prefix("restarts: ").unwrap_or(line);
        self.line(Tone::Restart, "restarts:", rest);
        if !fits {
            self.pairs(&parts);
        }
    }

    fn line(&mut self, tone: Tone, head: &str, rest: &str) {
        let line = format!("{} {rest}", (self.layout.paint)(tone, head));
        self.out.push_str(line.trim_end());
        self.out.push('\n');
    }
}

/// The changes; what is said under `waiting:` is not said twice.
fn shortened(plan: &Plan) -> Vec<Change> {
    let waiting = plan.waiting_on.iter();
    let waiting: BTreeMap<_, _> = waiting.map(|w| (&w.target, &w.reason)).collect();
    let mut changes = details(plan);
    for change in &mut changes {
        let told = waiting.get(&change.target).and_then(|why| {
            let before = change.reason.strip_suffix(why.as_str())?;
            before.strip_suffix("; blocked: ").map(str::to_owned)
        });
        if let Some(reason) = told {
            change.reason = match change.action {
                Action::Add => "waits, see below".to_owned(),
                _ => format!("{reason}; waits, see below"),
            };
        }
    }
    changes
}

/// Target → node. Of a component that moves the node that it comes to.
fn nodes(plan: &Plan) -> BTreeMap<&str, &str> {
    let steps = plan.steps.iter();
    steps
        .map(|s| (s.target.as_str(), s.node.as_str()))
        .collect()
}

fn sign(action: Action) -> (Tone, &'static str) {
    match action {
        Action::Add => (Tone::Add, "+"),
        Action::Change => (Tone::Change, "~"),
        Action::Remove => (Tone::Remove, "-"),
        Action::Restart => (Tone::Restart, "!"),
    }
}
