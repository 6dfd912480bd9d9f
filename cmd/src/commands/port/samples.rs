//! What comes from a port, as a stream of samples.

use rts_agent_api::messages::PortEvent;
use rts_controller_api::client::Controller;
use rts_http::lines::Lines;

use super::end::Port;
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::plural;
use crate::output::Output;

/// A sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sample {
    /// Time of writing, RFC 3339.
    pub time: String,
    /// Its bytes in base64.
    pub data: String,
}

/// The samples of an out-port as it writes them. Nothing is left of it at the component once this is dropped.
pub struct Samples {
    lines: Lines,
    shown: String,
    missed: Missed,
}

impl Samples {
    /// Begins to look.
    pub async fn of(controller: &Controller, port: &Port, out: Output) -> Result<Self, CliError> {
        let lines = controller.samples(&port.node, &port.instance, &port.name);
        let shown = port.shown();
        let lines = lines
            .await
            .map_err(CliError::request(format!("look at {shown}")))?;
        let mut samples = Self {
            lines,
            missed: Missed::of(&shown, out),
            shown,
        };
        match samples.event().await? {
            PortEvent::Opened { data_type, .. } if data_type == port.data_type => Ok(samples),
            _ => Err(samples.broke("its type is another one by now: try again")),
        }
    }

    /// The next one.
    pub async fn next(&mut self) -> Result<Sample, CliError> {
        loop {
            match self.event().await? {
                PortEvent::Sample {
                    time,
                    missed,
                    size,
                    data,
                } => {
                    self.missed.note(missed);
                    match data {
                        Some(data) => return Ok(Sample { time, data }),
                        None => self.missed.long(size),
                    }
                }
                PortEvent::End { reason } => return Err(self.broke(&reason)),
                PortEvent::Opened { .. } => {}
            }
        }
    }

    async fn event(&mut self) -> Result<PortEvent, CliError> {
        let line = match self.lines.next().await {
            Some(Ok(line)) => line,
            Some(Err(e)) => return Err(self.broke(&e.to_string())),
            None => return Err(self.broke("the stream ended")),
        };
        serde_json::from_str(&line).map_err(|source| CliError::Object {
            object: format!("a sample of {}", self.shown),
            source,
        })
    }

    fn broke(&self, reason: &str) -> CliError {
        CliError::Port {
            message: format!("the samples of {} broke off: {reason}", self.shown),
            help: None,
            exit: Exit::Unreachable,
        }
    }
}

/// Samples that were not seen; told when it ends.
struct Missed {
    out: Output,
    shown: String,
    slow: u64,
    long: u64,
}

impl Missed {
    fn of(shown: &str, out: Output) -> Self {
        Self {
            out,
            shown: shown.to_owned(),
            slow: 0,
            long: 0,
        }
    }

    fn note(&mut self, missed: u64) {
        if self.slow == 0 && missed > 0 {
            self.out.warn(&format!(
                "samples of {} are missed: they are not read as fast as they come",
                self.shown
            ));
        }
        self.slow = missed;
    }

    fn long(&mut self, size: u64) {
        if self.long == 0 {
            let shown = &self.shown;
            self.out.warn(&format!(
                "a sample of {shown} has {size} bytes, which is too long to be shown: it is left out"
            ));
        }
        self.long += 1;
    }
}

impl Drop for Missed {
    fn drop(&mut self) {
        let missed = self.slow + self.long;
        if missed > 0 {
            let (count, shown) = (plural("sample", missed as usize), &self.shown);
            self.out
                .stderr(&format!("rtsctl: {count} of {shown} missed"));
        }
    }
}
