//! What goes wrong, done to real processes and files. What it may change is excused first.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

use rts_host::identity::start_ticks;
use rustix::process::Signal;

use super::script::{Fault, Lost, Target};
use super::stage::Stage;
use super::table::{Manager, managers};
use super::wish::Wish;
use crate::{program, programs, signal};

/// What is done later because of a fault.
#[derive(Debug, Clone)]
pub enum Later {
    /// SIGCONT for these processes, if they are still the same.
    Continue(Vec<(u32, u64)>),
    /// SIGKILL for them.
    Kill(Vec<(u32, u64)>),
    /// The disk has room again.
    FreeDisk,
}

impl Stage {
    /// Does it. Gives what is to be done later.
    pub fn fault(&mut self, fault: &Fault) -> Option<(Duration, Later)> {
        self.faulty = true;
        let text = fault.text();
        self.agent_ended |= matches!(
            fault,
            Fault::Kill(Target::Agent) | Fault::PauseThenKill(Target::Agent, _)
        );
        let (hit, later) = match fault {
            Fault::Kill(target) => (self.kill(target), None),
            Fault::Pause(target, time) => {
                let paused = self.pause(target);
                let later = (!paused.is_empty()).then_some((*time, Later::Continue(paused)));
                (later.is_some(), later)
            }
            Fault::PauseThenKill(target, time) => {
                let paused = self.pause(target);
                let later = (!paused.is_empty()).then_some((*time, Later::Kill(paused)));
                (later.is_some(), later)
            }
            Fault::Hang(system, name) => (self.hang(system, name), None),
            Fault::KillRtsctl => (self.kill_rtsctl(), None),
            Fault::Lose(target, lost) => (self.lose(target, *lost), None),
            Fault::LoseRun => {
                let removed = std::fs::remove_dir_all(self.stack.home().join("run"));
                (removed.is_ok(), None)
            }
            Fault::FullDisk(time) => {
                self.disk.fill();
                (self.disk.is_there(), Some((*time, Later::FreeDisk)))
            }
            Fault::SecondAgent => (self.second_agent(), None),
        };
        let word = if hit { "" } else { " (nothing there)" };
        self.journal.note(&format!("fault {text}{word}"));
        if hit {
            self.journal.count_fault(&fault.kind());
        }
        later
    }

    /// Does what a fault left to do.
    pub fn later(&mut self, later: &Later) {
        let (processes, word, what) = match later {
            Later::Continue(processes) => (processes, "SIGCONT", Signal::CONT),
            Later::Kill(processes) => (processes, "SIGKILL", Signal::KILL),
            Later::FreeDisk => {
                self.disk.free();
                return self.journal.note("state/ has room again");
            }
        };
        for (pid, ticks) in processes {
            if start_ticks(*pid) == Some(*ticks) {
                signal(*pid, what);
            }
        }
        self.journal.note(&format!("{word} {processes:?}"));
    }

    /// The live manager of this system and name.
    fn manager(&self, system: &str, name: &str) -> Option<Manager> {
        let mut managers = managers(&self.stack.home()).into_iter();
        managers.find(|m| m.system == system && m.name == name)
    }

    /// Instances that are or may be in a manager.
    fn instances(&self, manager: &Manager) -> Vec<String> {
        let mut instances = self.watcher.instances_of(manager.pid);
        for wish in self.candidates(&manager.system).iter().flatten() {
            let parts = wish
                .parts
                .iter()
                .filter(|part| part.manager == manager.name);
            instances.extend(parts.map(|part| part.instance.clone()));
        }
        instances
    }

    fn kill(&mut self, target: &Target) -> bool {
        let Target::Manager(system, name) = target else {
            let pids = self.daemons(target);
            pids.iter().for_each(|pid| signal(*pid, Signal::KILL));
            return !pids.is_empty();
        };
        let Some(manager) = self.manager(system, name) else {
            return false;
        };
        let dead = self.watcher.instances_of(manager.pid);
        self.excuse_death(&manager, &dead);
        signal(manager.pid, Signal::KILL);
        true
    }

