//! Control protocol of a manager process: what its agent (or `rtsctl down`) says to it over its Unix socket.
//!
//! A frame is a u32 length in network order and that many bytes of JSON ([`frame`]). The first frame each way is a
//! greeting; then a control connection carries requests, responses and pushed events ([`control`]), and a data
//! connection carries samples ([`data`]).

pub mod client;
pub mod control;
pub mod data;
pub mod files;
pub mod frame;
mod greeting;
pub mod net;
pub mod passing;
pub mod tap;
mod version;
pub mod zygote;

pub use version::{OLDEST_PROTOCOL_VERSION, PROTOCOL_VERSION, VersionMismatch, speaks};
