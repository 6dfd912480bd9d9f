//! Overlays: their schema, their documentation and the laws of laying them over a system.

mod laws;
mod lay;
mod recorded;
mod text;
