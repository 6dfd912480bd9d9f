//! What every HTTP API of the project shares: problem documents, clients over Unix sockets, JSON Lines, and (feature
//! `server`) listeners that know their peer.

pub mod client;
pub mod lines;
pub mod problem;
#[cfg(feature = "server")]
pub mod server;
