//! (Desired, Observed) → Plan: what to do, in which order, and why.
//!
//! Pure, synchronous and deterministic: no clock, no file, no network. The controller plans roll-outs with it; an
//! agent heals its own node with the same code.
//!
//! From outside: [`place`](place::place) settles where everything goes, [`check_orders`] refuses
//! orders that can never be obeyed, [`plan`](planner::plan) plans, [`render`](render::render) shows a plan to people.

pub mod backoff;
pub mod check;
pub mod delta;
pub mod desired;
pub mod explain;
pub mod mark;
pub mod observed;
pub mod place;
pub mod plan;
pub mod planner;
pub mod render;
pub mod restart;
pub mod target;

mod alone;
mod beside;
mod bring_up;
mod critical_path;
mod decide;
mod diff;
mod drift;
mod export;
mod graph;
mod in_place;
mod index;
mod links;
mod order;
mod peers;
mod service;
mod table;
mod take_down;

pub use beside::{Unfinished, beside};
pub use check::{check_orders, cycle_pointer};
pub use critical_path::{critical_path, nominal_micros};
pub use drift::drift;
pub use export::with_drift;
pub use place::{
    Hosts, NodeFacts, PlaceError, Placed, Settled, StoredSystem, digest, place, place_settled,
};
pub use planner::plan;
pub use render::{render, summary};
pub use service::service_provider;
