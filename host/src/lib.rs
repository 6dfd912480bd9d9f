//! What every program of the stack does on its machine: private folders, locks for life, files replaced as a whole,
//! and processes that are known by more than a number.

pub mod files;
pub mod home;
pub mod identity;
pub mod process;
