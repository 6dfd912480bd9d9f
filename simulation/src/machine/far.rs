//! Connectors between machines: who is where, and the end of one, as the other end's machine sees it.
//!
//! A process is known by its number everywhere, as each machine has numbers of its own. What closes an end on one machine
//! is told to the other one at once; a cable between them carries the questions of agents, not samples.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Weak};

use super::state::{At, Parting, State};
use super::{Shared, SimMachine};
use crate::truth::{Cause, Happened};

/// Bits of a number that count what is on one machine.
const OWN: u32 = 40;

/// The machines of a world. Each knows all of them.
#[derive(Debug, Default)]
pub(super) struct Neighbours {
    by_number: BTreeMap<u64, Weak<Shared>>,
    by_node: BTreeMap<String, u64>,
}

/// An end was closed, and its other end is on another machine.
#[derive(Debug)]
pub(super) struct Parted {
    /// Process of the other end.
    pub peer: u64,
    /// Name.
    pub connector: String,
    /// Number of the connector.
    pub number: u64,
    pub parting: Parting,
    /// Why it was closed.
    pub cause: Cause,
    /// Why its peer lost it.
    pub lost: Cause,
    /// Instance of the out-port when that was closed; none when the in-port was.
    pub source: Option<String>,
}

impl SimMachine {
    /// From now on connectors go from each of these machines to each other.
    pub fn connect<'a>(machines: impl Iterator<Item = &'a SimMachine>) {
        let machines: Vec<_> = machines.map(|machine| &machine.0).collect();
        let mut all = Neighbours::default();
        for (number, shared) in (1..).zip(&machines) {
            let node = shared.change(|state| {
                state.numbers = number << OWN;
                state.node.clone()
            });
            all.by_node.insert(node, number);
            all.by_number.insert(number, Arc::downgrade(shared));
        }
        let all = Arc::new(all);
        for shared in machines {
            // They are connected once, when the world is made.
            let _ = shared.neighbours.set(all.clone());
        }
    }
}

impl Shared {
    /// The machine with a process or connector of this number.
    fn elsewhere(&self, number: u64) -> Option<Arc<Shared>> {
        let all = self.neighbours.get()?;
        all.by_number.get(&(number >> OWN))?.upgrade()
    }

    /// The machine with a run folder (`…/run/<node>/<id>`): this one when it is of no other node.
    pub(super) fn owner(self: &Arc<Self>, folder: &Path) -> Arc<Shared> {
        let node = folder.parent().and_then(Path::file_name);
        let node = node.and_then(|node| node.to_str());
        let number = node.and_then(|node| self.neighbours.get()?.by_node.get(node));
        let other = number.and_then(|number| self.elsewhere(number << OWN));
        other.unwrap_or_else(|| self.clone())
    }

    /// Tells other machines what was closed here.
    pub(super) fn tell(&self, parted: Vec<Parted>) {
        for parted in parted {
            if let Some(other) = self.elsewhere(parted.peer) {
                other.change(|state| state.part(&parted));
            }
        }
    }
}

impl State {
    /// True for a number of another machine.
    pub(super) fn is_elsewhere(&self, number: u64) -> bool {
        number >> OWN != self.numbers >> OWN
    }

    /// The other end of a connector, on another machine, was closed.
    fn part(&mut self, parted: &Parted) {
        match &parted.source {
            Some(source) => self.source_gone(parted, source),
            None => self.target_gone(parted),
        }
    }

    /// An in-port end of this machine has lost its source, or was told good-bye.
    pub(super) fn source_gone(&mut self, parted: &Parted, source: &str) {
        let name = &parted.connector;
        let Some(process) = self.processes.get_mut(&parted.peer) else {
            return;
        };
        let Some(end) = process.ends.get_mut(name) else {
            return;
        };
        let its = end.source.as_mut();
        let Some(its) = its.filter(|s| s.number == parted.number && s.closed.is_none()) else {
            return;
        };
        its.closed = Some(parted.parting);
        let target = At {
            process: parted.peer,
            instance: end.binding.instance.clone(),
            incarnation: end.incarnation.clone(),
        };
        let told = format!("its source {source} has gone");
        process.changed(format!("connector/{name}"), told, None);
        if parted.parting == Parting::Loss {
            self.lose(&target, name, parted.lost);
        }
    }

    /// An out-port end of this machine has lost its target, or was told good-bye.
    pub(super) fn target_gone(&mut self, parted: &Parted) {
        let (name, peer) = (&parted.connector, parted.peer);
        let Some(process) = self.processes.get_mut(&peer) else {
            return;
        };
        let mut components = process.components.values();
        let at = components.find_map(|component| {
            let connector = component.connectors.get(name)?;
            (connector.number == parted.number).then(|| component.at(peer))
        });
        let Some(at) = at else {
            return;
        };
        let Some((of, ..)) = self.shut(peer, &at.instance, name, parted.parting) else {
            return;
        };
        self.news.push(Happened::Disconnected {
            of,
            connector: name.clone(),
            cause: parted.cause,
        });
        if let Some(process) = self.living(peer) {
            let told = "disconnected: the other end closed the connection".to_owned();
            process.changed(format!("connector/{name}"), told, None);
        }
        if parted.parting == Parting::Loss {
            self.lose(&at, name, parted.lost);
        }
    }
}
