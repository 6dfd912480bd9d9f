//! Reset and Activate.

use super::Bringer;
use crate::graph::{Gate, NewStep};
use crate::index::{Id, Live};
use crate::observed::LifeCycleState;
use crate::order::{Order, Standing};
use crate::plan::Work;
use crate::target;

impl<'a> Bringer<'_, '_, 'a> {
    pub(super) fn reset(&mut self, id: Id<'a>) {
        let want = &self.facts.wants[&id];
        let live = &self.facts.lives[self.decisions.present[&id]];
        let error = live.component.state == LifeCycleState::Error;
        if !error || self.up.waits.contains_key(&id) {
            return;
        }
        let message = live.component.message.as_deref();
        let message = message.unwrap_or("no reason was given");
        if !want.placed.spec.policy.reset_on_error {
            let wait = format!("in Error: {message} (rtsctl.resetOnError is off)");
            self.up.waits.insert(id, wait);
            return;
        }
        let target = target::component(id.instance);
        if let Some(why) = self.blocked.get(&target::on(want.node, &target)) {
            self.up.waits.insert(id, why.clone());
            return;
        }
        let reset = self.steps.add(NewStep {
            node: want.node,
            target,
            system: Some(want.system),
            work: Work::Reset {
                manager: want.key.clone(),
                instance: id.instance.to_owned(),
            },
            reason: format!("is in Error: {message}"),
        });
        self.steps.need(reset, self.configures.get(&id).copied());
        self.up.resets.insert(id, reset);
    }

    pub(super) fn activate(&mut self) {
        for (uid, members) in self.facts.members() {
            let Some(system) = self.facts.orders.get(uid) else {
                continue;
            };
            let lists: [&[_]; 1] = [&system.orders.activation];
            Order::new("Activation", &lists, members)
                .walk(|instance, gate| self.activate_one(Id { uid, instance }, gate));
        }
    }

    fn activate_one(&mut self, id: Id<'a>, gate: Gate) -> Standing {
        let live = self.decisions.present.get(&id);
        let live = live.map(|live| &self.facts.lives[*live]);
        let idle = self.links.idle.get(&id);
        let active =
            |l: &&Live<'a>| l.component.state == LifeCycleState::Active && l.manager.responsive;
        if live.filter(active).is_some() && !idle.is_some_and(|idle| idle.certain) {
            return Standing::Done;
        }
        if self.up.waits.contains_key(&id) {
            return Standing::Waits;
        }
        let target = target::component(id.instance);
        let want = &self.facts.wants[&id];
        let blocked = target::on(want.node, &target);
        let problem = gate.waits.as_ref().or_else(|| self.blocked.get(&blocked));
        let problem = problem.or(idle.map(|idle| &idle.reason));
        if let Some(problem) = problem {
            self.up.waits.insert(id, problem.clone());
            return Standing::Waits;
        }
        let reason = match live {
            None => "is to be Active",
            Some(live) if live.component.state == LifeCycleState::Error => "was reset",
            Some(_) => "is not Active",
        };
        let step = self.steps.add(NewStep {
            node: want.node,
            target,
            system: Some(want.system),
            work: Work::Activate {
                manager: want.key.clone(),
                instance: id.instance.to_owned(),
            },
            reason: reason.to_owned(),
        });
        self.steps.gate(step, gate);
        let connects = self.connects.get(&id).cloned().unwrap_or_default();
        if connects.is_empty() {
            self.steps.need(step, self.creates.get(&id).copied());
        }
        self.steps.need(step, connects);
        let reset = self.up.resets.get(&id).or(self.configures.get(&id));
        self.steps.need(step, reset.copied());
        self.up.activates.insert(id, step);
        Standing::Steps(vec![step])
    }

    /// Where the profile is silent, what a source feeds is asked to start before the source, so that no sample is lost.
    pub(super) fn prefer_down_stream_first(&mut self) {
        for ((uid, _), (_, connector)) in &self.facts.links {
            let step = |instance| self.up.activates.get(&Id { uid, instance }).copied();
            let source = step(connector.spec.source.instance.as_str());
            let target = step(connector.spec.target.instance.as_str());
            if let (Some(source), Some(target)) = (source, target) {
                self.steps.prefer(source, target);
            }
        }
    }
}
