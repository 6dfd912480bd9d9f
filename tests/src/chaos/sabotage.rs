//! Breaks an invariant by its own hand, and tells nobody: who watches must notice.

use std::process::{Command, Stdio};
use std::time::Duration;

use rustix::process::Signal;

use super::stage::{Stage, Stop};
use super::table::managers;
use crate::{program, programs, signal};

/// What is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sabotage {
    /// A second process of the same manager is started.
    SecondManager,
    /// A process is killed that nobody is said to touch.
    Kill,
    /// A process is stopped until samples for it are lost.
    LoseSamples,
    /// An apply is said to be acknowledged that never was.
    LoseApply,
    /// A run folder is left behind.
    LeaveBehind,
}

impl Sabotage {
    /// Names of all.
    pub const ALL: [(&'static str, Self); 5] = [
        ("second-manager", Self::SecondManager),
        ("kill", Self::Kill),
        ("lose-samples", Self::LoseSamples),
        ("lose-apply", Self::LoseApply),
        ("leave-behind", Self::LeaveBehind),
    ];
}

impl Stage {
    /// Does it, in a quiet moment.
    pub fn sabotage(&mut self, what: Sabotage) -> Result<(), Stop> {
        self.journal.note(&format!("SABOTAGE: {what:?}"));
        let live = managers(&self.stack.home());
        // One that is sent samples.
        let seen = self.watcher.last();
        let receives = |pid: u32| {
            let mut seen = seen.iter().filter(|(m, _)| m.pid == pid);
            seen.any(|(_, all)| all.iter().flatten().any(|info| !info.bindings.is_empty()))
        };
        let victim = live.iter().find(|m| receives(m.pid)).or(live.first());
        let Some(victim) = victim else { return Ok(()) };
        match what {
            Sabotage::SecondManager => {
                let second = self.stack.home().join("run/local/second");
                let child = Command::new(program("rts-manager"))
                    .arg("--dir")
                    .arg(&second)
                    .args(["--name", &victim.name, "--system-name", &victim.system])
                    .args(["--system-uid", &victim.uid, "--incarnation", "second"])
                    .env("RTSCTL_MODULE_PATH", programs())
                    .stdin(Stdio::null())
                    .stdout(Stdio::null())
                    .stderr(Stdio::null())
                    .spawn();
                self.agents.extend(child.ok());
            }
            Sabotage::Kill => signal(victim.pid, Signal::KILL),
            Sabotage::LoseSamples => {
                signal(victim.pid, Signal::STOP);
                std::thread::sleep(Duration::from_millis(4500));
                signal(victim.pid, Signal::CONT);
            }
            Sabotage::LoseApply => {
                let system = victim.system.clone();
                for wish in self.stored.entry(system).or_default().iter_mut().flatten() {
                    wish.serial += 1;
                }
            }
            Sabotage::LeaveBehind => {
                let _ = std::fs::create_dir_all(self.stack.home().join("run/local/forgotten"));
                return self.nothing_is_left_of_the_gone();
            }
        }
        self.sleep(Duration::from_secs(2))
    }
}
