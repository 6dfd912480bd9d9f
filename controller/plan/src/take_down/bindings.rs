//! In-port ends that nobody wants any more.
//!
//! The end of a connector stays at its in-port when its source goes, until it is unbound: of what a Disconnect reaches
//! it is a part, and what is left is unbound by itself.

use rustc_hash::FxHashMap;

use super::Taker;
use crate::decide::Fate;
use crate::graph::{Ix, NewStep};
use crate::index::{Facts, Id, Live};
use crate::observed::BindingObserved;
use crate::plan::Work;
use crate::target;

/// An in-port end that has to go.
#[derive(Debug)]
pub(crate) struct LeftEnd<'a> {
    /// Whose it is, by index into `Facts::lives`.
    pub live: usize,
    pub binding: &'a BindingObserved,
    pub reason: String,
    /// Why it cannot be removed now.
    pub blocked: Option<String>,
    /// The step that removes it.
    pub removed: Option<Ix>,
}

impl<'a> Taker<'_, '_, 'a> {
    /// Unbinds what no desired connector asks for and no connector that stays has. One that somebody is connected to
    /// whom nobody sees is left alone.
    pub(super) fn bindings(&mut self) {
        let unwanted = self.unwanted();
        if unwanted.is_empty() {
            return;
        }
        let owners = owners(self.facts);
        for (ix, binding) in unwanted {
            let live = &self.facts.lives[ix];
            let end = (
                binding.connector.as_str(),
                live.component.incarnation.as_str(),
            );
            let (after, reason) = match owners.get(&end) {
                None if binding.connected => continue,
                None => (None, left_behind(live, binding)),
                Some(source) => match self.ends_before(*source, live) {
                    Some(gone) => {
                        let name = &self.facts.lives[*source].component.instance;
                        (Some(gone), format!("ends with its source {name}"))
                    }
                    // What cuts the connector unbinds it too, and what is left then is seen.
                    None => continue,
                },
            };
            self.unbind(ix, binding, after, reason);
        }
    }

    /// The ends of components that stay, but for those of desired connectors.
    fn unwanted(&self) -> Vec<(usize, &'a BindingObserved)> {
        let mut unwanted = Vec::new();
        for (ix, live) in self.facts.lives.iter().enumerate() {
            let component = live.component;
            let Some(id) = live.id().filter(|_| !component.bindings.is_empty()) else {
                continue;
            };
            let stays = self.decisions.fates[ix] == Fate::Keep && !self.down.gone.contains_key(&ix);
            if stays && live.manager.responsive && self.facts.nodes.contains(live.node) {
                let ends = component.bindings.iter();
                let own = ends.filter(|binding| !is_desired(self.facts, id, binding));
                unwanted.extend(own.map(|binding| (ix, binding)));
            }
        }
        unwanted
    }

    /// The step after which the source of a connector is gone. Of another system's nothing is said before it is.
    fn ends_before(&self, source: usize, target: &Live<'a>) -> Option<Ix> {
        let system = &self.facts.lives[source].component.system;
        let gone = self.down.gone.get(&source).copied();
        gone.filter(|_| *system == target.component.system)
    }

    fn unbind(
        &mut self,
        ix: usize,
        binding: &'a BindingObserved,
        after: Option<Ix>,
        reason: String,
    ) {
        let live = &self.facts.lives[ix];
        let name = target::connector(&binding.connector);
        let blocked = self.blocked.get(&target::on(live.node, &name)).cloned();
        let mut removed = None;
        if blocked.is_none() {
            let step = self.steps.add(NewStep {
                node: live.node,
                target: name,
                system: live.component.system.as_ref(),
                work: Work::Unbind {
                    manager: live.manager.key.clone(),
                    instance: live.component.instance.clone(),
                    connector: binding.connector.clone(),
                },
                reason: reason.clone(),
            });
            self.steps.need(step, after);
            removed = Some(step);
            let uid = live.id().map_or("", |id| id.uid);
            if let Some(key) = self.facts.link(uid, &binding.connector) {
                self.down.unbound.or_default(key).push(step);
            }
        }
        self.down.left_ends.push(LeftEnd {
            live: ix,
            binding,
            reason,
            blocked,
            removed,
        });
    }
}

/// True for the end of a desired connector to this component.
fn is_desired<'a>(facts: &Facts<'a>, id: Id<'a>, binding: &BindingObserved) -> bool {
    let key = facts.link(id.uid, &binding.connector);
    let link = key.and_then(|key| facts.links.get(&key));
    link.is_some_and(|link| link.ends[1] == id && link.connector.spec.target.port == binding.port)
}

/// Who has the other end: connector and incarnation of the target → the source, by index into `Facts::lives`.
fn owners<'a>(facts: &Facts<'a>) -> FxHashMap<(&'a str, &'a str), usize> {
    let lives = facts.lives.iter().enumerate();
    let ends = lives.flat_map(|(ix, live)| {
        let connectors = live.component.connectors.iter();
        connectors.map(move |c| ((c.name.as_str(), c.target_incarnation.as_str()), ix))
    });
    ends.collect()
}

fn left_behind(live: &Live<'_>, binding: &BindingObserved) -> String {
    let (instance, port) = (&live.component.instance, &binding.port);
    format!("its end at {instance}.{port} was left behind")
}
