//! What the parts of an agent share.

use std::path::PathBuf;
use std::sync::Arc;

use futures_util::future::BoxFuture;
use rts_agent_api::PROTOCOL_VERSION;
use rts_agent_api::messages::{NodeInfo, NodeSpecEnvelope, NodeSpecReceipt};
use rts_host::timing::TARGET;
use rts_http::problem::Problem;
use tokio::sync::{Mutex, Notify};
use tracing::{Instrument, info_span};

use crate::batches::Batches;
use crate::by_hand::Turns;
use crate::config::Config;
use crate::events::{Events, lock};
use crate::folders::{FolderError, Folders};
use crate::heal::{Alone, BackOff, Lease};
use crate::inputs::Inputs;
use crate::inventory::{Acted, Keeper};
use crate::ledger::{Fence, Ledger, LedgerError, Sealed};
use crate::managers::Managers;
use crate::modules::Modules;
use crate::policies::Policies;
use crate::restarts::Restarts;

/// An agent that cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Home or node name are not usable.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The ledger is not usable.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// Another agent runs.
    #[error("another agent of node {node} runs already: it holds {}", lock.display())]
    Running {
        /// Node name.
        node: String,
        /// The lock.
        lock: PathBuf,
    },
    /// A file cannot be used.
    #[error("cannot use {}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The HTTP client of the controller cannot be made.
    #[error("cannot make a client of the controller")]
    Client(#[source] rts_http::client::ClientError),
}

/// What ends once a spec that counts already is durable.
pub(crate) type Saving = BoxFuture<'static, Result<NodeSpecReceipt, Problem>>;

fn broken_off(error: &tokio::task::JoinError) -> Problem {
    Problem::internal(format!("the ledger's write failed: {error}"))
}

/// The state of an agent.
pub(crate) struct Agent {
    pub config: Config,
    pub folders: Folders,
    /// Unique id of this start.
    pub session: String,
    pub ledger: Mutex<Ledger>,
    /// Those of the ledger's spec.
    policies: std::sync::Mutex<Arc<Policies>>,
    pub inputs: Inputs,
    pub managers: Managers,
    pub modules: Modules,
    pub inventory: Keeper,
    pub restarts: Restarts,
    pub batches: Batches,
    pub events: Events,
    /// Revision of the inventory and generation of the spec for which marks of changes by hand were last compared.
    pub marks_checked: std::sync::Mutex<(u64, u64)>,
    /// Rings when the inventory may have changed of itself.
    pub dirty: Notify,
    /// Rings when a step, or the like, has changed it.
    pub acted: Acted,
    /// Whether a controller is there.
    pub lease: Lease,
    /// What it did while no controller was there.
    pub alone: Alone,
    /// What failed while no controller was there.
    pub failures: std::sync::Mutex<BackOff>,
    /// Held while a name for a component made by hand is chosen and taken.
    pub naming: Mutex<()>,
    /// Who changes which configuration.
    pub turns: Turns,
    /// Who connects or unbinds which connector.
    pub wiring: Turns,
}

impl Agent {
    /// Reads the ledger. The machine is this agent's alone: nobody else writes there.
    pub async fn new(config: Config, inputs: Inputs) -> Result<Self, StartError> {
        let folders = Folders::new(&config.home, &config.node)?;
        let (disk, machine) = (&inputs.disk, &inputs.machine);
        let ledger = Ledger::load(&config.node, &folders.state, disk.clone()).await?;
        let boot_id = machine.boot_id();
        let mut restarts = Restarts::load(disk.clone(), &folders.state, boot_id).await?;
        let mut policies = Policies::default();
        if let Some(sealed) = ledger.sealed() {
            let spec = &sealed.envelope().spec;
            policies = Policies::of_parts(spec, sealed.parts());
            restarts.keep(spec, &policies);
        }
        Ok(Self {
            session: inputs.chance.uuid(),
            ledger: Mutex::new(ledger),
            policies: std::sync::Mutex::new(Arc::new(policies)),
            managers: Managers::default(),
            modules: Modules::new(machine.clone()),
            inventory: Keeper::new(&config.node),
            restarts,
            batches: Batches::default(),
            events: Events::default(),
            marks_checked: Default::default(),
            dirty: Notify::new(),
            acted: Acted::default(),
            lease: Lease::default(),
            alone: Alone::default(),
            failures: Default::default(),
            naming: Mutex::new(()),
            turns: Turns::default(),
            wiring: Turns::default(),
            config,
            folders,
            inputs,
        })
    }

    /// Who it is.
    pub fn info(&self) -> NodeInfo {
        NodeInfo {
            node: self.config.node.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            protocol_version: PROTOCOL_VERSION,
            session: self.session.clone(),
            pid: std::process::id(),
        }
    }

