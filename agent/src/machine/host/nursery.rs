//! What keeps processes ready to become managers: the zygote, and a few of its copies that wait with their threads
//! running. All of them end with this process, and none of them is a manager.
//!
//! Where a process can be born in its control group, none waits: to move one there that lives already stops the forks and
//! exits of the whole machine, and takes longer than a birth and all that a new copy does.

mod keep;
mod stamp;

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use rts_host::cgroup::{Cgroups, Version};
use tokio::sync::Notify;

use super::child::Child;
use super::launch::Born;
use super::zygote::Zygote;
use crate::events::lock;
use stamp::Stamp;

/// Name of a control group that no manager has.
const PROBE: &str = "probe";

/// Where processes are kept ready.
#[derive(Debug)]
pub(super) struct Nursery {
    program: PathBuf,
    /// Shown by `ps`.
    home: PathBuf,
    /// How many are to be ready, where that is of use.
    wanted: usize,
    /// The control groups of the home.
    cgroups: Cgroups,
    state: Mutex<State>,
    /// Rings when there may be something to do.
    bell: Notify,
}

#[derive(Debug, Default)]
struct State {
    zygote: Option<Arc<Zygote>>,
    /// The program that it was started from.
    stamp: Option<Stamp>,
    idle: Vec<Child>,
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
    fn refresh(&mut self, program: &Path) {
        if self.zygote.is_some() && Stamp::of(program) != self.stamp {
            tracing::info!(
                "{} was exchanged: its zygote is replaced",
                program.display()
            );
            self.clear();
        }
    }

    fn clear(&mut self) {
        if let Some(zygote) = self.zygote.take() {
            zygote.kill();
        }
        self.idle.drain(..).for_each(Child::let_go);
    }
}

impl Nursery {
    /// Begins to keep so many ready, in the background, until it is closed.
    pub fn open(program: &Path, home: &Path, cgroups: Cgroups, wanted: u8) -> Arc<Self> {
        let nursery = Arc::new(Self {
            program: program.to_owned(),
            home: home.to_owned(),
            wanted: wanted.into(),
            cgroups,
            state: Mutex::default(),
            bell: Notify::new(),
        });
        tokio::spawn(keep::keep(nursery.clone()));
        nursery
    }

    /// One that is ready.
    pub fn idle(&self) -> Option<Child> {
        let mut state = lock(&self.state);
        state.refresh(&self.program);
        let child = state.idle.pop();
        drop(state);
        self.bell.notify_one();
        child
    }

    /// A new copy, in a control group if one is given and that can be; none when the zygote makes none.
    pub async fn fork(&self, cgroup: Option<&File>) -> Option<Born> {
        let zygote = {
            let mut state = lock(&self.state);
            state.refresh(&self.program);
            state.zygote.clone().filter(|zygote| zygote.is_ready())
        };
        let forked = zygote?.fork(cgroup).await;
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
        state.clear();
        drop(state);
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

    /// True where processes can be born in their control groups. Asked once, before any waits: blocks.
    fn bears_in_groups(&self) -> bool {
        self.cgroups.create(PROBE).is_ok_and(|probe| {
            // Should it stay, it is empty, and goes with the others.
            let _ = probe.remove();
            probe.version() == Version::V2
        })
    }

    fn wants(&self) -> Wants {
        let mut state = lock(&self.state);
        state.refresh(&self.program);
        Wants {
            more: state.working == 0 && !state.closed && state.idle.len() < self.wanted,
            died: std::mem::take(&mut state.died),
        }
    }

    /// A process has ended. If it was ready, another one takes its place.
    fn died(&self, pid: u32) {
        let mut state = lock(&self.state);
        let Some(at) = state.idle.iter().position(|child| child.pid == pid) else {
            return;
        };
        state.idle.swap_remove(at).let_go();
        state.died = true;
        drop(state);
        self.bell.notify_one();
    }
}
