//! Why a step is in a plan, and why just there.

mod text;
mod words;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use self::text::{step as render_step, target as render_target};
use self::words::{limit, rests_on, rule};
use crate::plan::{Change, Drift, Plan, Restart, Rule, Step, StepId, WaitingOn};
use crate::render::details;

/// One step: why it is done, what stands before it, and what comes of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Explanation {
    /// Which.
    pub step: StepRef,
    /// Node that carries it out.
    pub node: String,
    /// System it is for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<String>,
    /// Why it is done.
    pub reason: String,
    /// The difference that it belongs to, with all fields.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<Change>,
    /// What stands before it, and why.
    pub before: Vec<Link>,
    /// Milliseconds that it sleeps after that (`WaitTime`).
    pub wait_ms: u32,
    /// How long it waits for others, and what happens then.
    pub limits: Vec<String>,
    /// What waits for it, and why.
    pub after: Vec<Link>,
    /// How many steps cannot be done before it, directly or not.
    pub delays: usize,
    /// The longest chain of steps behind it, which it delays: without itself, first to last.
    pub tail: Vec<StepId>,
    /// It is on the critical path: what it takes longer, it takes longer until everything is Active.
    pub critical: bool,
}

/// A step by number and in words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct StepRef {
    /// Number in the plan.
    pub id: StepId,
    /// `Create`.
    pub kind: String,
    /// `component/Sine0`.
    pub target: String,
}

/// How two steps hang together.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Link {
    /// The other one.
    #[serde(flatten)]
    pub step: StepRef,
    /// What of the first the second one waits for.
    pub until: Until,
    /// Rules that say so. Empty when the work itself rests on it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<Rule>,
    /// Why, in words.
    pub why: Vec<String>,
}

/// What of a step another one waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub enum Until {
    /// It has succeeded.
    Succeeded,
    /// It has ended, well or not.
    Ended,
    /// It has started.
    Started,
}

/// A target: what happens to it, or why nothing does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct TargetExplanation {
    /// `component/Sine0`.
    pub target: String,
    /// What differs, of each system and kind of change.
    pub changes: Vec<Change>,
    /// What it waits for.
    pub waiting_on: Vec<WaitingOn>,
    /// What was changed in it by hand.
    pub drift: Vec<Drift>,
    /// The restarts that interrupt it.
    pub restarts: Vec<Restart>,
    /// Its steps.
    pub steps: Vec<Explanation>,
}

/// Explains a step. None when the plan has no step of this number.
pub fn explain(plan: &Plan, step: StepId) -> Option<Explanation> {
    let tails = Tails::of(plan);
    explained(plan, step, &tails)
}

/// Explains all that a plan says of a target. None when it says nothing of it.
pub fn explain_target(plan: &Plan, target: &str) -> Option<TargetExplanation> {
    let tails = Tails::of(plan);
    let steps = plan.steps.iter().filter(|step| step.target == target);
    let details = details(plan).into_iter();
    let found = TargetExplanation {
        target: target.to_owned(),
        changes: details.filter(|c| c.target == target).collect(),
        waiting_on: of_target(&plan.waiting_on, |w| w.target == target),
        drift: of_target(&plan.drift, |d| d.target == target),
        restarts: of_target(&plan.restarts, |r| interrupts(r, target)),
        steps: steps
            .filter_map(|step| explained(plan, step.id, &tails))
            .collect(),
    };
    let nothing = found.changes.is_empty()
        && found.waiting_on.is_empty()
        && found.drift.is_empty()
        && found.steps.is_empty();
    (!nothing).then_some(found)
}

fn of_target<T: Clone>(all: &[T], is: impl Fn(&T) -> bool) -> Vec<T> {
    all.iter().filter(|one| is(one)).cloned().collect()
}

/// The target stops with it, or is cut by it.
fn interrupts(restart: &Restart, target: &str) -> bool {
    let (kind, name) = target.split_once('/').unwrap_or((target, ""));
    let is = |names: &[String]| names.iter().any(|one| one == name);
    match kind {
        "component" => is(&restart.components) || is(&restart.also_stopped),
        "connector" => is(&restart.connectors),
        "manager" => restart.manager == name,
        _ => false,
    }
}

/// A step by its number.
pub(crate) fn step_of(plan: &Plan, id: StepId) -> Option<&Step> {
    let step = plan.steps.get((id as usize).checked_sub(1)?)?;
    (step.id == id).then_some(step)
}

