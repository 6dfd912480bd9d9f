//! What all checks work with.

use std::time::{Duration, Instant};

use rts_controller_api::client::Controller;
use rts_controller_api::objects::System;
use rts_controller_api::requests::PlanResult;
use rts_schemas::system::SystemSpec;

use super::failure::Failure;
use super::processes::Family;
use super::snapshot::Snapshot;
use super::stack::Stack;
use crate::error::CliError;
use crate::follow::{Verdict, judge};
use crate::input::Input;
use crate::show::picture;

/// Time between two looks.
pub const PAUSE: Duration = Duration::from_millis(50);

/// The system that is tried, where, and what was learnt so far.
#[derive(Debug)]
pub struct Context<'a> {
    /// The system.
    pub input: &'a Input,
    /// Where it is tried.
    pub stack: &'a Stack,
    /// When all checks must be done.
    pub deadline: Instant,
    /// The controller, once it runs.
    controller: Option<Controller>,
    /// What the first apply was to do.
    pub plan: Option<PlanResult>,
    /// Steps as they were seen to run: text, since when, until when.
    pub steps: Vec<(String, Instant, Option<Instant>)>,
    /// What ran once all was up.
    pub settled: Snapshot,
    /// When that was.
    pub settled_at: Instant,
    /// How long it must stay so.
    pub steady: Duration,
    /// What ran last.
    pub last: Snapshot,
    /// All processes that were seen.
    pub family: Family,
}

impl<'a> Context<'a> {
    /// Nothing runs yet.
    pub fn new(input: &'a Input, stack: &'a Stack, timeout: Duration, steady: Duration) -> Self {
        Self {
            input,
            stack,
            deadline: Instant::now() + timeout,
            controller: None,
            plan: None,
            steps: Vec::new(),
            settled: Snapshot::default(),
            settled_at: Instant::now(),
            steady,
            last: Snapshot::default(),
            family: Family::of(stack.home().path()),
        }
    }

    /// The system as it was read.
    pub fn spec(&self) -> &'a SystemSpec {
        &self.input.request.spec
    }

    /// Its name.
    pub fn name(&self) -> &'a str {
        &self.spec().name
    }

    /// Connects to the controller.
    pub async fn connect(&mut self) -> Result<(), CliError> {
        self.controller = Some(self.stack.session.connect().await?);
        Ok(())
    }

    /// The controller.
    pub fn controller(&self) -> Result<Controller, CliError> {
        let none = || CliError::NoController {
            home: self.stack.home().path().to_owned(),
        };
        self.controller.clone().ok_or_else(none)
    }

    /// What runs now.
    pub async fn look(&mut self) -> Result<&Snapshot, CliError> {
        self.last = Snapshot::take(&self.controller()?, self.name()).await?;
        Ok(&self.last)
    }

    /// The system.
    pub async fn system(&self) -> Result<System, CliError> {
        let asked = self.controller()?.system(self.name()).await;
        asked.map_err(CliError::request(format!("find system/{}", self.name())))
    }

    /// Fails once something required does not run and trying has begun to back off.
    pub async fn well(&self) -> Result<(), Failure> {
        let system = self.system().await?;
        match judge(&system, system.metadata.generation) {
            Verdict::Partly(waiting) => {
                let required = waiting.iter().filter(|w| w.required);
                let failure = Failure::new(format!("system/{} is no longer well", self.name()));
                Err(failure.waiting(required, self.spec()))
            }
            _ => Ok(()),
        }
    }

    /// Time is up.
    pub fn late(&self) -> bool {
        Instant::now() >= self.deadline
    }

    /// A picture of the system as it was seen last.
    pub fn picture(&self) -> String {
        picture::svg(self.spec(), &self.last.components, &self.last.connectors)
    }
}
