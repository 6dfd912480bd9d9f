//! What a component does when a connector's other end is lost, by its policy: keep on, deactivate, or stop.

use std::time::Duration;

use rts_manager_api::control::{Failure, FailureCode};
use tokio::time::timeout;

use super::component::late;
use super::connection::refuse;
use super::handle::Handle;
use super::state::{At, LifeCycle, Loss, Parting, State};
use crate::truth::Cause;

/// What could not be done by then is told.
const DEADLINE: Duration = Duration::from_secs(10);
/// The event of a loss that was acted on.
const PEER_LOST: &str = "PeerLost";

/// Reads a policy.
pub(super) fn policy(text: Option<&str>) -> Result<Option<&str>, Failure> {
    match text {
        None | Some("keep" | "deactivate" | "stop") => Ok(text),
        Some(text) => {
            let message = format!("onDisconnect cannot be `{text}`; use keep, deactivate or stop");
            Err(refuse(FailureCode::Invalid, message))
        }
    }
}

fn reason(connector: &str, policy: &str) -> String {
    format!("connector {connector} lost its other end (rtsctl.onDisconnect: {policy})")
}

impl State {
    /// A connector of this component lost its other end, and nobody ordered that.
    pub fn lose(&mut self, at: &At, connector: &str, cause: Cause) {
        let stopping = self.living(at.process).is_none_or(|p| p.stopping);
        let Some(component) = self.component(at).filter(|_| !stopping) else {
            return;
        };
        if component.on_disconnect == "keep" || component.lost {
            return;
        }
        component.lost = true;
        let policy = component.on_disconnect.clone();
        let reason = reason(connector, &policy);
        if cause != Cause::Asked {
            self.blemish(at.process, Some(&at.instance), reason.clone());
        }
        self.losses.push(Loss {
            at: at.clone(),
            stops: policy == "stop",
            reason,
            cause,
        });
    }

    /// Why a component must not be Active; none when it may.
    pub fn why_lost(&mut self, at: &At) -> Option<String> {
        let component = self.component(at)?;
        let policy = component.on_disconnect.clone();
        if policy == "keep" {
            return None;
        }
        let mut connectors = component.connectors.values();
        let lost = connectors.find(|c| c.is_lost());
        let mut lost = lost.map(|c| c.request.connector.clone());
        if lost.is_none() {
            let is_lost = |s: &super::state::Source| s.closed == Some(Parting::Loss);
            let process = self.living(at.process)?;
            let mut ends = process.ends.values();
            let end = ends.find(|end| {
                end.incarnation == at.incarnation && end.source.as_ref().is_some_and(is_lost)
            });
            lost = end.map(|end| end.binding.connector.clone());
        }
        let reason = reason(&lost?, &policy);
        Some(format!(
            "{reason}; it can be activated when that connector is connected again or removed"
        ))
    }
}

impl Handle {
    /// Acts on a loss, in its turn.
    pub async fn attend(self, loss: Loss) {
        let Loss {
            at,
            stops,
            reason,
            cause,
        } = loss;
        let turn = self.turn(&at);
        tokio::pin!(turn);
        let turn = match timeout(DEADLINE, &mut turn).await {
            Ok(turn) => turn,
            Err(_) => {
                let late = late(&self, &at, "was busy").message;
                self.tell_loss(&at, format!("cannot obey: {late}; {reason}"));
                turn.await
            }
        };
        let Some(_turn) = turn else {
            return;
        };
        if stops {
            self.tell_loss(&at, format!("stopped: {reason}"));
            self.delete(&at, Parting::Loss, cause).await;
            self.told(&at, "was deleted after the loss of a peer".to_owned());
            return;
        }
        let active = self.component(&at, |c| c.state == LifeCycle::Active);
        if active == Some(true) && self.deactivate(&at, cause).await.is_ok() {
            self.tell_loss(&at, format!("deactivated: {reason}"));
        }
        self.component(&at, |component| component.lost = false);
    }

    fn tell_loss(&self, at: &At, message: String) {
        self.component(at, |c| c.message = Some(message.clone()));
        let target = format!("component/{}", at.instance);
        self.with(|process| process.changed(target, message, Some(PEER_LOST)));
    }
}