fn explained(plan: &Plan, id: StepId, tails: &Tails) -> Option<Explanation> {
    let step = step_of(plan, id)?;
    let system = step.system.as_ref().map(|system| system.name.as_str());
    let own = |c: &&Change| c.target == step.target && c.system.as_deref() == system;
    let (reach, tail) = tails.from(plan, id);
    Some(Explanation {
        step: reference(step),
        node: step.node.clone(),
        system: system.map(str::to_owned),
        reason: step.reason.clone(),
        change: details(plan).iter().find(own).cloned(),
        before: links(step)
            .into_iter()
            .filter_map(|(other, until)| link(step_of(plan, other)?, step, until, true))
            .collect(),
        wait_ms: step.wait_ms,
        limits: step.limits.iter().map(|l| limit(l, plan)).collect(),
        after: tails.next[&id]
            .iter()
            .filter_map(|(other, until)| link(step, step_of(plan, *other)?, *until, false))
            .collect(),
        delays: reach,
        tail,
        critical: plan.critical_path.contains(&id),
    })
}

fn reference(step: &Step) -> StepRef {
    StepRef {
        id: step.id,
        kind: step.work.kind().to_owned(),
        target: step.target.clone(),
    }
}

/// The steps before a step, by number, each with the most that is waited for.
fn links(step: &Step) -> BTreeMap<StepId, Until> {
    let lists = [
        (&step.after_start_of, Until::Started),
        (&step.after_end_of, Until::Ended),
        (&step.needs, Until::Succeeded),
    ];
    let mut links = BTreeMap::new();
    for (ids, until) in lists {
        links.extend(ids.iter().map(|id| (*id, until)));
    }
    links
}

/// `first` stands before `second`; told from the second one's side, or from the first one's.
fn link(first: &Step, second: &Step, until: Until, from_second: bool) -> Option<Link> {
    let because = second.because.iter().filter(|b| b.step == first.id);
    let rules: Vec<Rule> = because.map(|b| b.rule).collect();
    let mut why: Vec<String> = rules.iter().map(|r| rule(*r, first, second)).collect();
    if why.is_empty() {
        why.push(rests_on(first, second).to_owned());
    }
    Some(Link {
        step: reference(if from_second { first } else { second }),
        until,
        rules,
        why,
    })
}

/// What comes after each step.
struct Tails {
    next: BTreeMap<StepId, Vec<(StepId, Until)>>,
    /// Microseconds from the beginning of a step to the end of what is longest behind it.
    length: BTreeMap<StepId, u64>,
}

impl Tails {
    /// A plan may come from a file: only steps with the right number count, and edges that lead forward.
    fn of(plan: &Plan) -> Self {
        let valid = |step: &&Step| step_of(plan, step.id).is_some();
        let steps: Vec<&Step> = plan.steps.iter().filter(valid).collect();
        let mut next: BTreeMap<StepId, Vec<(StepId, Until)>> =
            steps.iter().map(|step| (step.id, Vec::new())).collect();
        for step in &steps {
            for (before, until) in links(step) {
                let forward = before < step.id;
                if let Some(after) = next.get_mut(&before).filter(|_| forward) {
                    after.push((step.id, until));
                }
            }
        }
        let mut length = BTreeMap::new();
        // Every edge leads forward.
        for step in steps.iter().rev() {
            let behind = next[&step.id].iter().filter_map(|(id, _)| length.get(id));
            let longest: u64 = behind.copied().max().unwrap_or_default();
            let own = crate::critical_path::micros(step);
            length.insert(step.id, longest.saturating_add(own));
        }
        Self { next, length }
    }

    /// How many steps are behind a step, and the longest chain of them.
    fn from(&self, plan: &Plan, id: StepId) -> (usize, Vec<StepId>) {
        let mut reached = vec![false; plan.steps.len() + 1];
        let mut open = vec![id];
        let mut count = 0;
        while let Some(id) = open.pop() {
            for (next, _) in &self.next[&id] {
                if !std::mem::replace(&mut reached[*next as usize], true) {
                    count += 1;
                    open.push(*next);
                }
            }
        }
        let longest = |id: &StepId| {
            let behind = self.next[id].iter().map(|(id, _)| *id);
            behind.max_by_key(|id| (self.length[id], std::cmp::Reverse(*id)))
        };
        (
            count,
            std::iter::successors(longest(&id), longest).collect(),
        )
    }
}
