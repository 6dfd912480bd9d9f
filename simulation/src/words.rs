//! Faults in words: `agent node2 crashes at step 5 for 3s`. [`parse`] reads them, [`print()`] writes them, and what was
//! printed is read as the very same. Names are checked, and nodes that were left out filled in, by [`settle`].

mod error;
mod names;
mod parse;
mod print;
mod span;
#[cfg(test)]
mod tests;
mod token;

pub use self::error::WordError;
pub use self::names::{Names, settle};
pub use self::parse::parse;
pub use self::print::{groups, print, print_all};

/// What a user can say.
pub const GRAMMAR: &str = "\
Faults:
  agent NODE drops                          neither it nor the controller reaches the other
  agent NODE crashes, controller crashes    starts again after `for`, and never without
  HOST cannot reach HOST                    one way; a HOST is a node or `controller`
  node NODE reboots                         back after `for`, or 10s
  manager NAME dies|hangs [on NODE]         its process
  managers on NODE fail to start            for `for`, or 10s
  module TYPE fails [on NODE]               it cannot be loaded
  component NAME misbehaves HOW             crash-at-once, crash-later, hang-initialize|activate|execute|deactivate|finalize,
                                            error-initialize|activate|execute, panic, ignore-deactivate, slow-activate
  network loses P% doubles P% delays TIME   one of them or more, by up to TIME, for `for`, or 30s
  disk of HOST fails|is slow TIME           its writes, for `for`, or 10s
  clock of HOST jumps TIME                  by +5s or -1h
Behind each: `at step N` or `at TIME` (else as soon as it can matter), and `for TIME`. Steps have the numbers of the plan; a
TIME is 200ms, 2.5s, 3m or 1h.";

/// Host of the controller.
pub const CONTROLLER: &str = "controller";
