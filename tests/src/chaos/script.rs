//! What is done in each round: it follows from the seed alone, whatever comes of it.

mod words;

use std::collections::BTreeMap;
use std::time::Duration;

use super::draw::Draw;
use super::known::CONTROLLER_KEEPS_ITS_LOCK;
use super::wish::{Change, Wish};

/// Systems at a time.
const SYSTEMS: u64 = 3;
/// Processes of a system are killed so often at most: each death makes the next restart later.
const KILLS: u32 = 4;

/// Something that a user does.
#[derive(Debug, Clone)]
pub enum Act {
    /// `rtsctl apply`, and a word for what changed.
    Apply(Wish, &'static str),
    /// `rtsctl teardown`.
    Teardown(String),
}

/// Whom a fault hits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// `rts-controller`.
    Controller,
    /// `rts-agent`.
    Agent,
    /// The manager of this system and name.
    Manager(String, String),
}

/// A file below `run/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lost {
    /// Its socket.
    Socket,
    /// Its description.
    Description,
    /// Its lock.
    Lock,
}

/// Something that goes wrong.
#[derive(Debug, Clone)]
pub enum Fault {
    /// SIGKILL.
    Kill(Target),
    /// SIGSTOP, and after this time SIGCONT.
    Pause(Target, Duration),
    /// SIGSTOP, and after this time SIGKILL.
    PauseThenKill(Target, Duration),
    /// SIGSTOP for a manager whose components all say that their process is replaced when it hangs.
    Hang(String, String),
    /// SIGKILL for a running `rtsctl`.
    KillRtsctl,
    /// A file is removed.
    Lose(Target, Lost),
    /// The whole folder `run` is removed.
    LoseRun,
    /// `state/` is full for this time.
    FullDisk(Duration),
    /// Another agent of the node is started.
    SecondAgent,
}

/// What is done in a round, each at its time after the round's begin.
#[derive(Debug)]
pub struct Round {
    /// From 1.
    pub number: u64,
    /// What the user does.
    pub acts: Vec<(Duration, Act)>,
    /// What goes wrong.
    pub faults: Vec<(Duration, Fault)>,
    /// What the user wishes in the end, by system.
    pub wished: BTreeMap<String, Wish>,
}

/// Writes rounds.
#[derive(Debug)]
pub struct Script {
    seed: u64,
    rounds: u64,
    named: u64,
    wished: BTreeMap<String, Wish>,
    /// What was taken down, and may come back.
    gone: Vec<Wish>,
    kills: BTreeMap<String, u32>,
    full_disks: bool,
}

impl Script {
    /// Nothing is wished yet. `full_disks`: the disk may be filled.
    pub fn new(seed: u64, full_disks: bool) -> Self {
        Self {
            seed,
            full_disks,
            rounds: 0,
            named: 0,
            wished: BTreeMap::new(),
            gone: Vec::new(),
            kills: BTreeMap::new(),
        }
    }

    /// The next round.
    pub fn next(&mut self) -> Round {
        self.rounds += 1;
        let mut draw = Draw::new(self.seed, self.rounds);
        let before = self.wished.clone();
        let count = match self.rounds {
            1 => 2,
            _ => draw.weighted(&[(2, 0), (5, 1), (3, 2)]),
        };
        let mut acts: Vec<_> = (0..count)
            .map(|_| {
                let at = millis(draw.between(0, 400));
                (at, self.act(&mut draw))
            })
            .collect();
        acts.sort_by_key(|(at, _)| *at);
        let count = match (self.rounds, count) {
            (1, _) => 0,
            (_, 0) => draw.between(1, 3),
            _ => draw.weighted(&[(1, 0), (4, 1), (3, 2), (2, 3)]),
        };
        let mut faults: Vec<_> = (0..count)
            .map(|_| {
                let at = millis(draw.weighted(&[(1, 0), (3, 150), (3, 600), (1, 1500)]));
                let at = at + millis(draw.between(0, 150));
                (at, self.fault(&before, &mut draw))
            })
            .collect();
        faults.sort_by_key(|(at, _)| *at);
        Round {
            number: self.rounds,
            acts,
            faults,
            wished: self.wished.clone(),
        }
    }

    /// The end: everything is taken down, without faults.
    pub fn last(&mut self) -> Round {
        self.rounds += 1;
        let wished = std::mem::take(&mut self.wished);
        let acts = wished
            .into_keys()
            .map(|name| (Duration::ZERO, Act::Teardown(name)));
        Round {
            number: self.rounds,
            acts: acts.collect(),
            faults: Vec::new(),
            wished: BTreeMap::new(),
        }
    }

    fn act(&mut self, draw: &mut Draw) -> Act {
        let names: Vec<_> = self.wished.keys().cloned().collect();
        if (names.len() as u64) < draw.between(1, SYSTEMS) {
            return self.begin(draw);
        }
        let Some(name) = draw.pick(&names).cloned() else {
            return self.begin(draw);
        };
        let tired = self.kills.get(&name).is_some_and(|kills| *kills >= KILLS);
        let change = draw.weighted(&[
            (3, None),
            (3, Some(Change::Nothing)),
            (5, Some(Change::Configuration)),
            (4, Some(Change::Connector)),
            (4, Some(Change::Manager)),
            (4, Some(Change::More)),
            (3, Some(Change::Less)),
        ]);
        match change {
            Some(change) if !tired => self.change(&name, change, draw),
            _ => self.end(&name),
        }
    }

