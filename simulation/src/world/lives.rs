//! The programs of the hosts: which life each is in, and when it may start again.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::Instant;

use crate::life::Life;

/// Time from the end of a program to its next start, where no fault says another.
const DOWN: Duration = Duration::from_secs(1);

/// The programs of all hosts.
pub struct Lives {
    programs: Mutex<BTreeMap<String, Program>>,
    /// Told when a program may start at another time than it thought.
    hurry: Notify,
    /// What does not come up is tried again.
    pub tries_again: bool,
}

/// The program of a host.
struct Program {
    lives: u32,
    life: Option<Life>,
    /// None for never.
    not_before: Option<Instant>,
    /// How long it stays down after its next crash; none inside for ever.
    down: Option<Option<Duration>>,
    /// Lives that are no longer the host's own.
    retired: Vec<u32>,
}

impl Lives {
    /// Programs that have not been started yet.
    pub(super) fn new<'a>(hosts: impl Iterator<Item = &'a str>, tries_again: bool) -> Self {
        let begin = Instant::now();
        let program = |host: &str| {
            let program = Program {
                lives: 0,
                life: None,
                not_before: Some(begin),
                down: None,
                retired: Vec::new(),
            };
            (host.to_owned(), program)
        };
        Self {
            programs: Mutex::new(hosts.map(program).collect()),
            hurry: Notify::new(),
            tries_again,
        }
    }

    /// Waits until the program of a host may start, and begins a life of it.
    pub(super) async fn begin(&self, host: &str) -> Life {
        loop {
            let hurry = self.hurry.notified();
            let not_before = self.program(host, |p| p.not_before);
            let until = not_before.unwrap_or_else(|| Some(Instant::now()));
            if until.is_some_and(|until| until <= Instant::now()) {
                break;
            }
            let due = async {
                match until {
                    Some(until) => tokio::time::sleep_until(until).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                biased;
                () = hurry => {}
                () = due => {}
            }
        }
        let begun = self.program(host, |program| {
            program.lives += 1;
            let life = Life::new(host, program.lives);
            program.life = Some(life.clone());
            life
        });
        // There is a program of each host.
        begun.unwrap_or_else(|| Life::new(host, 0))
    }

    /// A life has ended: when the next one may begin.
    pub(super) fn crashed(&self, life: &Life) {
        self.program(life.host(), |program| {
            let own = program.life.as_ref().map(Life::number);
            if own != Some(life.number()) {
                return;
            }
            let down = program.down.take().unwrap_or(Some(DOWN));
            let next = down.map(|down| Instant::now() + down);
            program.not_before = program.not_before.zip(next).map(|(a, b)| a.max(b));
        });
    }

    /// Ends the life of a host's program, or sets its fuse; then it stays down for a while, or for ever. False when it does
    /// not live.
    pub fn end(&self, host: &str, calls: u64, down: Option<Duration>) -> bool {
        let life = self.program(host, |program| {
            let life = program.life.clone().filter(|life| !life.is_over())?;
            program.down = Some(down);
            Some(life)
        });
        let Some(life) = life.flatten() else {
            return false;
        };
        if calls == 0 {
            life.end();
        } else {
            life.burn(calls);
        }
        true
    }

    /// The life of a host's program is no longer the host's own: it goes on, and is not started again. None when it does
    /// not live.
    pub fn retire(&self, host: &str) -> Option<Life> {
        let life = self.program(host, |program| {
            let life = program.life.take_if(|life| !life.is_over());
            program.retired.extend(life.iter().map(Life::number));
            life
        });
        life.flatten()
    }

    /// True for a life that was retired.
    pub fn is_retired(&self, life: &Life) -> bool {
        let retired = self.program(life.host(), |p| p.retired.contains(&life.number()));
        retired.unwrap_or(false)
    }

    /// A program starts after this time and not before, whatever was said of it until now.
    pub fn keep_down(&self, host: &str, down: Duration) {
        let until = Instant::now() + down;
        self.program(host, |p| p.not_before = Some(until));
        self.hurry.notify_waiters();
    }

    /// Nothing keeps a program from starting any more, and no crash is to come.
    pub fn let_start(&self, host: &str) {
        self.program(host, |program| {
            program.not_before = Some(Instant::now());
            program.down = None;
            if let Some(life) = &program.life {
                life.burn(u64::MAX);
            }
        });
        self.hurry.notify_waiters();
    }

    fn program<T>(&self, host: &str, of: impl FnOnce(&mut Program) -> T) -> Option<T> {
        let mut programs = self.programs.lock().unwrap_or_else(PoisonError::into_inner);
        programs.get_mut(host).map(of)
    }
}
