//! How objects, plans, findings and progress look.

pub mod age;
pub mod conf;
pub mod describe;
pub mod fields;
pub mod findings;
pub mod lists;
pub mod picture;
pub mod plan;
pub mod progress;
#[cfg(test)]
pub mod samples;
pub mod sarif;
pub mod simulated;
pub mod size;
pub mod stream;
pub mod table;
pub mod timings;
