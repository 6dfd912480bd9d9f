//! What a component does when a connector's other end is lost (`rtsctl.onDisconnect`). It is decided and done here, with
//! nobody else alive, on the thread of its execution context.
//!
//! One that is Active acts at once. One that is not stays so: the end of the connector itself remembers that it was lost,
//! and while it does, the component is not activated. So an order to activate it that was given before the loss comes
//! too late. The end is well again when it is connected again, and no more when it is disconnected or unbound.

use std::time::{Duration, Instant};

use rts_manager_api::control::{Failure, FailureCode};
use rts_schemas::system::OnDisconnect;

use super::lifecycle::Transition;
use super::member::Member;
use super::{Component, Order, State};
use crate::events::Events;
use crate::failure::{failure, invalid};
use crate::log::Level;
use crate::sync::lock;

/// What could not be done by then is told; it is still done as soon as it can be.
const DEADLINE: Duration = Duration::from_secs(10);
/// The event of a loss that was acted on.
const PEER_LOST: &str = "PeerLost";

/// A loss that a component has still to act on.
#[derive(Debug, Clone)]
pub struct Loss {
    connector: String,
    policy: OnDisconnect,
    since: Instant,
    /// It was told that it takes too long.
    told: bool,
}

impl Loss {
    fn reason(&self) -> String {
        reason(&self.connector, self.policy)
    }
}

fn reason(connector: &str, policy: OnDisconnect) -> String {
    let policy = name(policy);
    format!("connector {connector} lost its other end (rtsctl.onDisconnect: {policy})")
}

/// Reads a policy of the protocol.
pub fn policy(text: &str) -> Result<OnDisconnect, Failure> {
    [
        OnDisconnect::Keep,
        OnDisconnect::Deactivate,
        OnDisconnect::Stop,
    ]
    .into_iter()
    .find(|policy| name(*policy) == text)
    .ok_or_else(|| {
        invalid(format!(
            "onDisconnect cannot be `{text}`; use keep, deactivate or stop"
        ))
    })
}

/// Name of a policy in the protocol.
pub fn name(policy: OnDisconnect) -> &'static str {
    match policy {
        OnDisconnect::Keep => "keep",
        OnDisconnect::Deactivate => "deactivate",
        OnDisconnect::Stop => "stop",
    }
}

impl Component {
    /// A connector of it lost its other end. Never blocks.
    pub fn lose(&self, connector: &str) {
        let policy = lock(&self.status).on_disconnect;
        if policy == OnDisconnect::Keep {
            return;
        }
        lock(&self.loss).get_or_insert_with(|| Loss {
            connector: connector.to_owned(),
            policy,
            since: Instant::now(),
            told: false,
        });
        // Without room its thread has requests to obey, and looks before each.
        let _ = self.context.tell(Order::Attend);
    }

    /// Tells once of a loss that is not acted on in time, since a callback hangs.
    pub fn look_after_loss(&self, events: &Events) {
        let mut loss = lock(&self.loss);
        let Some(loss) = loss
            .as_mut()
            .filter(|loss| !loss.told && loss.since.elapsed() >= DEADLINE)
        else {
            return;
        };
        loss.told = true;
        let late = self.late("was busy").message;
        let message = format!("cannot obey: {late}; {}", loss.reason());
        self.log.write(Level::Error, &message);
        lock(&self.status).message = Some(message.clone());
        events.told(self.target(), PEER_LOST, message);
    }
}

impl Member<'_> {
    /// Refuses when it must not be Active, since a connector of it is lost.
    pub fn check_peers(&self) -> Result<(), Failure> {
        let component = &self.component;
        let policy = lock(&component.status).on_disconnect;
        if policy == OnDisconnect::Keep {
            return Ok(());
        }
        let incarnation = &component.identity.incarnation;
        let lost = component
            .lost_connector()
            .or_else(|| self.manager.bindings.lost_of(incarnation));
        lost.map_or(Ok(()), |connector| {
            let reason = reason(&connector, policy);
            let message = format!(
                "{}: {reason}; it can be activated when that connector is connected again or removed",
                component.identity.instance
            );
            Err(failure(FailureCode::ComponentFailed, message))
        })
    }

    /// Acts on a loss, if there is one. True when the component is to be stopped for it.
    pub fn attend(&mut self) -> bool {
        let Some(loss) = lock(&self.component.loss).clone() else {
            return false;
        };
        let stops = loss.policy == OnDisconnect::Stop;
        if stops {
            self.tell_loss(&format!("stopped: {}", loss.reason()));
        } else {
            self.component.log.write(Level::Warn, &loss.reason());
            // A callback that fails leads to Error, with its own reason.
            if self.component.state() == State::Active
                && self.transition(Transition::Deactivate).is_ok()
            {
                self.tell_loss(&format!("deactivated: {}", loss.reason()));
            }
        }
        *lock(&self.component.loss) = None;
        stops
    }

    fn tell_loss(&self, message: &str) {
        self.component.log.write(Level::Warn, message);
        lock(&self.component.status).message = Some(message.to_owned());
        let target = self.component.target();
        self.manager
            .events
            .told(target, PEER_LOST, message.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_policy_names_the_known_ones() {
        assert_eq!(policy("stop").unwrap(), OnDisconnect::Stop);
        assert_eq!(
            policy("fly").unwrap_err().message,
            "onDisconnect cannot be `fly`; use keep, deactivate or stop"
        );
    }
}
