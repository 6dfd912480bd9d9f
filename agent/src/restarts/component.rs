//! What is remembered of one component: where it lives, how often and when its process ended, and why it is not brought
//! up again.

use std::time::Duration;

use jiff::Timestamp;
use rts_plan::desired::SystemRef;
use rts_plan::observed::Held;
use rts_plan::restart::{Ended, Verdict, verdict, window};
use rts_schemas::system::Policy;
use serde::{Deserialize, Serialize};

use crate::policies::Policies;

/// Most deaths of one component that are remembered, whatever its limit.
const MAX_DEATHS: usize = 1001;
/// How many are remembered of one without a limit.
const DEATHS: usize = 16;

/// What is remembered of one component.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Component {
    pub system: SystemRef,
    pub instance: String,
    /// How often it was made again since its process ended.
    #[serde(default)]
    pub restarts: u32,
    /// When its processes ended by themselves, within its window and this boot.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    deaths: Vec<Timestamp>,
    /// How the last of them ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    last_exit: Option<String>,
    /// Incarnation of the manager that it lives in, or was about to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lives_in: Option<String>,
    /// Why it is not brought up again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<String>,
    /// The text of its system's part under which its deaths are counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Incarnation of a manager that has ended, or was told to: an answer that it gave before says nothing any more.
    #[serde(skip)]
    pub ended_in: Option<String>,
    /// Number of the last word on it alone.
    #[serde(skip)]
    pub told: u64,
    /// It is just being deleted.
    #[serde(skip)]
    pub leaving: bool,
}

impl Component {
    pub fn new(system: &SystemRef, instance: &str) -> Self {
        Self {
            system: system.clone(),
            instance: instance.to_owned(),
            restarts: 0,
            deaths: Vec::new(),
            last_exit: None,
            lives_in: None,
            held: None,
            part: None,
            ended_in: None,
            told: 0,
            leaving: false,
        }
    }

    /// The manager that it lives in is no more, or was told to end.
    pub fn end(&mut self) {
        self.ended_in = self.lives_in.take();
    }

    /// All is forgotten that speaks against making it again.
    pub fn pardon(&mut self) {
        self.deaths.clear();
        self.held = None;
        self.part = None;
    }

    pub fn died(&mut self, ended: Ended, now: Timestamp, policies: &Policies) -> Option<Held> {
        self.end();
        self.restarts = self.restarts.saturating_add(1);
        self.last_exit = Some(ended.to_string());
        let policy = policies.of(&self.system, &self.instance)?;
        self.part = policies.part(&self.system).map(str::to_owned);
        let recent = self.count(policy, now);
        let Verdict::Held(reason) = verdict(policy, ended, recent) else {
            return None;
        };
        self.held = Some(reason);
        self.held()
    }

    /// Adds a death, forgets those that count no more, and gives the number of those left.
    fn count(&mut self, policy: &Policy, now: Timestamp) -> u32 {
        let window = window(policy);
        self.deaths.retain(|death| apart(*death, now) <= window);
        self.deaths.push(now);
        let most = policy.restart_limit.map_or(DEATHS, |limit| {
            usize::try_from(limit).map_or(MAX_DEATHS, |limit| limit.saturating_add(1))
        });
        let over = self.deaths.len().saturating_sub(most.min(MAX_DEATHS));
        self.deaths.drain(..over);
        u32::try_from(self.deaths.len()).unwrap_or(u32::MAX)
    }

    pub fn held(&self) -> Option<Held> {
        Some(Held {
            system: self.system.clone(),
            instance: self.instance.clone(),
            part: None,
            reason: self.held.clone()?,
        })
    }
}

/// The time between two, whichever is earlier: a clock may be set back.
fn apart(one: Timestamp, other: Timestamp) -> Duration {
    one.duration_since(other).unsigned_abs()
}
