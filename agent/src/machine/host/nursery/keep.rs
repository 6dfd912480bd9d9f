//! Starting what is to be ready, when nothing else is to be done.

use std::fs::File;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::task::spawn_blocking;
use tokio::time::{Instant, sleep, sleep_until};

use super::{Nursery, Ready, Zygote};
use crate::events::lock;

/// From the end of a batch until new ones are made ready: whoever sent it looks at what it did, or sends the next one, and
/// should not wait.
const CALM: Duration = Duration::from_millis(100);
/// How long a zygote may take to start.
const START: Duration = Duration::from_secs(5);
/// Shortest and longest pause after one that failed.
const PAUSES: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(60));
/// What lives for this long did not fail.
const SOUND: Duration = Duration::from_secs(60);

/// When the next try may be made. What ends again and again is started less and less often.
struct Patience {
    pause: Duration,
    next: Instant,
    tried: Instant,
}

impl Patience {
    fn new() -> Self {
        let now = Instant::now();
        Self {
            pause: PAUSES.0,
            next: now,
            tried: now,
        }
    }

    /// Waits for the time of the next try.
    async fn try_next(&mut self) {
        sleep_until(self.next).await;
        self.tried = Instant::now();
    }

    /// What was tried last has done its work for a good while.
    fn was_sound(&self) -> bool {
        self.tried.elapsed() >= SOUND
    }

    /// What was tried last has failed.
    fn failed(&mut self) {
        if self.was_sound() {
            self.pause = PAUSES.0;
        }
        self.next = Instant::now() + self.pause;
        self.pause = (self.pause * 2).min(PAUSES.1);
    }
}

/// Keeps a nursery until it is closed.
pub(super) async fn keep(nursery: Arc<Nursery>) {
    let groups = nursery.groups.clone();
    spawn_blocking(move || groups.sweep());
    let mut patience = Patience::new();
    let mut said = String::new();
    loop {
        patience.try_next().await;
        let failure = match nursery.begin() {
            Ok(Some(zygote)) => serve(&nursery, &zygote).await,
            Ok(None) => return,
            Err(e) => Some(e.to_string()),
        };
        if let Some(why) = failure {
            // Where there can be none, that is said once.
            if why != said || patience.was_sound() {
                tracing::warn!("no zygote, so managers are spawned until there is one: {why}");
                said = why;
            }
            patience.failed();
        }
    }
}

/// Serves a zygote to its end, and has it fill the nursery; gives why it failed, if it did.
async fn serve(nursery: &Arc<Nursery>, zygote: &Arc<Zygote>) -> Option<String> {
    let serving = zygote.serve();
    tokio::pin!(serving);
    let why = tokio::select! {
        why = &mut serving => why,
        why = fill(nursery, zygote) => {
            zygote.kill();
            format!("{why}; {}", serving.await)
        }
    };
    // Its copies wait on: they do not depend on it.
    nursery.leaves(zygote).then_some(why)
}

/// Makes copies ready as they are wanted, one after the other; ends with the reason when the zygote is of no use.
async fn fill(nursery: &Arc<Nursery>, zygote: &Arc<Zygote>) -> String {
    if !zygote.ready(START).await {
        return format!("it did not start within {} s", START.as_secs());
    }
    let mut patience = Patience::new();
    loop {
        let wants = nursery.wants();
        if wants.died {
            patience.failed();
        }
        if !wants.more {
            nursery.bell.notified().await;
            continue;
        }
        sleep(CALM).await;
        patience.try_next().await;
        // Something else may have begun meanwhile.
        if !nursery.wants().more {
            continue;
        }
        match bear(nursery, zygote).await {
            Ok(ready) => add(nursery, ready),
            Err(e) => {
                tracing::warn!("no manager can be kept ready: {e}");
                patience.failed();
            }
        }
    }
}

/// Makes one, in a control group of its own where that can be.
async fn bear(nursery: &Arc<Nursery>, zygote: &Zygote) -> io::Result<Ready> {
    let groups = nursery.groups.clone();
    let cgroup = spawn_blocking(move || groups.waiting()).await??;
    let folder = cgroup.as_ref().and_then(|c| File::open(c.path()).ok());
    let born = zygote.fork(folder.as_ref(), true).await;
    let in_group = born.as_ref().is_ok_and(|born| born.in_cgroup);
    let (cgroup, unused) = match in_group {
        true => (cgroup, None),
        false => (None, cgroup),
    };
    if let Some(unused) = unused {
        let groups = nursery.groups.clone();
        spawn_blocking(move || groups.remove(&unused)).await?;
    }
    Ok(Ready {
        child: born?.child,
        cgroup,
    })
}

/// Keeps one ready, and watches it.
fn add(nursery: &Arc<Nursery>, ready: Ready) {
    let (pid, pidfd) = (ready.child.pid, ready.child.pidfd.clone());
    {
        let mut state = lock(&nursery.state);
        if state.closed {
            return ready.let_go(&nursery.groups);
        }
        state.idle.push(ready);
    }
    let nursery = Arc::downgrade(nursery);
    tokio::spawn(async move {
        pidfd.ended().await;
        if let Some(nursery) = nursery.upgrade() {
            nursery.died(pid);
        }
    });
}
