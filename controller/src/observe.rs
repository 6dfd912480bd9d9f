//! Asks the agents of all nodes at once what is there. Who does not answer in time is unknown, never empty.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use futures_util::future::BoxFuture;
use futures_util::stream;
use rts_plan::observed::{Inventory, NodeObserved, Observed};

use crate::fleet::{AT_ONCE, Agent};

/// Time that an agent has to answer; it gives its managers a second of that.
pub const DEADLINE: Duration = Duration::from_millis(2500);

/// A node to be asked.
pub enum Target {
    /// Its agent, and a future that ends when it is lost.
    Agent(Arc<dyn Agent>, BoxFuture<'static, ()>),
    /// What it has told is of now.
    Told(Arc<Inventory>),
    /// It cannot be asked, and why.
    Silent(String),
}

/// Asks everybody.
pub async fn observe(targets: BTreeMap<String, Target>, deadline: Duration) -> Observed {
    let asked = targets.into_iter().map(|(node, target)| async move {
        let answer = match target {
            Target::Agent(agent, lost) => tokio::select! {
                biased;
                answer = ask(&node, agent.as_ref(), deadline) => answer,
                () = lost => NodeObserved::Unknown {
                    reason: format!("the agent of node {node} was lost"),
                },
            },
            Target::Told(inventory) => NodeObserved::Known(inventory),
            Target::Silent(reason) => NodeObserved::Unknown { reason },
        };
        (node, answer)
    });
    Observed {
        nodes: stream::iter(asked)
            .buffer_unordered(AT_ONCE)
            .collect()
            .await,
    }
}

async fn ask(node: &str, agent: &dyn Agent, deadline: Duration) -> NodeObserved {
    match tokio::time::timeout(deadline, agent.inventory()).await {
        Ok(Ok(inventory)) => NodeObserved::Known(Arc::new(inventory)),
        Ok(Err(e)) => NodeObserved::Unknown {
            reason: format!("the agent of node {node} failed: {e}"),
        },
        Err(_) => NodeObserved::Unknown {
            reason: format!(
                "the agent of node {node} did not answer within {} ms",
                deadline.as_millis()
            ),
        },
    }
}
