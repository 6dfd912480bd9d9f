//! The API of an agent: the trait that the controller drives, its messages, and its HTTP client.
//!
//! The messages by which an agent greets a controller are here too ([`session`]), so that neither program imports the
//! other.

pub mod client;
pub mod messages;
pub mod paths;
pub mod session;

use std::future::Future;
use std::pin::Pin;

use futures_util::Stream;
use rts_plan::observed::Inventory;

pub use rts_http::client::ClientError;

use messages::{Batch, BatchEvent, ModuleResolution, NodeSpecEnvelope, NodeSpecReceipt};

/// Version of the agent API and of the greeting.
pub const PROTOCOL_VERSION: u32 = 3;

/// Results of a batch as they come.
pub type BatchEvents = Pin<Box<dyn Stream<Item = Result<BatchEvent, ClientError>> + Send>>;

/// Ends once a NodeSpec that counts already is durable.
pub type Saving = Pin<Box<dyn Future<Output = Result<NodeSpecReceipt, ClientError>> + Send>>;

/// What the controller asks of an agent. A simulation implements it too.
pub trait AgentApi: Send + Sync + 'static {
    /// What runs on the node now.
    fn inventory(&self) -> impl Future<Output = Result<Inventory, ClientError>> + Send;

    /// What the node's ledger holds; a problem with status 404 when it was told nothing yet.
    fn node_spec(&self) -> impl Future<Output = Result<NodeSpecEnvelope, ClientError>> + Send;

    /// Replaces the node's whole desired set. Durable when it returns.
    fn put_node_spec(
        &self,
        spec: &NodeSpecEnvelope,
    ) -> impl Future<Output = Result<NodeSpecReceipt, ClientError>> + Send;

    /// The same; it counts when it returns, batches may be sent for it, and it is durable once what is given has ended well.
    fn offer_node_spec(
        &self,
        spec: &NodeSpecEnvelope,
    ) -> impl Future<Output = Result<Saving, ClientError>> + Send {
        async {
            let receipt = self.put_node_spec(spec).await?;
            Ok(Box::pin(std::future::ready(Ok(receipt))) as Saving)
        }
    }

    /// Starts a batch of steps and streams its results. A dropped stream does not stop the batch.
    fn run_batch(
        &self,
        batch: &Batch,
    ) -> impl Future<Output = Result<BatchEvents, ClientError>> + Send;

    /// Tells a running batch that steps of other nodes have started or succeeded or failed.
    fn release(
        &self,
        plan_id: &str,
        gates: &messages::GateReport,
    ) -> impl Future<Output = Result<(), ClientError>> + Send;

    /// Where the modules of these types are.
    fn resolve_modules(
        &self,
        type_names: &[String],
    ) -> impl Future<Output = Result<Vec<ModuleResolution>, ClientError>> + Send;
}
