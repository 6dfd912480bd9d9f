//! A thread that looks at processes and components all the time, and knows nothing of `rtsctl`.
//!
//! Processes come from `/proc`. Components come from their managers' own control sockets, over connections that are
//! kept: they live on when a socket's file is removed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rts_manager_api::client::Client;
use rts_manager_api::control::{ComponentInfo, RequestBody, ResponseBody};
use rts_manager_api::files::CONTROL_SOCKET;

use super::excuses::Shared;
use super::journal::Journal;
use super::judge::{Judge, Look};
use super::table::{Manager, managers};

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(60);
/// A manager that does not answer in this time is looked at the next time.
const PATIENCE: Duration = Duration::from_millis(300);
/// A look that takes longer than this says that the machine is too slow to judge samples.
const SLOW: Duration = Duration::from_millis(800);
/// How long samples are not judged after that.
const REST: Duration = Duration::from_secs(3);

/// The watcher.
pub struct Watcher {
    shared: Arc<Common>,
    thread: Option<JoinHandle<()>>,
}

struct Common {
    home: PathBuf,
    excuses: Shared,
    journal: Journal,
    judge: Mutex<Judge>,
    violations: Mutex<Vec<String>>,
    last: Mutex<Vec<(Manager, Option<Vec<ComponentInfo>>)>>,
    looks: AtomicU64,
    ends: AtomicBool,
}

impl Watcher {
    /// Begins to look.
    pub fn start(home: &Path, excuses: &Shared, journal: &Journal) -> Self {
        let shared = Arc::new(Common {
            home: home.to_owned(),
            excuses: excuses.clone(),
            journal: journal.clone(),
            judge: Mutex::default(),
            violations: Mutex::default(),
            last: Mutex::default(),
            looks: AtomicU64::new(0),
            ends: AtomicBool::new(false),
        });
        let own = Arc::clone(&shared);
        let thread = std::thread::spawn(move || own.run());
        Self {
            shared,
            thread: Some(thread),
        }
    }

    /// What was found so far.
    pub fn violations(&self) -> Vec<String> {
        lock(&self.shared.violations).clone()
    }

    /// True once something was found, or the thread is no more.
    pub fn has_found(&self) -> bool {
        let ended = self.thread.as_ref().is_none_or(JoinHandle::is_finished);
        ended || !lock(&self.shared.violations).is_empty()
    }

    /// What the last look saw.
    pub fn last(&self) -> Vec<(Manager, Option<Vec<ComponentInfo>>)> {
        lock(&self.shared.last).clone()
    }

    /// Instances that were last seen in this process.
    pub fn instances_of(&self, pid: u32) -> Vec<String> {
        lock(&self.shared.judge).instances_of(pid)
    }

    /// Waits until a look that begins after this call has ended, at most 10 s.
    pub fn look_anew(&self) {
        let until = self.shared.looks.load(Ordering::SeqCst) + 2;
        let deadline = Instant::now() + Duration::from_secs(10);
        while self.shared.looks.load(Ordering::SeqCst) < until
            && Instant::now() < deadline
            && self
                .thread
                .as_ref()
                .is_some_and(|thread| !thread.is_finished())
        {
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// From now on everything that changes is a violation again.
    pub fn forgive_no_more(&self) {
        self.look_anew();
        lock(&self.shared.judge).forget_stalls();
        self.shared.excuses.clear();
    }

    /// Ends it.
    pub fn stop(&mut self) {
        self.shared.ends.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            lock(&self.shared.violations).push("the watcher itself failed".to_owned());
        }
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        self.stop();
    }
}

impl Common {
    fn run(&self) {
        let mut clients = BTreeMap::new();
        let mut rested = Instant::now();
        let mut before = Instant::now();
        while !self.ends.load(Ordering::SeqCst) {
            let managers = self.look(&mut clients);
            let at = Instant::now();
            if at.duration_since(before) > SLOW {
                rested = at + REST;
            }
            before = at;
            let look = Look {
                at,
                managers,
                on_time: at >= rested,
            };
            self.judge(&look, &mut clients);
            self.journal.count_look(look.on_time);
            *lock(&self.last) = look.managers;
            self.looks.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(PAUSE);
        }
    }

    fn look(&self, clients: &mut Clients) -> Vec<(Manager, Option<Vec<ComponentInfo>>)> {
        let live = managers(&self.home);
        clients.retain(|key, _| live.iter().any(|m| (m.pid, m.ticks) == *key));
        let ask = |manager: Manager| {
            let answer = ask(clients, &manager);
            (manager, answer)
        };
        live.into_iter().map(ask).collect()
    }

    fn judge(&self, look: &Look, clients: &mut Clients) {
        let excuses = self.excuses.now();
        let mut found = lock(&self.judge).judge(look, &excuses);
        // A look is no moment: two that were not there at the same time are seen in it as two.
        found.retain(|text| !text.starts_with("two live ") || still_twins(look, clients));
        if found.is_empty() {
            return;
        }
        let mut violations = lock(&self.violations);
        for text in found {
            if !violations.contains(&text) && violations.len() < 20 {
                self.journal.note(&format!("VIOLATION: {text}"));
                violations.push(text);
            }
        }
    }
}

type Clients = BTreeMap<(u32, u64), Client>;

fn ask(clients: &mut Clients, manager: &Manager) -> Option<Vec<ComponentInfo>> {
    if manager.stopped {
        return None;
    }
    let key = (manager.pid, manager.ticks);
    let mut client = match clients.remove(&key) {
        Some(client) => client,
        None => Client::connect(&manager.folder.join(CONTROL_SOCKET), PATIENCE).ok()?,
    };
    if client.hello().pid != manager.pid {
        return None;
    }
    let ResponseBody::Inventory(inventory) = client.call(RequestBody::Inventory, PATIENCE).ok()?
    else {
        return None;
    };
    clients.insert(key, client);
    Some(inventory.components)
}

/// True when, after the look, all that it saw is still there: both were there when the second was seen.
fn still_twins(look: &Look, clients: &mut Clients) -> bool {
    for (at, (manager, components)) in look.managers.iter().enumerate() {
        for (other, others) in &look.managers[at + 1..] {
            if manager.key() == other.key() && manager.lives() && other.lives() {
                return true;
            }
            let both: Vec<_> = components
                .iter()
                .flatten()
                .filter(|c| others.iter().flatten().any(|o| o.instance == c.instance))
                .collect();
            if both.is_empty() {
                continue;
            }
            let again = ask(clients, manager).unwrap_or_default();
            let mut again = again.iter();
            if again.any(|now| both.iter().any(|then| then.incarnation == now.incarnation)) {
                return true;
            }
        }
    }
    false
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
