//! What every program of the stack does on its machine: private folders, locks for life, files replaced as a whole,
//! processes that are known by more than a number, and control groups that hold all that a process started.

pub mod cgroup;
pub mod clock;
pub mod disk;
pub mod error;
pub mod files;
pub mod home;
pub mod identity;
pub mod limits;
pub mod memory;
pub mod process;
pub mod reserve;
pub mod timing;
pub mod usage;
