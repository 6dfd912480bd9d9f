//! What keeps processes ready to become managers: the zygote, and a few of its copies that wait with their threads
//! running. All of them end with this process, and none of them is a manager.
//!
//! One that waits is born in a control group of its own where that can be: to move one that lives already stops the forks
//! and exits of the whole machine, and takes longer than a birth and all that a new copy does.

mod keep;
mod stamp;

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rts_host::cgroup::Cgroup;
use tokio::sync::Notify;
use tokio::task::spawn_blocking;

use super::child::{Child, end};
use super::groups::Groups;
use super::launch::Born;
use super::zygote::Zygote;
use crate::events::lock;
use stamp::Stamp;

/// How long those that wait may take to end with this process.
const LAST: Duration = Duration::from_millis(200);

/// Where processes are kept ready.
#[derive(Debug)]
pub(super) struct Nursery {
    program: PathBuf,
    /// Shown by `ps`.
    home: PathBuf,
    /// How many are to be ready.
    wanted: usize,
    groups: Arc<Groups>,
    state: Mutex<State>,
    /// Rings when there may be something to do.
    bell: Notify,
}

/// A process that is ready.
#[derive(Debug)]
pub(super) struct Ready {
    pub child: Child,
    /// Where it was born; none where there is none, or it was not to be had.
    pub cgroup: Option<Cgroup>,
}

impl Ready {
    /// Lets it go: it ends with its connection, is reaped, and its group is removed.
    pub fn let_go(self, groups: &Arc<Groups>) {
        let (Child { pid, pidfd, .. }, cgroup) = (self.child, self.cgroup);
        let groups = groups.clone();
        tokio::spawn(async move {
            end(pid, pidfd).await;
            if let Some(cgroup) = cgroup {
                // It cannot panic.
                let _ = spawn_blocking(move || groups.remove(&cgroup)).await;
            }
        });
    }
}

#[derive(Debug, Default)]
struct State {
    zygote: Option<Arc<Zygote>>,
    /// The program that it was started from.
    stamp: Option<Stamp>,
    idle: Vec<Ready>,
    /// Batches that run: nothing is made ready meanwhile.
    working: usize,
    /// One that was ready has ended.
    died: bool,
    /// Nothing is kept any more.
    closed: bool,
}

/// What there is to do.
struct Wants {
    /// One more is to be made ready.
    more: bool,
    /// One has ended since the last look.
    died: bool,
}

impl State {
    /// Lets all go that was started from another program than the one that is there now.
    fn refresh(&mut self, program: &Path, groups: &Arc<Groups>) {
        if self.zygote.is_some() && Stamp::of(program) != self.stamp {
            tracing::info!(
                "{} was exchanged: its zygote is replaced",
                program.display()
            );
            self.clear(groups);
        }
    }

    fn clear(&mut self, groups: &Arc<Groups>) {
        if let Some(zygote) = self.zygote.take() {
            zygote.kill();
        }
        let idle = self.idle.drain(..);
        idle.for_each(|ready| ready.let_go(groups));
    }
}

impl Nursery {
    /// Begins to keep so many ready, in the background, until it is closed.
    pub fn open(program: &Path, home: &Path, groups: Arc<Groups>, wanted: u8) -> Arc<Self> {
        let nursery = Arc::new(Self {
            program: program.to_owned(),
            home: home.to_owned(),
            wanted: wanted.into(),
            groups,
            state: Mutex::default(),
            bell: Notify::new(),
        });
        tokio::spawn(keep::keep(nursery.clone()));
        nursery
    }

    /// The control groups of the node.
    pub fn groups(&self) -> &Arc<Groups> {
        &self.groups
    }

    /// One that is ready, in a control group of its own or in none.
    pub fn take(&self, in_group: bool) -> Option<Ready> {
        let mut state = lock(&self.state);
        state.refresh(&self.program, &self.groups);
        let fits = |ready: &Ready| ready.cgroup.is_some() == in_group;
        let at = state.idle.iter().position(fits)?;
        let ready = state.idle.swap_remove(at);
        drop(state);
        self.bell.notify_one();
        Some(ready)
    }

    /// A new copy, in a control group if one is given and that can be; none when the zygote makes none.
    pub async fn fork(&self, cgroup: Option<&File>) -> Option<Born> {
        let zygote = {
            let mut state = lock(&self.state);
            state.refresh(&self.program, &self.groups);
            state.zygote.clone().filter(|zygote| zygote.is_ready())
        };
        let forked = zygote?.fork(cgroup, false).await;
        let refused = |e| tracing::warn!("the zygote makes no manager, so it is spawned: {e}");
        forked.map_err(refused).ok()
    }

    /// A batch begins or ends.
    pub fn work(&self, begins: bool) {
        let mut state = lock(&self.state);
        match begins {
            true => state.working += 1,
            false => state.working = state.working.saturating_sub(1),
        }
        drop(state);
        self.bell.notify_one();
    }

    /// Lets all go, and makes nothing ready any more.
    pub fn close(&self) {
        let mut state = lock(&self.state);
        state.closed = true;
        let cgroups: Vec<_> = state.idle.iter().filter_map(|r| r.cgroup.clone()).collect();
        state.clear(&self.groups);
        drop(state);
        // Now: nobody of this process may be there to do it later.
        for cgroup in cgroups {
            if cgroup.kill_within(LAST) {
                self.groups.remove(&cgroup);
            }
        }
        self.bell.notify_one();
    }

    /// Starts a zygote; none when it is closed.
    fn begin(&self) -> io::Result<Option<Arc<Zygote>>> {
        let mut state = lock(&self.state);
        if state.closed {
            return Ok(None);
        }
        // Taken before: a program that is exchanged meanwhile is another one at the next look.
        state.stamp = Stamp::of(&self.program);
        let zygote = Zygote::start(&self.program, &self.home)?;
        state.zygote = Some(zygote.clone());
        Ok(Some(zygote))
    }

    /// A zygote has ended. True when it was not told to.
    fn leaves(&self, zygote: &Arc<Zygote>) -> bool {
        let mut state = lock(&self.state);
        let own = state.zygote.as_ref();
        let is_own = own.is_some_and(|own| Arc::ptr_eq(own, zygote));
        if is_own {
            state.zygote = None;
        }
        is_own
    }

    fn wants(&self) -> Wants {
        let mut state = lock(&self.state);
        state.refresh(&self.program, &self.groups);
        Wants {
            more: state.working == 0 && !state.closed && state.idle.len() < self.wanted,
            died: std::mem::take(&mut state.died),
        }
    }

    /// A process has ended. If it was ready, another one takes its place.
    fn died(&self, pid: u32) {
        let mut state = lock(&self.state);
        let Some(at) = state.idle.iter().position(|ready| ready.child.pid == pid) else {
            return;
        };
        state.idle.swap_remove(at).let_go(&self.groups);
        state.died = true;
        drop(state);
        self.bell.notify_one();
    }
}
