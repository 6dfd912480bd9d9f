//! Where it all happens: a home, the commands that run in it, and what may be stored by now.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::disk::Disk;
use super::excuses::Shared;
use super::journal::Journal;
use super::known::APPLIES_DO_NOT_DISTURB_EACH_OTHER;
use super::logs::Logs;
use super::script::Act;
use super::watcher::Watcher;
use super::wish::Wish;
use crate::Stack;

/// How long a user's command waits by itself.
pub const PATIENCE: &str = "30s";
/// How long a command may take in all.
const LIMIT: Duration = Duration::from_secs(50);

/// Why it goes no further.
#[derive(Debug)]
pub enum Stop {
    /// Something was violated.
    Violated(Vec<String>),
    /// This signal came.
    Signal(usize),
}

/// A home and all that is known of it.
pub struct Stage {
    /// The home.
    pub stack: Stack,
    /// What was done.
    pub journal: Journal,
    /// What may change.
    pub excuses: Shared,
    /// What looks.
    pub watcher: Watcher,
    /// Below `state/`.
    pub disk: Disk,
    /// What was read of the logs.
    pub logs: Logs,
    /// By system: what may be stored, the oldest first.
    pub stored: BTreeMap<String, Vec<Option<Wish>>>,
    /// Commands of the user that run.
    pub running: Vec<Running>,
    /// Agents that were started beside `rtsctl`.
    pub agents: Vec<Child>,
    /// In this round something went wrong.
    pub faulty: bool,
    /// Stopped for ever in this round: pid and start.
    pub hung: Vec<(u32, u64)>,
    /// In this round an agent was ended.
    pub agent_ended: bool,
    signal: Arc<AtomicUsize>,
    commands: u64,
}

/// A command that runs.
pub struct Running {
    /// Its process.
    pub child: Child,
    what: String,
    out: PathBuf,
    begin: Instant,
    killed: bool,
    act: Option<(String, Option<Wish>)>,
    /// No other act on its system ran at the same time.
    alone: bool,
    /// Another act ran at the same time.
    beside: bool,
}

/// What a command said.
#[derive(Debug)]
pub struct Ended {
    /// Exit code; -1 for a signal.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Stage {
    /// An empty home.
    pub fn new(signal: Arc<AtomicUsize>, disk: bool) -> Self {
        let stack = Stack::new();
        let journal = Journal::begin();
        let excuses = Shared::default();
        let watcher = Watcher::start(&stack.home(), &excuses, &journal);
        let disk = Disk::mount(&stack.home(), disk);
        Self {
            logs: Logs::of(&stack.home()),
            stack,
            journal,
            excuses,
            watcher,
            disk,
            stored: BTreeMap::new(),
            running: Vec::new(),
            agents: Vec::new(),
            faulty: false,
            hung: Vec::new(),
            agent_ended: false,
            signal,
            commands: 0,
        }
    }

    /// An error once a signal has come or the watcher has found something.
    pub fn go_on(&mut self) -> Result<(), Stop> {
        match self.signal.load(Ordering::SeqCst) {
            0 => {}
            signal => return Err(Stop::Signal(signal)),
        }
        for agent in &mut self.agents {
            // Reaps it.
            let _ = agent.try_wait();
        }
        if self.watcher.has_found() {
            return Err(Stop::Violated(self.watcher.violations()));
        }
        Ok(())
    }

    /// Sleeps in short steps.
    pub fn sleep(&mut self, time: Duration) -> Result<(), Stop> {
        let until = Instant::now() + time;
        loop {
            self.go_on()?;
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            std::thread::sleep(left.min(Duration::from_millis(20)));
        }
    }

    /// What this system may be now.
    pub fn candidates(&self, system: &str) -> Vec<Option<Wish>> {
        self.stored
            .get(system)
            .cloned()
            .unwrap_or_else(|| vec![None])
    }

