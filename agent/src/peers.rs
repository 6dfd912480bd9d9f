//! The agents of other nodes: where the in-port end of a connector is, they alone know.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent_api::ClientError;
use rts_agent_api::client::HttpAgent;
use rts_agent_api::messages::{BindRequest, Bound};
use rts_http::client::Client;
use rts_http::problem::Problem;

use crate::events::lock;
use crate::folders::is_node_name;

/// Longest wait for another agent; less than a Connect may take, so that its answer is told.
const REQUEST: Duration = Duration::from_secs(3);

/// The agents of other nodes. A simulation implements it too.
pub trait Peers: Send + Sync + 'static {
    /// Asks the agent of a node to let a connector come to one of its in-ports. Asked anew at each connect.
    fn bind<'a>(
        &'a self,
        node: &'a str,
        request: &'a BindRequest,
    ) -> BoxFuture<'a, Result<Bound, ClientError>>;
}

/// The agents that share a home: each has its socket there, and takes requests of the same user only.
#[derive(Debug)]
pub struct HomePeers {
    run: PathBuf,
    /// By node; as many as there are nodes in the node spec.
    known: Mutex<BTreeMap<String, Client>>,
}

impl HomePeers {
    /// Those of a home.
    pub fn new(home: &Path) -> Self {
        Self {
            run: home.join("run"),
            known: Mutex::default(),
        }
    }

    fn client(&self, node: &str) -> Result<HttpAgent, ClientError> {
        let socket = self.run.join(node).join("agent.sock");
        if !is_node_name(node) || !socket.exists() {
            let detail = format!(
                "no agent of node {node} serves in {}: `rtsctl up` starts one that has ended; connections to other machines come with the network transport",
                self.run.display()
            );
            return Err(Problem::unavailable("no-peer", detail).into());
        }
        let mut known = lock(&self.known);
        let client = match known.get(node) {
            Some(client) => client.clone(),
            None => {
                let client = Client::unix(socket, REQUEST)?;
                known.insert(node.to_owned(), client.clone());
                client
            }
        };
        Ok(HttpAgent::new(client))
    }
}

impl Peers for HomePeers {
    fn bind<'a>(
        &'a self,
        node: &'a str,
        request: &'a BindRequest,
    ) -> BoxFuture<'a, Result<Bound, ClientError>> {
        Box::pin(async move { self.client(node)?.bind(request).await })
    }
}
