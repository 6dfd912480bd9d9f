//! The agents of other nodes, as one life of an agent reaches them.

use std::sync::Arc;

use futures_util::future::BoxFuture;
use rts_agent::peers::Peers;
use rts_agent_api::ClientError;
use rts_agent_api::messages::{BindRequest, Bound};

use super::Hosts;
use super::agent::Remote;
use crate::life::Life;

/// The agents of other nodes, for a life of an agent.
pub struct SimPeers {
    hosts: Hosts,
    life: Life,
}

impl SimPeers {
    /// For a life of an agent.
    pub fn new(hosts: &Hosts, life: &Life) -> Self {
        Self {
            hosts: hosts.clone(),
            life: life.clone(),
        }
    }
}

impl Peers for SimPeers {
    fn bind<'a>(
        &'a self,
        node: &'a str,
        request: &'a BindRequest,
    ) -> BoxFuture<'a, Result<Bound, ClientError>> {
        let remote = Remote {
            hosts: self.hosts.clone(),
            life: self.life.clone(),
            node: node.to_owned(),
            endpoint: format!("/sim/run/{node}/agent.sock"),
        };
        let request = Arc::new(request.clone());
        Box::pin(async move { remote.bind(request).await })
    }
}
