//! The controller's REST API: objects as Kubernetes shapes them, paths, and a client.

pub mod client;
pub mod objects;
pub mod paths;
pub mod requests;
pub mod schema;
pub mod simulate;
pub mod watch;

pub use rts_http::client::ClientError;
pub use rts_http::problem::{Problem, ProblemError};

/// Version of every object.
pub const API_VERSION: &str = "rtsctl.dev/v1";
