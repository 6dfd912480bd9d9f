//! What a world is made of.

use crate::modules::SimModule;
use crate::store::SimStore;

/// What a world is made of.
pub struct Setup {
    /// Nodes.
    pub nodes: Vec<NodeSetup>,
    /// The controller's own node.
    pub local_node: String,
    /// The controller's store.
    pub store: SimStore,
    /// A program that does not come up is tried again, as whoever starts programs does. Else it stays down.
    pub tries_again: bool,
}

/// What a node is made of.
pub struct NodeSetup {
    /// Name.
    pub name: String,
    /// Other names of it.
    pub aliases: Vec<String>,
    /// Module files.
    pub modules: Vec<SimModule>,
    /// Probability that a process starts one of its own; none for the usual one.
    pub grandchildren: Option<f64>,
}
