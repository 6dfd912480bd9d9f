//! A system's life: what is planned at each turn, then carried out.

use std::fmt::Write as _;

use rts_plan::plan::{Blocked, Plan};
use rts_plan::render::{after, critical_path};
use rts_plan::{StoredSystem, plan, render};

use super::World;
use super::execute::Chance;
use super::specs::hello;

/// One system on one node.
pub struct Story {
    pub world: World,
    pub blocked: Blocked,
}

impl Story {
    pub fn new() -> Self {
        Self::of(hello())
    }

    pub fn of(system: StoredSystem) -> Self {
        let mut world = World::new(&["local"]);
        world.apply(system);
        Self {
            world,
            blocked: Blocked::new(),
        }
    }

    /// After the first apply has been carried out.
    pub fn running() -> Self {
        let mut story = Self::new();
        story.turn();
        assert!(story.plan().is_empty());
        story
    }

    /// After this one's first apply has been carried out.
    pub fn started(system: StoredSystem) -> Self {
        let mut story = Self::of(system);
        story.turn();
        assert!(story.plan().is_empty(), "{}", story.plan());
        story
    }

    pub fn plan(&self) -> Plan {
        let (desired, observed) = (self.world.desired(), self.world.observed());
        plan(&desired, &observed, &self.blocked)
    }

    /// Plans, tells, and carries out.
    pub fn turn(&mut self) -> String {
        let plan = self.plan();
        let chance = Chance {
            pick: &mut |_| 0,
            fails: &mut |_| false,
        };
        let run = self
            .world
            .execute(&plan, chance)
            .expect("no rule is broken");
        assert!(run.failed.is_empty());
        tell(&plan)
    }

    /// Plans until there is nothing to do, and tells the last turn.
    pub fn ends_well(&mut self) {
        for _ in 0..4 {
            if self.plan().is_empty() {
                return;
            }
            self.turn();
        }
        panic!("no end: {}", self.plan());
    }
}

/// The plan as people see it, then its steps.
pub fn tell(plan: &Plan) -> String {
    let mut text = render(plan);
    for step in &plan.steps {
        let (id, kind, target) = (step.id, step.work.kind(), &step.target);
        let _ = write!(text, "{id:>3} {kind:<13}{target}");
        match after(step) {
            after if after.is_empty() => {}
            after => {
                let _ = write!(text, "  after {after}");
            }
        }
        let _ = writeln!(text, "  ({})", step.reason);
    }
    if let Some(path) = critical_path(plan) {
        let _ = writeln!(text, "{path}");
    }
    text
}

/// The plan as people see it, and the drift as programs do.
pub fn tell_drift(plan: &Plan) -> String {
    let mut text = tell(plan);
    for drift in &plan.drift {
        let (kind, target, policy) = (drift.kind, &drift.target, drift.policy.as_str());
        let _ = write!(text, "drift {kind:?} {target} {policy}: {}", drift.reason);
        for field in &drift.fields {
            let side = |value: &Option<String>| value.clone().unwrap_or_else(|| "none".to_owned());
            let _ = write!(
                text,
                " {}={}->{}",
                field.field,
                side(&field.old),
                side(&field.new)
            );
        }
        text.push('\n');
    }
    text
}
