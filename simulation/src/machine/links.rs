//! The end of connectors, seen from either of their ends.

use super::far::Parted;
use super::state::{At, Link, Parting, Process, State};
use crate::truth::{Cause, Happened, Subject};

impl State {
    /// Closes a connector from its out-port end, and forgets it.
    pub fn remove_connector(&mut self, at: &At, name: &str, parting: Parting, cause: Cause) {
        self.close_connector(at, name, parting, cause);
        if let Some(component) = self.component(at) {
            component.connectors.remove(name);
        }
    }

    /// Closes a connector from its out-port end, whose process may have ended.
    pub fn close_connector(&mut self, at: &At, name: &str, parting: Parting, cause: Cause) {
        let Some((of, number, link)) = self.shut(at.process, &at.instance, name, parting) else {
            return;
        };
        let Link::Open(peer) = link else {
            return;
        };
        let connector = name.to_owned();
        let source = of.instance.clone();
        self.news.push(Happened::Disconnected {
            of,
            connector,
            cause,
        });
        let parted = Parted {
            peer,
            connector: name.to_owned(),
            number,
            parting,
            cause,
            lost: self.cause_of_loss(at.process, cause),
            source: Some(source.clone()),
        };
        if self.is_elsewhere(peer) {
            self.parted.push(parted);
        } else {
            self.source_gone(&parted, &source);
        }
    }

    /// Closes the out-port end alone; gives whose it was, its number, and how it was connected.
    pub(super) fn shut(
        &mut self,
        process: u64,
        instance: &str,
        name: &str,
        parting: Parting,
    ) -> Option<(Subject, u64, Link)> {
        let process = self.processes.get_mut(&process)?;
        let component = process.components.get_mut(instance)?;
        let connector = component.connectors.get_mut(name)?;
        let link = std::mem::replace(&mut connector.link, Link::Closed(parting));
        Some((component.subject.clone(), connector.number, link))
    }

    /// Closes the connection of an in-port end, whose process may have ended.
    pub fn close_end(&mut self, number: u64, name: &str, parting: Parting, cause: Cause) {
        let end = self.processes.get_mut(&number);
        let end = end.and_then(|process| process.ends.get_mut(name));
        let source = end.and_then(|end| end.source.as_mut());
        let Some(source) = source.filter(|source| source.closed.is_none()) else {
            return;
        };
        source.closed = Some(parting);
        let (link, peer) = (source.number, source.process);
        let parted = Parted {
            peer,
            connector: name.to_owned(),
            number: link,
            parting,
            cause,
            lost: self.cause_of_loss(number, cause),
            source: None,
        };
        if self.is_elsewhere(peer) {
            self.parted.push(parted);
        } else {
            self.target_gone(&parted);
        }
    }

    /// Why a peer of something in this process lost it: asked for, when a sound process was ended by order.
    fn cause_of_loss(&self, number: u64, cause: Cause) -> Cause {
        let process = self.processes.get(&number);
        let asked = |p: &Process| p.ended == Some(Cause::Asked) && !p.blemished;
        match cause {
            Cause::Died if process.is_some_and(asked) => Cause::Asked,
            Cause::Asked => Cause::Asked,
            Cause::Fault | Cause::Died => Cause::Fault,
        }
    }

    /// Closes all ends of a component, and lets none be added.
    pub fn detach(&mut self, at: &At, parting: Parting, cause: Cause) {
        let Some(component) = self.component(at) else {
            return;
        };
        component.leaving = true;
        let connectors: Vec<String> = component.connectors.keys().cloned().collect();
        for connector in connectors {
            self.remove_connector(at, &connector, parting, cause);
        }
        let Some(process) = self.living(at.process) else {
            return;
        };
        let ends = process.ends.iter();
        let ends = ends.filter(|(_, end)| end.incarnation == at.incarnation);
        let ends: Vec<String> = ends.map(|(name, _)| name.clone()).collect();
        for end in ends {
            self.close_end(at.process, &end, parting, cause);
            if let Some(process) = self.living(at.process) {
                process.ends.remove(&end);
            }
        }
    }
}
