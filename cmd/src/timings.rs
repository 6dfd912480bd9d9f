//! Where the time of a command goes: its own laps, and the spans of controller and agents meanwhile.

use std::time::Duration;

use rts_agent_api::messages::{TimedSpan, micros};
use rts_controller_api::client::Controller;
use rts_host::timing::now;

use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;
use crate::show::timings;

/// Added to the time that is asked for: clocks are read one after the other.
const MARGIN: Duration = Duration::from_millis(5);

/// The laps of a command. The first one began with the program.
#[derive(Debug, Default)]
pub struct Laps {
    last: Duration,
    spans: Vec<TimedSpan>,
}

impl Laps {
    /// Ends a lap, in which this was done.
    pub fn lap(&mut self, what: &str) {
        let end = now();
        self.spans.push(TimedSpan {
            program: timings::OWN.to_owned(),
            what: what.to_owned(),
            of: String::new(),
            depth: 0,
            start: micros(self.last),
            end: micros(end),
        });
        self.last = end;
    }

    /// Prints them behind the outcome of a command, however it ended.
    pub async fn told(
        self,
        outcome: Result<Exit, CliError>,
        session: &Session,
    ) -> Result<Exit, CliError> {
        if self.spans.is_empty() {
            return outcome;
        }
        match self.print(session).await {
            // Of two errors the first one matters.
            Err(e) if outcome.is_ok() => Err(e),
            _ => outcome,
        }
    }

    async fn print(self, session: &Session) -> Result<(), CliError> {
        let text = self.text(&session.connect().await?).await?;
        session.out.result(&text)
    }

    /// The laps and what was done meanwhile, as text.
    async fn text(mut self, controller: &Controller) -> Result<String, CliError> {
        let asked = now();
        let told = controller.timings(asked + MARGIN).await;
        let told = told.map_err(CliError::request("ask where the time went"))?;
        // It looked at its clock somewhere in between.
        let told_at = (asked + now()) / 2;
        self.spans.extend(told.by(micros(told_at), "controller"));
        let end = micros(self.last);
        self.spans.retain(|span| span.end > 0 && span.start < end);
        Ok(timings::text(&self.spans, 0, end))
    }
}
