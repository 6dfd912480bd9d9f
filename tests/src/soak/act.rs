//! What is done to the system of a soak.

use std::collections::BTreeMap;
use std::fmt;

use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::Soak;
use super::system::{MANAGERS, manager};
use crate::{Said, kill};

/// An act.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Act {
    /// Another profile: other connectors, other values.
    Apply,
    /// A connector is cut by hand.
    Disconnect,
    /// A connector is made by hand.
    Connect,
    /// A value is set by hand.
    Configure,
    /// A component is deactivated by hand.
    Deactivate,
    /// A manager of the second half is killed.
    Kill,
    /// Everything is asked for.
    Look,
}

const WEIGHTS: [(u32, Act); 7] = [
    (4, Act::Apply),
    (3, Act::Disconnect),
    (3, Act::Connect),
    (3, Act::Configure),
    (2, Act::Deactivate),
    (2, Act::Kill),
    (2, Act::Look),
];

/// How often each was done.
#[derive(Debug, Default)]
pub struct Counts(BTreeMap<Act, usize>);

impl Counts {
    /// One more.
    pub fn count(&mut self, act: Act) {
        *self.0.entry(act).or_default() += 1;
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all: Vec<String> = self.0.iter().map(|(a, n)| format!("{a:?} {n}")).collect();
        f.write_str(&all.join(", "))
    }
}

impl Act {
    /// Any.
    pub fn draw(draw: &mut ChaCha8Rng) -> Self {
        let total: u32 = WEIGHTS.iter().map(|(weight, _)| weight).sum();
        let mut left = draw.random_range(0..total);
        for (weight, act) in WEIGHTS {
            if left < weight {
                return act;
            }
            left -= weight;
        }
        Self::Look
    }
}

impl Soak<'_> {
    /// Does it. That an order finds nothing to be done to, as its process was just killed, is no fault; a usage error,
    /// a daemon that cannot be reached or a crash of `rtsctl` is.
    pub(super) fn carry_out(&mut self, act: Act) -> Result<(), String> {
        match act {
            Act::Apply => {
                for _ in 0..5 {
                    self.now.rewire(&mut self.draw);
                    self.now.configure(&mut self.draw);
                }
                let file = self.stack.write("soak.xml", self.now.xml());
                let file = file.to_string_lossy();
                self.order(&["apply", &file, "--timeout", "30s"])
            }
            Act::Disconnect => {
                let (source, target) = self.now.any_link(&mut self.draw);
                self.order(&["disconnect", &source, &target])
            }
            Act::Connect => {
                let (source, target) = self.now.any_link(&mut self.draw);
                self.order(&["connect", &source, &target, "--name", "by-hand"])
            }
            Act::Configure => {
                let filter = self.now.any_filter(&mut self.draw);
                let value = format!("{}.5", self.below(100));
                self.order(&["conf", &filter, "set", "gain", &value])
            }
            Act::Deactivate => {
                let any = self.now.any(&mut self.draw);
                self.order(&["deactivate", &any])
            }
            Act::Look => self.order(&["get", "connectors", "-o", "json"]),
            Act::Kill => {
                let number = MANAGERS / 2 + self.below(MANAGERS - MANAGERS / 2);
                self.kill(&manager(number));
                Ok(())
            }
        }
    }

    fn order(&self, arguments: &[&str]) -> Result<(), String> {
        let said: Said = self.stack.rtsctl(arguments);
        match said.code {
            0 | 1 | 5 | 7 => Ok(()),
            2 if said.err.contains("has no component") => Ok(()),
            _ => Err(format!("rtsctl {arguments:?} said {said:#?}")),
        }
    }

    fn kill(&self, name: &str) {
        let managers = self.stack.managers();
        let mut found = managers.iter().map(|(hello, _)| hello);
        let found = found.find(|hello| hello.name == name);
        if let Some(hello) = found {
            kill(hello.pid);
        }
    }
}
