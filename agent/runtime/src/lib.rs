//! What a component is built on: the Rust SDK and the C ABI of modules.

pub mod abi;
