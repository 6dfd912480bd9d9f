//! A plan as text for people, and as a graph.
//!
//! Free of colour: whoever prints it colours by [`Tone`].

mod describe;
pub mod dot;
mod drift;
pub(crate) mod fields;
pub mod mermaid;
pub mod names;
mod restarts;
pub(crate) mod steps;
mod text;

pub use self::drift::drift;
pub use self::fields::details;
pub use self::restarts::restart;
pub use self::steps::{after, critical_path, limit};
pub use self::text::{body, render, render_with};

use serde::{Deserialize, Serialize};

use crate::plan::{Action, Plan};

/// What a piece of text tells, for colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Something is added.
    Add,
    /// Something changes in place.
    Change,
    /// Something is removed.
    Remove,
    /// Something stops and is made again.
    Restart,
    /// Something waits, or was changed by hand.
    Attention,
    /// The heading of a part.
    Heading,
}

/// How a plan is laid out.
#[derive(Clone, Copy)]
pub struct Layout<'a> {
    /// A target takes one line where it fits into this many characters.
    pub width: usize,
    /// Most fields of a changed target on one line; more take a line each.
    pub inline: usize,
    /// Dresses a piece of text, without changing what it takes on the screen.
    pub paint: &'a dyn Fn(Tone, &str) -> String,
}

/// No colour.
pub fn plain(_: Tone, text: &str) -> String {
    text.to_owned()
}

impl Default for Layout<'_> {
    fn default() -> Self {
        Self {
            width: 120,
            inline: 1,
            paint: &plain,
        }
    }
}

/// How much a plan does, in targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Added.
    pub add: usize,
    /// Changed in place.
    pub change: usize,
    /// Removed.
    pub remove: usize,
    /// Stopped and made again.
    pub restart: usize,
}

impl Counts {
    /// Of a plan.
    pub fn of(plan: &Plan) -> Self {
        let mut counts = Self::default();
        for change in &plan.changes {
            *match change.action {
                Action::Add => &mut counts.add,
                Action::Change => &mut counts.change,
                Action::Remove => &mut counts.remove,
                Action::Restart => &mut counts.restart,
            } += 1;
        }
        counts
    }
}

/// `Plan: 3 to add, 1 to change, 0 to remove`, and `, 1 to restart` when there is one.
pub fn summary(plan: &Plan) -> String {
    let counts = Counts::of(plan);
    let mut text = format!(
        "Plan: {} to add, {} to change, {} to remove",
        counts.add, counts.change, counts.remove,
    );
    if counts.restart > 0 {
        text.push_str(&format!(", {} to restart", counts.restart));
    }
    text
}

impl std::fmt::Display for Plan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&render(self))
    }
}

#[cfg(test)]
mod tests;
