//! Which verb carries out which step, how long each may take, and what they share.

use std::sync::Arc;
use std::time::Duration;

use rts_manager_api::control::{Failure, FailureCode, SystemId};
use rts_plan::desired::{ManagerKey, SystemRef};
use rts_plan::plan::{Step, Work};

use super::{CarryOut, Carrying, component, connector, hang, manager, module, unbind};
use crate::agent::Agent;
use crate::ledger::Fence;
use crate::manager_link::LinkError;
use crate::managers::Manager;
use crate::policies::Policies;

/// A step that failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StepError {
    /// Its manager is not there.
    #[error(
        "manager {manager} does not run on node {node}; it may just have died: the next plan starts it again"
    )]
    NoManager {
        /// Display name.
        manager: String,
        /// Node name.
        node: String,
    },
    /// The manager refused or was silent.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The module is not usable.
    #[error(transparent)]
    Module(#[from] crate::modules::ModuleError),
    /// The manager cannot be started.
    #[error(transparent)]
    Start(#[from] crate::managers::StartManagerError),
    /// The manager cannot be stopped.
    #[error(transparent)]
    Stop(#[from] crate::managers::StopError),
    /// The agent of the node with the other end refused, or cannot be reached.
    #[error("node {node} does not let it come: {why}")]
    Peer {
        /// Node name.
        node: String,
        /// Why.
        why: Box<rts_agent_api::ClientError>,
    },
    /// A callback of its component does not return.
    #[error("{0}")]
    Hangs(String),
    /// It was not tried: that is no failure of its target.
    #[error("the node spec was replaced meanwhile; the next plan is for the new one")]
    Replaced,
    /// Anything else.
    #[error("{0}")]
    Refused(String),
}

impl StepError {
    /// The manager's own refusal, when that is what it is.
    pub fn failure(&self) -> Option<&Failure> {
        match self {
            StepError::Link(LinkError::Refused(failure)) => Some(failure),
            _ => None,
        }
    }

    /// True for a refusal with this code.
    pub fn is(&self, code: FailureCode) -> bool {
        self.failure().is_some_and(|f| f.code == code)
    }
}

/// Turns a refusal with a code into a success: it is so already.
pub(crate) fn unless(code: FailureCode, result: Result<(), LinkError>) -> Result<(), StepError> {
    match result.map_err(StepError::from) {
        Err(e) if e.is(code) => Ok(()),
        other => other,
    }
}

/// The real hands.
pub(crate) struct Hands {
    /// Whose.
    pub agent: Arc<Agent>,
    /// What the batch was made for.
    pub fence: Fence,
}

impl CarryOut for Hands {
    fn limit(&self, step: &Step) -> Duration {
        limit(step, &self.agent.policies())
    }

    fn work(&self, begins: bool) {
        self.agent.inputs.machine.work(begins);
    }

    fn carry_out(&self, step: Step, limit: Duration) -> Carrying {
        let verb = Verb {
            agent: self.agent.clone(),
            system: step.system,
            limit,
        };
        let (work, fence) = (step.work, self.fence.clone());
        Box::pin(async move {
            // A newer spec may just have come, and its word to cancel may still be on its way.
            let held = verb.agent.ledger.lock().await.fence();
            if held.as_ref() != Some(&fence) {
                return Err(StepError::Replaced);
            }
            let outcome = hang::carry_out(&verb, work).await;
            verb.agent.has_acted();
            outcome
        })
    }
}

/// How long a step may take.
pub(crate) fn limit(step: &Step, policies: &Policies) -> Duration {
    match &step.work {
        Work::Create { instance, .. } | Work::Activate { instance, .. } => {
            policies.start_timeout(step.system.as_ref(), instance)
        }
        work => usual_limit(work),
    }
}

/// How long a step may take unless a policy says otherwise.
pub(crate) fn usual_limit(work: &Work) -> Duration {
    Duration::from_secs(match work {
        Work::StartManager { .. }
        | Work::Connect { .. }
        | Work::Disconnect { .. }
        | Work::Unbind { .. } => 5,
        Work::Install { .. } | Work::LoadModule { .. } => 20,
        Work::StopManager { .. } => 12,
        Work::Create { .. }
        | Work::Configure { .. }
        | Work::Activate { .. }
        | Work::Deactivate { .. }
        | Work::Reset { .. }
        | Work::Delete { .. }
        | Work::UnloadModule { .. } => 10,
    })
}

/// What a verb works with.
pub(crate) struct Verb {
    pub agent: Arc<Agent>,
    pub system: Option<SystemRef>,
    pub limit: Duration,
}

impl Verb {
    pub(super) async fn carry_out(&self, work: Work) -> Result<(), StepError> {
        match work {
            Work::Install {
                type_name,
                module_digest,
            } => module::install(self, &type_name, module_digest.as_deref()).await,
            Work::LoadModule {
                manager,
                type_name,
                module_digest,
            } => module::load(self, &manager, &type_name, module_digest.as_deref()).await,
            Work::UnloadModule { manager, type_name } => {
                module::unload(self, &manager, type_name).await
            }
            Work::StartManager { manager } => manager::start(self, &manager).await,
            Work::StopManager {
                manager,
                incarnation,
            } => manager::stop(self, &manager, &incarnation).await,
            Work::Connect { connector } => connector::connect(self, connector).await,
            Work::Disconnect {
                manager,
                instance,
                connector,
            } => connector::disconnect(self, &manager, instance, connector).await,
            Work::Unbind {
                manager,
                instance,
                connector,
            } => unbind::unbind(self, &manager, &instance, connector).await,
            other => component::carry_out(self, other).await,
        }
    }

    /// A live manager.
    pub fn manager(&self, key: &ManagerKey) -> Result<Arc<Manager>, StepError> {
        self.agent
            .managers
            .get(key)
            .ok_or_else(|| StepError::NoManager {
                manager: key.display_name(),
                node: self.agent.config.node.clone(),
            })
    }

    /// A live manager, or none when it is gone and there is nothing to take down any more.
    pub fn manager_if_any(&self, key: &ManagerKey) -> Option<Arc<Manager>> {
        self.agent.managers.get(key)
    }
}

/// A system in the words of the control protocol.
pub(crate) fn system_id(system: &SystemRef) -> SystemId {
    SystemId {
        name: system.name.clone(),
        uid: system.uid.clone(),
    }
}
