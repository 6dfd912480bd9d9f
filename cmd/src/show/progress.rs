//! Progress of a system on stderr: one line drawn over itself on a terminal, plain lines elsewhere.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rts_controller_api::objects::{System, Waiting};

use crate::output::Output;

/// Least time between two plain lines.
const PAUSE: Duration = Duration::from_secs(1);

/// Targets with the same reason that are named.
const NAMED: usize = 8;
/// Least length of a reason that is not said again, in bytes.
const LONG: usize = 30;

/// Shows how far a system is.
#[derive(Debug)]
pub struct Progress {
    out: Output,
    bar: Option<ProgressBar>,
    last: Option<(Instant, String)>,
}

impl Progress {
    /// Shows something at once.
    pub fn start(out: Output, first: &str) -> Self {
        let bar = out.animated().then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            // The template is a constant; a bar without it works as well.
            if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg} {elapsed}") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(100));
            bar
        });
        let mut progress = Self {
            out,
            bar,
            last: None,
        };
        progress.show(first.to_owned());
        progress
    }

    /// Shows a state.
    pub fn system(&mut self, system: &System) {
        self.show(line(system));
    }

    fn show(&mut self, text: String) {
        if let Some(bar) = &self.bar {
            bar.set_message(text);
            return;
        }
        let due = self
            .last
            .as_ref()
            .is_none_or(|(at, last)| at.elapsed() >= PAUSE && *last != text);
        if due {
            self.out.say(&format!("rtsctl: {text}"));
            self.last = Some((Instant::now(), text));
        }
    }

    /// Takes the line away.
    pub fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.end();
    }
}

/// `component/Motor0: Create: no such file`; a reason that names its target again does so once.
pub fn waits(waiting: &Waiting) -> String {
    format!("{}: {}", waiting.target, reason(waiting))
}

/// The same of several. A reason that several have, with the same facts behind it, is said once; one that ends with the
/// reason of another one names that instead.
pub fn grouped<'a>(
    waiting: impl IntoIterator<Item = &'a Waiting>,
    facts: impl Fn(&Waiting) -> String,
) -> Vec<String> {
    let waiting: Vec<_> = waiting.into_iter().collect();
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for one in &waiting {
        let why = shortened(reason(one), &waiting) + &facts(one);
        match groups.iter_mut().find(|(known, _)| *known == why) {
            Some((_, targets)) => targets.push(&one.target),
            None => groups.push((why, vec![&one.target])),
        }
    }
    let lines = groups.into_iter();
    lines
        .map(|(why, targets)| format!("{}: {why}", named(&targets)))
        .collect()
}

/// `component/A, component/B and 98 more`.
fn named(targets: &[&str]) -> String {
    let shown = targets.len().min(NAMED);
    match targets.len() - shown {
        0 => targets.join(", "),
        more => format!("{} and {more} more", targets[..shown].join(", ")),
    }
}

/// `Sine0 is not there: as component/Sine0`, where that one's reason is told as well.
pub fn shortened(reason: String, all: &[&Waiting]) -> String {
    let ends = |other: &&&Waiting| {
        let rest = reason.strip_suffix(&other.reason);
        other.reason.len() >= LONG && rest.is_some_and(|rest| rest.ends_with(": "))
    };
    // Of several the first one.
    let longest = all.iter().rev().filter(ends);
    let longest = longest.max_by_key(|w| w.reason.len());
    match longest.and_then(|other| Some((reason.strip_suffix(&other.reason)?, &other.target))) {
        Some((begin, target)) => format!("{begin}as {target}"),
        None => reason,
    }
}

fn reason(waiting: &Waiting) -> String {
    let (target, reason) = (&waiting.target, waiting.reason.as_str());
    let reason = reason
        .strip_prefix(&format!("{target}: "))
        .unwrap_or(reason);
    match reason.split_once(&format!(" {target}: ")) {
        Some((verb, rest)) if !verb.contains(' ') => format!("{verb}: {rest}"),
        _ => reason.to_owned(),
    }
}

/// `system/hello: 3 of 14 steps, 1 of 3 components active: Create component/Sine0`.
fn line(system: &System) -> String {
    let status = &system.status;
    let progress = &status.progress;
    let mut text = format!("system/{}: ", system.metadata.name);
    if progress.total > 0 {
        text.push_str(&format!("{} of {} steps, ", progress.done, progress.total));
    }
    text.push_str(&format!(
        "{} of {} components active",
        status.active, status.components
    ));
    if !progress.running.is_empty() {
        text.push_str(": ");
        text.push_str(&progress.running.join(", "));
    } else {
        // What is under way says more than what stands.
        let mut waiting = status.waiting_on.iter();
        let under_way = waiting.find(|waiting| waiting.transient);
        if let Some(waiting) = under_way.or(status.waiting_on.first()) {
            text.push_str(&format!(": {}", waits(waiting)));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::samples;

    #[test]
    fn a_reason_does_not_name_its_target_again() {
        let waiting = |reason: &str| Waiting {
            target: "component/R".to_owned(),
            reason: reason.to_owned(),
            required: true,
            transient: false,
            tries: 1,
            next_try: None,
        };
        let said = |reason| waits(&waiting(reason));
        assert_eq!(
            said("Create component/R: no memory"),
            "component/R: Create: no memory"
        );
        assert_eq!(said("component/R: gone"), "component/R: gone");
        assert_eq!(
            said("waits for component/R: it"),
            "component/R: waits for component/R: it"
        );
        let other = Waiting {
            target: "component/S".to_owned(),
            ..waiting("node n is of another store")
        };
        let all = [
            waiting("node n is of another store"),
            waiting("gone"),
            other,
        ];
        let tries = |w: &Waiting| format!(" (tried {})", w.tries);
        assert_eq!(
            grouped(&all, tries),
            [
                "component/R, component/S: node n is of another store (tried 1)",
                "component/R: gone (tried 1)"
            ]
        );
        let end = Waiting {
            target: "connector/R.o-S.i".to_owned(),
            ..waiting("R is not there: node n is of another store and so on")
        };
        let same = Waiting {
            target: "component/S".to_owned(),
            ..waiting("node n is of another store and so on")
        };
        let all = [waiting("node n is of another store and so on"), same, end];
        assert_eq!(
            grouped(&all, |_| String::new())[1],
            "connector/R.o-S.i: R is not there: as component/R"
        );
    }

    #[test]
    fn of_many_targets_with_one_reason_a_few_are_named() {
        let all: Vec<Waiting> = (0..100)
            .map(|i| Waiting {
                target: format!("component/C{i}"),
                reason: "gone".to_owned(),
                required: true,
                transient: false,
                tries: 1,
                next_try: None,
            })
            .collect();
        insta::assert_snapshot!(grouped(&all, |_| String::new()).join("\n"), @"component/C0, component/C1, component/C2, component/C3, component/C4, component/C5, component/C6, component/C7 and 92 more: gone");
        assert_eq!(
            named(&["component/A"; NAMED])
                .matches("component/A")
                .count(),
            NAMED
        );
    }

    #[test]
    fn a_line_says_how_far_it_is_and_what_runs_now() {
        let mut system = samples::system();
        system.status.progress.done = 3;
        system.status.progress.total = 14;
        system.status.progress.running = vec!["Create component/Sine0".to_owned()];
        system.status.active = 1;
        insta::assert_snapshot!(line(&system), @"system/hello: 3 of 14 steps, 1 of 3 components active: Create component/Sine0");
    }
}