    /// Those of `dead` die now.
    fn excuse_death(&self, manager: &Manager, dead: &[String]) {
        let instances = self.instances(manager);
        let candidates = self.candidates(&manager.system);
        let wishes: Vec<&Wish> = candidates.iter().flatten().collect();
        self.excuses
            .death(&manager.system, &instances, dead, &wishes);
    }

    fn excuse_pause(&self, manager: &Manager) {
        let instances = self.instances(manager);
        let candidates = self.candidates(&manager.system);
        let wishes: Vec<&Wish> = candidates.iter().flatten().collect();
        self.excuses
            .pause(&manager.system, manager.pid, &instances, &wishes);
    }

    /// True when the agent may replace this process when it is silent.
    fn may_be_replaced(&self, manager: &Manager) -> bool {
        let candidates = self.candidates(&manager.system);
        let mut parts = candidates.iter().flatten().flat_map(|wish| &wish.parts);
        parts.any(|part| part.manager == manager.name && part.watched)
    }

    fn pause(&mut self, target: &Target) -> Vec<(u32, u64)> {
        let pids = match target {
            Target::Manager(system, name) => {
                let Some(manager) = self.manager(system, name) else {
                    return Vec::new();
                };
                self.excuse_pause(&manager);
                if self.may_be_replaced(&manager) {
                    self.excuse_death(&manager, &[]);
                }
                vec![manager.pid]
            }
            daemon => self.daemons(daemon),
        };
        let named: Vec<_> = pids
            .into_iter()
            .filter_map(|p| Some((p, start_ticks(p)?)))
            .collect();
        named.iter().for_each(|(pid, _)| signal(*pid, Signal::STOP));
        named
    }

    fn hang(&mut self, system: &str, name: &str) -> bool {
        let Some(manager) = self.manager(system, name) else {
            return false;
        };
        if !self.may_be_replaced(&manager) {
            return false;
        }
        self.excuse_pause(&manager);
        self.excuse_death(&manager, &[]);
        self.hung.push((manager.pid, manager.ticks));
        signal(manager.pid, Signal::STOP);
        true
    }

    fn daemons(&self, target: &Target) -> Vec<u32> {
        self.stack.daemons(match target {
            Target::Controller => "rts-controller",
            _ => "rts-agent",
        })
    }

    fn kill_rtsctl(&mut self) -> bool {
        let Some(running) = self.running.first_mut() else {
            return false;
        };
        self.journal.note(&format!("kill -9 `{}`", running.what()));
        running.kill();
        true
    }

    fn lose(&mut self, target: &Target, lost: Lost) -> bool {
        let run = self.stack.home().join("run");
        let name = |stem: &str| match lost {
            Lost::Socket => format!("{stem}.sock"),
            Lost::Description => format!("{stem}.json"),
            Lost::Lock => format!("{stem}.lock"),
        };
        let file: PathBuf = match target {
            Target::Controller => run.join(name("controller")),
            Target::Agent => run.join("local").join(name("agent")),
            Target::Manager(system, manager) => {
                let Some(manager) = self.manager(system, manager) else {
                    return false;
                };
                manager.folder.join(match lost {
                    Lost::Socket => "control.sock",
                    Lost::Description => "manager.json",
                    Lost::Lock => "lock",
                })
            }
        };
        std::fs::remove_file(file).is_ok()
    }

    fn second_agent(&mut self) -> bool {
        let home = self.stack.home();
        let child = Command::new(program("rts-agent"))
            .arg("--home")
            .arg(&home)
            .args(["--node", "local", "--controller"])
            .arg(home.join("run/controller.sock"))
            .env("RTSCTL_MODULE_PATH", programs())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        self.agents.extend(child.ok());
        true
    }
}