    fn begin(&mut self, draw: &mut Draw) -> Act {
        let (wish, word) = match self.gone.pop() {
            Some(gone) if draw.percent(50) => (gone.changed(Change::Configuration, draw), "again"),
            _ => {
                self.named += 1;
                let name = format!("c{}", self.named);
                (Wish::draw(&name, draw), "new")
            }
        };
        self.kills.remove(&wish.name);
        self.wished.insert(wish.name.clone(), wish.clone());
        Act::Apply(wish, word)
    }

    fn change(&mut self, name: &str, change: Change, draw: &mut Draw) -> Act {
        let wish = self.wished[name].changed(change, draw);
        self.wished.insert(name.to_owned(), wish.clone());
        let word = match change {
            Change::Nothing => "unchanged",
            Change::Configuration => "configuration",
            Change::Connector => "connector",
            Change::Manager => "moved",
            Change::More => "more",
            Change::Less => "less",
        };
        Act::Apply(wish, word)
    }

    fn end(&mut self, name: &str) -> Act {
        self.gone.extend(self.wished.remove(name));
        Act::Teardown(name.to_owned())
    }

    /// Hits what was wished before this round or is wished now.
    fn fault(&mut self, before: &BTreeMap<String, Wish>, draw: &mut Draw) -> Fault {
        let known: Vec<_> = before
            .values()
            .chain(self.wished.values())
            .cloned()
            .collect();
        let wish = draw.pick(&known).cloned();
        let manager = wish.as_ref().and_then(|wish| {
            let managers: Vec<_> = wish.managers().into_iter().collect();
            let manager = draw.pick(&managers)?;
            Some((wish.clone(), (*manager).to_owned()))
        });
        let daemon = match draw.percent(50) {
            true => Target::Controller,
            false => Target::Agent,
        };
        let any = match &manager {
            Some((wish, manager)) if draw.percent(50) => {
                Target::Manager(wish.name.clone(), manager.clone())
            }
            _ => daemon.clone(),
        };
        let kinds = [
            (6, 'd'),
            (6, 'm'),
            (4, 'p'),
            (2, 'k'),
            (3, 'h'),
            (3, 'r'),
            (5, 'l'),
            (u64::from(CONTROLLER_KEEPS_ITS_LOCK), 'f'),
            (2 * u64::from(self.full_disks), 's'),
            (2, '2'),
        ];
        match (draw.weighted(&kinds), manager) {
            ('m', Some((wish, manager))) if self.may_kill(&wish.name) => {
                Fault::Kill(Target::Manager(wish.name, manager))
            }
            ('p', _) => Fault::Pause(any, millis(draw.between(200, 4000))),
            ('k', _) => Fault::PauseThenKill(daemon, millis(draw.between(200, 3000))),
            ('h', Some((wish, manager)))
                if is_watched(&wish, &manager) && self.may_kill(&wish.name) =>
            {
                Fault::Hang(wish.name, manager)
            }
            ('r', _) => Fault::KillRtsctl,
            ('l', _) => {
                let lost = [Lost::Socket, Lost::Description, Lost::Lock];
                let lost = *draw.pick(&lost).unwrap_or(&Lost::Socket);
                match (lost, &any) {
                    (Lost::Lock, Target::Controller) if !CONTROLLER_KEEPS_ITS_LOCK => {
                        Fault::Lose(any, Lost::Socket)
                    }
                    _ => Fault::Lose(any, lost),
                }
            }
            ('f', _) => Fault::LoseRun,
            ('s', _) => Fault::FullDisk(millis(draw.between(500, 3000))),
            ('2', _) => Fault::SecondAgent,
            _ => Fault::Kill(daemon),
        }
    }

    /// Counts a death of a process of this system; false when there were enough.
    fn may_kill(&mut self, system: &str) -> bool {
        let kills = self.kills.entry(system.to_owned()).or_default();
        *kills += 1;
        *kills <= KILLS
    }
}

fn is_watched(wish: &Wish, manager: &str) -> bool {
    let mut parts = wish.parts.iter().filter(|part| part.manager == manager);
    parts.any(|part| part.watched)
}

fn millis(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(seed: u64) -> String {
        let mut script = Script::new(seed, true);
        let rounds: Vec<_> = (0..50).map(|_| format!("{:?}", script.next())).collect();
        rounds.join("\n")
    }

    #[test]
    fn the_same_seed_gives_the_same_script() {
        assert_eq!(text(5), text(5));
        assert_ne!(text(5), text(6));
    }

    #[test]
    fn in_a_long_script_everything_happens() {
        let mut script = Script::new(1, true);
        let mut kinds = std::collections::BTreeSet::new();
        for _ in 0..2000 {
            let round = script.next();
            assert!(round.wished.len() <= SYSTEMS as usize + 2);
            kinds.extend(round.acts.iter().map(|(_, act)| act.kind()));
            kinds.extend(round.faults.iter().map(|(_, fault)| fault.kind()));
        }
        // Its lock, and the folder with it.
        let lost = 2 * usize::from(CONTROLLER_KEEPS_ITS_LOCK);
        assert_eq!(kinds.len(), 29 + lost, "{kinds:#?}");
    }
}
