//! Progress of a system on stderr: one line drawn over itself on a terminal, plain lines elsewhere.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rts_controller_api::objects::{System, Waiting};

use crate::output::Output;

/// Least time between two plain lines.
const PAUSE: Duration = Duration::from_secs(1);

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
    let (target, reason) = (&waiting.target, waiting.reason.as_str());
    let reason = reason
        .strip_prefix(&format!("{target}: "))
        .unwrap_or(reason);
    match reason.split_once(&format!(" {target}: ")) {
        Some((verb, rest)) if !verb.contains(' ') => format!("{target}: {verb}: {rest}"),
        _ => format!("{target}: {reason}"),
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
