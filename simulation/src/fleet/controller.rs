//! The controller as agents and users reach it.

use std::sync::Arc;
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent_api::ClientError;
use rts_agent_api::session::{Heartbeat, SessionApi, SessionGreeting, SessionReply};
use rts_controller::Core;
use rts_controller_api::Problem;
use tokio::time::timeout;

use super::{Hosts, too_late, unreachable};
use crate::life::Life;

/// As the agent's client has it.
const REQUEST: Duration = Duration::from_secs(1);
/// As the client of rtsctl has it.
const USER: Duration = Duration::from_secs(30);
/// What errors name.
const SOCKET: &str = "/sim/controller.sock";

impl Hosts {
    async fn ask_controller<T: Send + 'static>(
        &self,
        caller: &Life,
        limit: Duration,
        work: impl Fn(Arc<Core>) -> BoxFuture<'static, Result<T, Problem>> + Send + 'static,
    ) -> Result<T, ClientError> {
        let hosts = self.clone();
        let serve = Box::new(move || {
            let (life, core) = hosts.controller_of()?;
            Some((life, work(core)))
        });
        match timeout(limit, self.0.net.ask(caller, "controller", serve)).await {
            Ok(Ok(answer)) => Ok(answer?),
            Ok(Err(reset)) => Err(unreachable(SOCKET, reset)),
            Err(_) => Err(too_late(SOCKET)),
        }
    }
}

/// The controller, for a life of an agent.
pub struct SimSession {
    hosts: Hosts,
    life: Life,
}

impl SimSession {
    /// For a life of an agent.
    pub fn new(hosts: &Hosts, life: &Life) -> Self {
        Self {
            hosts: hosts.clone(),
            life: life.clone(),
        }
    }
}

impl SessionApi for SimSession {
    fn greet<'a>(
        &'a self,
        greeting: &'a SessionGreeting,
    ) -> BoxFuture<'a, Result<SessionReply, ClientError>> {
        let (node, greeting) = (self.life.host().to_owned(), greeting.clone());
        let work = move |core: Arc<Core>| -> BoxFuture<'static, _> {
            let (node, greeting) = (node.clone(), greeting.clone());
            Box::pin(async move { rts_controller::greet(&core, &node, greeting) })
        };
        Box::pin(self.hosts.ask_controller(&self.life, REQUEST, work))
    }

    fn heartbeat<'a>(
        &'a self,
        session: &'a str,
        heartbeat: &'a Heartbeat,
    ) -> BoxFuture<'a, Result<(), ClientError>> {
        let (node, session) = (self.life.host().to_owned(), session.to_owned());
        let heartbeat = heartbeat.clone();
        let work = move |core: Arc<Core>| -> BoxFuture<'static, _> {
            let (node, session) = (node.clone(), session.clone());
            let heartbeat = heartbeat.clone();
            Box::pin(async move { rts_controller::heartbeat(&core, &node, &session, heartbeat) })
        };
        Box::pin(self.hosts.ask_controller(&self.life, REQUEST, work))
    }
}

/// The controller, for a user.
pub struct SimUser {
    hosts: Hosts,
    life: Life,
}

impl SimUser {
    /// A user.
    pub fn new(hosts: &Hosts) -> Self {
        Self {
            hosts: hosts.clone(),
            life: Life::new("user", 1),
        }
    }

    /// Asks the controller for something.
    pub async fn ask<T: Send + 'static>(
        &self,
        work: impl Fn(Arc<Core>) -> BoxFuture<'static, Result<T, Problem>> + Send + 'static,
    ) -> Result<T, ClientError> {
        self.hosts.ask_controller(&self.life, USER, work).await
    }
}
