//! Samples as bytes: how they travel to another process.
//!
//! A frame is a header of 24 bytes, in network order, and the payload: u32 length of the payload; u32 kind;
//! u64 sequence number; u64 time. A good-bye is a header of its own kind, all else of it zero, and the last frame.

mod decoder;
mod framing;
mod header;
mod spare;

pub use decoder::{Decoder, Message};
pub use framing::Framing;
pub(crate) use framing::Head;
pub use header::{HEADER, Header, Malformed};