    /// Accepts or refuses a NodeSpec; a newer one cancels the steps of older batches that have not started. It counts when
    /// this returns; what is given ends once it is durable. Both go on when the caller gives up: what is on disk and what
    /// is in memory must not come to differ.
    pub async fn offer_node_spec(self: &Arc<Self>, offered: Sealed) -> Result<Saving, Problem> {
        let agent = self.clone();
        let accept = async move {
            let receipt = agent.accept_now(offered).await?;
            let saver = agent.ledger.lock().await.saver();
            let span = info_span!(target: TARGET, "ledger");
            let save = async move { saver.save().await.map(|()| receipt) };
            Ok(tokio::spawn(save.instrument(span)))
        };
        let span = info_span!(target: TARGET, "accept");
        let accepted = tokio::spawn(accept.instrument(span)).await;
        let saving = accepted.unwrap_or_else(|e| Err(broken_off(&e)))?;
        Ok(Box::pin(async move {
            saving.await.unwrap_or_else(|e| Err(broken_off(&e)))
        }))
    }

    /// The same; durable when it returns.
    pub async fn put_node_spec(
        self: &Arc<Self>,
        offered: Sealed,
    ) -> Result<NodeSpecReceipt, Problem> {
        self.offer_node_spec(offered).await?.await
    }

    async fn accept_now(self: &Arc<Self>, offered: Sealed) -> Result<NodeSpecReceipt, Problem> {
        // Held to the end: one after the other.
        let mut ledger = self.ledger.lock().await;
        if ledger.held().is_none() {
            self.refuse_stranger(offered.envelope())?;
        }
        let before = ledger.held().map(|held| held.spec.clone());
        let receipt = ledger.accept(offered).await?;
        if receipt.changed
            && let Some(sealed) = ledger.sealed()
        {
            let spec = &sealed.envelope().spec;
            let mut policies = Policies::of_parts(spec, sealed.parts());
            policies.keep_leaving(&self.policies(), |uid| self.managers.has(uid));
            let policies = Arc::new(policies);
            *lock(&self.policies) = policies.clone();
            self.keep_restarts(spec, before.as_ref(), &policies);
            // What was held may be free now.
            self.has_acted();
            self.batches.cancel_others(&Fence::of(sealed.envelope()));
            tracing::info!(generation = receipt.generation, "node spec accepted");
        }
        Ok(receipt)
    }

    /// What the ledger holds; durable when it returns.
    pub async fn node_spec(self: &Arc<Self>) -> Result<Arc<Sealed>, Problem> {
        let ledger = self.ledger.lock().await;
        let (held, saver) = (ledger.sealed().cloned(), ledger.saver());
        drop(ledger);
        let saved = tokio::spawn(async move { saver.save().await }).await;
        saved.unwrap_or_else(|e| Err(broken_off(&e)))?;
        held.ok_or_else(|| Problem::not_found("this node was told nothing yet"))
    }

    /// The policies of the ledger's spec, and of what leaves.
    pub fn policies(&self) -> Arc<Policies> {
        lock(&self.policies).clone()
    }

    /// Without a ledger, what runs tells whom the node obeys: whoever knows all systems of which managers live.
    fn refuse_stranger(&self, offered: &NodeSpecEnvelope) -> Result<(), Problem> {
        let knows = |uid: &str| offered.spec.systems.iter().any(|s| s.system.uid == uid);
        let mut unknown: Vec<String> = self
            .managers
            .all()
            .iter()
            .filter_map(|m| m.key.system.as_ref())
            .filter(|system| !knows(&system.uid))
            .map(|system| system.name.clone())
            .collect();
        unknown.dedup();
        if unknown.is_empty() {
            return Ok(());
        }
        Err(Problem::conflict(
            "foreign-cluster",
            format!(
                "node {} has lost its ledger and runs {}, which cluster {} does not know: stop it with `rtsctl down`, or let the controller that started it send its spec",
                self.config.node,
                unknown.join(", "),
                offered.cluster_uid
            ),
        ))
    }

    /// Instance names that the ledger wants, with their systems' names.
    pub async fn wanted_instances(&self) -> Vec<(String, String)> {
        let ledger = self.ledger.lock().await;
        let systems = ledger.held().map_or(&[][..], |held| &held.spec.systems);
        let of = |s: &rts_plan::desired::NodeSystem| {
            let system = s.system.name.clone();
            let names = s.components.iter().map(|c| c.spec.instance.clone());
            names.map(move |n| (n, system.clone())).collect::<Vec<_>>()
        };
        systems.iter().flat_map(of).collect()
    }
}
