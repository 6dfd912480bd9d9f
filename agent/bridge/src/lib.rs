//! One byte stream that carries many: between `rts-agent --stdio` on a machine that is reached by SSH alone (*far*) and the
//! relay that reached it (*near*).
//!
//! First two lines of JSON each way ([`hello`]), then a yamux connection ([`mux`]). The first byte of each stream says what
//! it is for ([`Kind`]). Everything that the other side sends is bounded and may be wrong.

pub mod hello;
mod join;
pub mod kind;
mod link;
pub mod modules;
mod mux;
pub mod pulse;

pub use hello::HelloError;
pub use join::join;
pub use kind::Kind;
pub use link::{Far, Link, LinkError, Near, far, near};
pub use mux::{Gone, Incoming, Opener, Stream};

/// Version of what the two sides say to each other before they speak HTTP.
pub const VERSION: u32 = 1;
