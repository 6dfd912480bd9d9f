//! Reset and Activate.

use rts_schemas::system::OnDisconnect;

use super::Bringer;
use crate::drift;
use crate::graph::{Gate, NewStep};
use crate::index::{Id, Live};
use crate::observed::LifeCycleState;
use crate::order::Standing;
use crate::plan::Work;
use crate::target;

impl<'a> Bringer<'_, '_, 'a> {
    pub(super) fn reset(&mut self, id: Id<'a>, gate: Gate) -> Standing {
        let live = self.decisions.present.get(&id);
        let live = live.map(|live| &self.facts.lives[*live]);
        let error = |live: &&Live<'a>| live.component.state == LifeCycleState::Error;
        let Some(live) = live.filter(error) else {
            // What cannot be seen may be in Error.
            let node = self.facts.wants[&id].node;
            return match live.is_none() && self.facts.unknown.contains_key(node) {
                true => Standing::Waits,
                false => Standing::Done,
            };
        };
        if self.up.waits.contains_key(&id) {
            return Standing::Waits;
        }
        let want = &self.facts.wants[&id];
        let target = target::component(id.instance);
        let message = live.component.message.as_deref();
        let message = message.unwrap_or("no reason was given");
        let blocked = target::why_blocked(self.blocked, want.node, || target.clone());
        let problem = match want.placed.spec.policy.reset_on_error {
            true => blocked.or(gate.waits.as_ref()).cloned(),
            false => Some(format!("in Error: {message} (rtsctl.resetOnError is off)")),
        };
        if let Some(problem) = problem {
            self.up.waits.insert(id, problem);
            return Standing::Waits;
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
        self.steps.gate(reset, gate);
        self.steps.need(reset, self.configures.get(&id).copied());
        self.up.resets.insert(id, reset);
        Standing::Steps(vec![reset])
    }

    pub(super) fn activate(&mut self, id: Id<'a>, gate: Gate) -> Standing {
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
        if live.is_some_and(|live| drift::left_inactive(want.placed, live.component)) {
            return Standing::WaitsAs("was deactivated by hand".into());
        }
        let blocked = || target::why_blocked(self.blocked, want.node, || target.clone());
        let problem = gate.waits.as_ref().or_else(blocked);
        let problem = problem.or(idle.map(|idle| &idle.reason));
        if let Some(problem) = problem {
            self.up.waits.insert(id, problem.clone());
            return Standing::Waits;
        }
        let reason = match live {
            None => "is to be Active",
            Some(live) if live.component.state == LifeCycleState::Error => "was reset",
            Some(live) if drift::deactivated(live.component) => "was deactivated by hand",
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
        // A component that must have all its peers is refused while the end of one that left is still at its in-port.
        if want.on_disconnect() != OnDisconnect::Keep {
            let ends = self.down.left_ends.iter();
            let own = ends.filter(|end| self.facts.lives[end.live].id() == Some(id));
            self.steps.need(step, own.filter_map(|end| end.removed));
        }
        let reset = self.up.resets.get(&id).or(self.configures.get(&id));
        self.steps.need(step, reset.copied());
        self.up.activates.insert(id, step);
        Standing::Steps(vec![step])
    }
}