    /// Begins what a user does. What may change by it is excused first.
    pub fn begin(&mut self, act: &Act) {
        let (system, after) = match act {
            Act::Apply(wish, _) => (wish.name.clone(), Some(wish.clone())),
            Act::Teardown(name) => (name.clone(), None),
        };
        let mut candidates = self.candidates(&system);
        for before in &candidates {
            self.excuses.change(before.as_ref(), after.as_ref());
        }
        if !candidates.contains(&after) {
            candidates.push(after.clone());
        }
        self.stored.insert(system.clone(), candidates);
        let arguments = match act {
            Act::Apply(wish, _) => {
                let name = format!("{}.{}.xml", wish.name, wish.serial);
                let file = self.stack.write(&name, wish.xml());
                let file = file.to_string_lossy().into_owned();
                vec!["apply".to_owned(), file]
            }
            Act::Teardown(name) => vec!["teardown".to_owned(), name.clone(), "--yes".to_owned()],
        };
        let mut arguments: Vec<_> = arguments.iter().map(String::as_str).collect();
        arguments.extend(["--timeout", PATIENCE]);
        self.journal.note(&format!("begin {}", act.text()));
        self.journal.count_action(&act.kind());
        let mut running = self.spawn(&arguments);
        running.beside = !self.running.is_empty();
        for other in &mut self.running {
            other.beside = true;
            if other.act.as_ref().is_some_and(|(name, _)| *name == system) {
                other.alone = false;
                running.alone = false;
            }
        }
        running.act = Some((system, after));
        running.what = act.text();
        self.running.push(running);
    }

    /// Notes what has ended; an error when one ended as it must not.
    pub fn reap(&mut self) -> Result<(), Stop> {
        let mut place = 0;
        while place < self.running.len() {
            let running = &mut self.running[place];
            if let Ok(None) = running.child.try_wait() {
                if running.begin.elapsed() > LIMIT {
                    let what = format!("`{}` has not ended after {LIMIT:?}", running.what);
                    return Err(Stop::Violated(vec![what]));
                }
                place += 1;
                continue;
            }
            let running = self.running.remove(place);
            self.ended(running)?;
        }
        Ok(())
    }

    fn ended(&mut self, mut running: Running) -> Result<(), Stop> {
        let ended = running.wait();
        let last = ended.err.lines().last().unwrap_or_default();
        let what = running.what.clone();
        self.journal
            .note(&format!("ended {what}: exit {} ({last})", ended.code));
        let Some((system, after)) = running.act.take() else {
            return Ok(());
        };
        let expected: &[i32] = match (running.killed, self.faulty || !running.alone) {
            (true, _) => &[-1, 0, 1, 2, 4, 5, 6, 7],
            (false, true) => &[0, 2, 4, 5, 6, 7],
            (false, false) => &[0],
        };
        let disturbed = !APPLIES_DO_NOT_DISTURB_EACH_OTHER && ended.code == 5 && running.beside;
        let torn_down_twice = ended.code == 2 && after.is_some();
        if !(expected.contains(&ended.code) || disturbed)
            || torn_down_twice
            || ended.err.contains("panicked")
        {
            let text = format!("`{what}` ended with {}: {}", ended.code, ended.err);
            return Err(Stop::Violated(vec![text]));
        }
        if ended.code == 0 && running.alone {
            // Acknowledged: nothing else may be there from now on.
            self.stored.insert(system, vec![after]);
        }
        Ok(())
    }

    /// Runs `rtsctl` to its end.
    pub fn rtsctl(&mut self, arguments: &[&str]) -> Result<Ended, Stop> {
        let mut running = self.spawn(arguments);
        loop {
            if !matches!(running.child.try_wait(), Ok(None)) {
                return Ok(running.wait());
            }
            let late = running.begin.elapsed() > LIMIT;
            if late {
                let what = format!(
                    "`rtsctl {}` has not ended after {LIMIT:?}",
                    arguments.join(" ")
                );
                return Err(Stop::Violated(vec![what]));
            }
            self.go_on()?;
            std::thread::sleep(Duration::from_millis(3));
        }
    }

    fn spawn(&mut self, arguments: &[&str]) -> Running {
        self.commands += 1;
        let out = self
            .stack
            .write(&format!("said{}.out", self.commands % 50), "");
        let err = out.with_extension("err");
        let file = |path: &PathBuf| File::create(path).map_or_else(|_| Stdio::null(), Stdio::from);
        let child = self
            .stack
            .command(arguments)
            .stdout(file(&out))
            .stderr(file(&err))
            .spawn()
            .expect("rtsctl starts");
        Running {
            child,
            what: arguments.join(" "),
            out,
            begin: Instant::now(),
            killed: false,
            act: None,
            alone: true,
            beside: false,
        }
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.end_everything();
        self.disk.unmount();
    }
}

impl Running {
    /// SIGKILL.
    pub fn kill(&mut self) {
        self.killed = true;
        let _ = self.child.kill();
    }

    /// For people.
    pub fn what(&self) -> &str {
        &self.what
    }

    fn wait(&mut self) -> Ended {
        let code = self.child.wait().ok().and_then(|status| status.code());
        let read = |path: &PathBuf| std::fs::read_to_string(path).unwrap_or_default();
        Ended {
            code: code.unwrap_or(-1),
            out: read(&self.out),
            err: read(&self.out.with_extension("err")),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
