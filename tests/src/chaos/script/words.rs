//! Acts and faults in words.

use super::{Act, Fault, Lost, Target};

impl Target {
    /// For people.
    pub fn text(&self) -> String {
        match self {
            Self::Controller => "the controller".to_owned(),
            Self::Agent => "the agent".to_owned(),
            Self::Manager(system, name) => format!("manager {system}.{name}"),
        }
    }

    fn kind(&self) -> &'static str {
        match self {
            Self::Controller => "controller",
            Self::Agent => "agent",
            Self::Manager(..) => "manager",
        }
    }
}

impl Act {
    /// For people.
    pub fn text(&self) -> String {
        match self {
            Self::Apply(wish, word) => format!("apply {} v{} ({word})", wish.name, wish.serial),
            Self::Teardown(name) => format!("teardown {name}"),
        }
    }

    /// For the table.
    pub fn kind(&self) -> String {
        match self {
            Self::Apply(_, word) => format!("apply, {word}"),
            Self::Teardown(_) => "teardown".to_owned(),
        }
    }
}

impl Fault {
    /// For people.
    pub fn text(&self) -> String {
        match self {
            Self::Kill(target) => format!("kill -9 {}", target.text()),
            Self::Pause(target, time) => format!("SIGSTOP {} for {time:?}", target.text()),
            Self::PauseThenKill(target, time) => {
                format!("SIGSTOP {}, kill -9 after {time:?}", target.text())
            }
            Self::Hang(system, name) => format!("SIGSTOP manager {system}.{name} for ever"),
            Self::KillRtsctl => "kill -9 rtsctl".to_owned(),
            Self::Lose(target, lost) => {
                format!("remove the {} of {}", lost.text(), target.text())
            }
            Self::LoseRun => "remove the folder run".to_owned(),
            Self::FullDisk(time) => format!("state/ is full for {time:?}"),
            Self::SecondAgent => "start a second agent".to_owned(),
        }
    }

    /// For the table.
    pub fn kind(&self) -> String {
        match self {
            Self::Kill(target) => format!("kill -9 {}", target.kind()),
            Self::Pause(target, _) => format!("SIGSTOP, SIGCONT {}", target.kind()),
            Self::PauseThenKill(target, _) => format!("SIGSTOP, kill -9 {}", target.kind()),
            Self::Hang(..) => "SIGSTOP manager for ever".to_owned(),
            Self::KillRtsctl => "kill -9 rtsctl".to_owned(),
            Self::Lose(target, lost) => format!("remove {} of {}", lost.text(), target.kind()),
            Self::LoseRun => "remove the folder run".to_owned(),
            Self::FullDisk(_) => "full disk".to_owned(),
            Self::SecondAgent => "second agent".to_owned(),
        }
    }
}

impl Lost {
    /// For people.
    pub fn text(self) -> &'static str {
        match self {
            Self::Socket => "socket",
            Self::Description => "description",
            Self::Lock => "lock",
        }
    }
}
