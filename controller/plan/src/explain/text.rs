//! Explanations as text for people.

use std::fmt::Write as _;

use super::{Explanation, Link, TargetExplanation, Until};
use crate::plan::{Change, Plan};
use crate::render::names::tame;
use crate::render::steps::{chain, milliseconds};
use crate::render::{Layout, body};

/// A step. Ends with a newline.
pub fn step(it: &Explanation) -> String {
    let mut text = String::new();
    let (id, kind, target) = (it.step.id, &it.step.kind, &it.step.target);
    let system = it.system.iter().map(|name| format!(", system {name}"));
    let place = format!("{}{}", it.node, system.collect::<String>());
    line(&mut text, &format!("step {id}: {kind} {target} on {place}"));
    line(&mut text, &format!("why: {}", it.reason));
    if let Some(change) = &it.change {
        text.push_str(&changes(std::slice::from_ref(change)));
    }
    now(&mut text, it);
    if it.after.is_empty() {
        line(&mut text, "nothing waits for it");
    } else {
        line(&mut text, "because of it wait:");
        links(&mut text, &it.after, "it");
    }
    line(&mut text, &weight(it));
    text
}

/// What stands before it.
fn now(text: &mut String, it: &Explanation) {
    if it.before.is_empty() {
        line(text, "it waits for no other step");
    } else {
        line(text, "it waits until:");
        links(text, &it.before, "");
    }
    if it.wait_ms > 0 {
        let time = milliseconds(u64::from(it.wait_ms));
        line(text, &format!("then it waits {time} (WaitTime)"));
    }
    for limit in &it.limits {
        line(text, &format!("it {limit}"));
    }
}

/// How much depends on it.
fn weight(it: &Explanation) -> String {
    let critical = match it.critical {
        true => "it is on the critical path: what delays it delays the plan as a whole",
        false => "it is not on the critical path: it has time to spare",
    };
    match it.delays {
        0 => critical.to_owned(),
        count => {
            let steps = if count == 1 { "step" } else { "steps" };
            let tail = chain(&it.tail);
            format!("{critical}; {count} {steps} behind it, the longest chain is {tail}")
        }
    }
}

/// `  6  LoadModule module/Printer@hello.main  has succeeded: its module must be loaded`; the columns aligned. `it` is
/// the step itself where the others are those that wait.
fn links(text: &mut String, links: &[Link], it: &str) {
    let name = |link: &Link| format!("{} {}", link.step.kind, link.step.target);
    let ids = links.iter().map(|l| l.step.id.to_string().len()).max();
    let names = links.iter().map(|l| name(l).chars().count()).max();
    let (ids, names) = (ids.unwrap_or_default(), names.unwrap_or_default());
    for link in links {
        let until = match link.until {
            Until::Succeeded => "has succeeded",
            Until::Ended => "has ended, well or not",
            Until::Started => "has started",
        };
        let until = match it {
            "" => until.to_owned(),
            it => format!("until {it} {until}"),
        };
        let (id, name, why) = (link.step.id, name(link), link.why.join("; "));
        line(
            text,
            &format!("  {id:>ids$}  {name:names$}  {until}: {why}"),
        );
    }
}

/// A target. Ends with a newline.
pub fn target(it: &TargetExplanation) -> String {
    let mut text = changes(&it.changes);
    let rest = Plan {
        waiting_on: it.waiting_on.clone(),
        drift: it.drift.clone(),
        restarts: it.restarts.clone(),
        ..Plan::default()
    };
    text.push_str(&body(&rest, &Layout::default()));
    if it.steps.is_empty() {
        let why = match it.waiting_on.is_empty() {
            true => "no step of the plan works on it",
            false => "no step of the plan works on it: it waits for what is said above",
        };
        line(&mut text, why);
    }
    for explanation in &it.steps {
        text.push('\n');
        // The change is said above, once.
        let bare = Explanation {
            change: None,
            ..explanation.clone()
        };
        text.push_str(&step(&bare));
    }
    text
}

fn changes(changes: &[Change]) -> String {
    let plan = Plan {
        changes: changes.to_vec(),
        ..Plan::default()
    };
    body(&plan, &Layout::default())
}

fn line(text: &mut String, line: &str) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{}", tame(line));
}
