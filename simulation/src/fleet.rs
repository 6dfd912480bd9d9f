//! Who is reached over the network: the agents that live now, by the controller; the controller that lives now, by agents
//! and users.

mod agent;
mod batch;
mod controller;
mod peers;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rts_agent::LocalAgent;
use rts_agent_api::ClientError;
use rts_controller::Core;
use rts_controller::fleet::{Agent, Fleet};

use crate::life::Life;
use crate::net::{Net, Reset};
use crate::truth::Truth;

pub use self::controller::{SimSession, SimUser};
pub use self::peers::SimPeers;

/// Who serves where. Clones are the same.
#[derive(Clone)]
pub struct Hosts(Arc<Inner>);

struct Inner {
    net: Net,
    truth: Truth,
    serving: Mutex<Serving>,
}

#[derive(Default)]
struct Serving {
    agents: BTreeMap<String, Node>,
    controller: Option<(Life, Arc<Core>)>,
}

/// An agent that serves.
#[derive(Clone)]
struct Node {
    life: Life,
    api: LocalAgent,
    /// Plans whose steps are told by somebody already.
    told: Arc<Mutex<BTreeSet<String>>>,
}

impl Hosts {
    /// Nobody serves yet.
    pub fn new(net: Net, truth: Truth) -> Self {
        Self(Arc::new(Inner {
            net,
            truth,
            serving: Mutex::default(),
        }))
    }

    /// An agent serves from now on, in the place of whoever did.
    pub fn agent_serves(&self, life: &Life, api: LocalAgent) {
        let node = Node {
            life: life.clone(),
            api,
            told: Arc::default(),
        };
        self.serving().agents.insert(life.host().to_owned(), node);
    }

    /// A controller serves from now on, in the place of whoever did; but for one that was replaced while it came up.
    pub fn controller_serves(&self, life: &Life, core: &Arc<Core>) {
        let mut serving = self.serving();
        let newer = |(other, _): &(Life, _)| other.number() > life.number() && !other.is_over();
        if !serving.controller.as_ref().is_some_and(newer) {
            serving.controller = Some((life.clone(), Arc::clone(core)));
        }
    }

    /// The controller serves nobody any more, though it may go on.
    pub fn controller_leaves(&self) {
        self.serving().controller = None;
    }

    /// The controller that serves now.
    pub fn controller(&self) -> Option<Arc<Core>> {
        let serving = self.serving();
        let (life, core) = serving.controller.as_ref()?;
        (!life.is_over()).then(|| Arc::clone(core))
    }

    /// The agent of a node that serves now.
    pub fn agent(&self, node: &str) -> Option<LocalAgent> {
        self.node(node).map(|node| node.api)
    }

    /// Nobody serves any more. Who serves knows everybody else: without this, nothing of a run would ever be freed.
    pub fn close(&self) {
        *self.serving() = Serving::default();
    }

    fn node(&self, node: &str) -> Option<Node> {
        let node = self.serving().agents.get(node).cloned();
        node.filter(|node| !node.life.is_over())
    }

    fn controller_of(&self) -> Option<(Life, Arc<Core>)> {
        let controller = self.serving().controller.clone();
        controller.filter(|(life, _)| !life.is_over())
    }

    fn serving(&self) -> MutexGuard<'_, Serving> {
        self.0
            .serving
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// Agents as one life of the controller reaches them.
pub struct SimFleet {
    hosts: Hosts,
    life: Life,
}

impl SimFleet {
    /// For a life of the controller.
    pub fn new(hosts: &Hosts, life: &Life) -> Self {
        Self {
            hosts: hosts.clone(),
            life: life.clone(),
        }
    }
}

impl Fleet for SimFleet {
    fn agent(&self, node: &str, endpoint: &str) -> Result<Arc<dyn Agent>, ClientError> {
        Ok(Arc::new(agent::Remote {
            hosts: self.hosts.clone(),
            life: self.life.clone(),
            node: node.to_owned(),
            endpoint: endpoint.to_owned(),
        }))
    }
}

/// What a client says of a connection that was refused or reset.
fn unreachable(socket: &str, _: Reset) -> ClientError {
    ClientError::Unreachable {
        socket: PathBuf::from(socket),
        reason: "connection reset".to_owned(),
    }
}

/// What a client says of an answer that does not come.
fn too_late(socket: &str) -> ClientError {
    ClientError::Unreachable {
        socket: PathBuf::from(socket),
        reason: "operation timed out".to_owned(),
    }
}
