//! (Desired, Observed) → Plan: what to do, in which order, and why.
//!
//! Pure, synchronous and deterministic: no clock, no file, no network. The controller plans roll-outs with it; an
//! agent heals its own node with the same code.

pub mod desired;
pub mod observed;
pub mod plan;
