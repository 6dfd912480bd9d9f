//! The zygote of this agent: a process of the manager program with one thread, whose copies become managers.
//!
//! Nothing depends on it: its copies are children of this process, and a manager can be spawned without it.

use std::collections::VecDeque;
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rts_host::process::number;
use rts_manager_api::passing;
use rts_manager_api::zygote::{Fork, FromZygote, MAX_DATAGRAM, ZYGOTE_VERSION, decode};
use rustix::net::{AddressFamily, SocketFlags, SocketType, socketpair};
use rustix::process::{Signal, pidfd_send_signal, setpgid};
use tokio::io::Interest;
use tokio::net;
use tokio::sync::{oneshot, watch};
use tokio::time::timeout;

use super::child::{Child, end, reap};
use super::launch::Born;
use super::pidfd::PidFd;
use super::spawn::environment;
use crate::events::lock;

/// How long a fork may take before the zygote counts as dead.
const FORK: Duration = Duration::from_secs(2);
/// Room for the command lines of its copies, in bytes.
const ROOM: usize = 1024;

/// What is told to who asked for a copy.
type Answer = Result<(u32, OwnedFd, bool), String>;

/// A zygote that was started.
#[derive(Debug)]
pub(super) struct Zygote {
    /// Of datagrams.
    socket: net::UnixStream,
    pid: u32,
    pidfd: Arc<PidFd>,
    /// Those who wait for their copies, in order; none when it takes no orders any more.
    waiting: Mutex<Option<VecDeque<oneshot::Sender<Answer>>>>,
    /// It has said that it takes orders.
    ready: watch::Sender<bool>,
}

impl Zygote {
    /// Starts one, and does not wait for it.
    pub fn start(program: &Path, home: &Path) -> io::Result<Arc<Self>> {
        let flags = SocketFlags::CLOEXEC;
        let (ours, theirs) = socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None)?;
        let mut child = Command::new(program)
            .args(["--zygote", "--home"])
            .arg(home)
            .args(["--room", &"x".repeat(ROOM)])
            .env_clear()
            .envs(environment())
            .current_dir("/")
            .process_group(0)
            .stdin(Stdio::from(theirs))
            .stdout(Stdio::null())
            .spawn()?;
        let watched = PidFd::open(child.id(), None).and_then(|pidfd| {
            let socket = UnixStream::from(ours);
            socket.set_nonblocking(true)?;
            Ok(Self {
                socket: net::UnixStream::from_std(socket)?,
                pid: child.id(),
                pidfd: Arc::new(pidfd),
                waiting: Mutex::new(Some(VecDeque::new())),
                ready: watch::Sender::new(false),
            })
        });
        match watched {
            Ok(zygote) => Ok(Arc::new(zygote)),
            Err(e) => {
                let _ = child.kill();
                let _ = child.wait();
                Err(e)
            }
        }
    }

    /// Reads what it says until its end, and gives the reason of that.
    pub async fn serve(&self) -> String {
        let why = match self.read().await {
            Ok(()) => "it has ended".to_owned(),
            Err(e) => e.to_string(),
        };
        self.kill();
        // Those who wait are told by this.
        lock(&self.waiting).take();
        let exit = end(self.pid, self.pidfd.clone()).await;
        format!("{why} ({exit})")
    }

    async fn read(&self) -> io::Result<()> {
        let mut datagram = [0; MAX_DATAGRAM];
        loop {
            let received = || passing::receive(&self.socket, &mut datagram);
            let (length, files) = self.socket.async_io(Interest::READABLE, received).await?;
            if length == 0 {
                return Ok(());
            }
            match decode(&datagram[..length])? {
                FromZygote::Ready { version } if version == ZYGOTE_VERSION => {
                    self.ready.send_replace(true);
                }
                FromZygote::Ready { version } => {
                    let text = format!("it speaks version {version}, this agent {ZYGOTE_VERSION}");
                    return Err(io::Error::other(text));
                }
                FromZygote::Forked { pid, in_cgroup } => {
                    let pidfd = files.into_iter().next();
                    let pidfd = pidfd.ok_or_else(|| io::Error::other("a copy without a pidfd"))?;
                    self.answer(Ok((pid, pidfd, in_cgroup)))?;
                }
                FromZygote::Failed { reason } => self.answer(Err(reason))?,
            }
        }
    }

    fn answer(&self, answer: Answer) -> io::Result<()> {
        let asked = lock(&self.waiting).as_mut().and_then(VecDeque::pop_front);
        let asked = asked.ok_or_else(|| io::Error::other("a copy that nobody asked for"))?;
        if let Err(Ok((pid, pidfd, _))) = asked.send(answer) {
            // Who asked has given up, and closed its connection: it ends.
            if let Ok(pidfd) = PidFd::of(pidfd) {
                reap(pid, Arc::new(pidfd));
            }
        }
        Ok(())
    }

    /// True once it takes orders.
    pub fn is_ready(&self) -> bool {
        *self.ready.borrow()
    }

    /// Waits until it takes orders; false when it never will.
    pub async fn ready(&self, limit: Duration) -> bool {
        let mut ready = self.ready.subscribe();
        let ready = timeout(limit, ready.wait_for(|ready| *ready)).await;
        matches!(ready, Ok(Ok(_)))
    }

    /// Has a copy made, in a control group if one is given and that can be. Unless it `waits`, it is told at once who it is.
    /// A zygote that does not answer is killed.
    pub async fn fork(&self, cgroup: Option<&File>, waits: bool) -> io::Result<Born> {
        let (ours, theirs) = UnixStream::pair()?;
        ours.set_nonblocking(true)?;
        let answer = self.order(&theirs, cgroup, waits)?;
        drop(theirs);
        let Ok(answered) = timeout(FORK, answer).await else {
            self.kill();
            return Err(io::ErrorKind::TimedOut.into());
        };
        let gone = |_| io::Error::other("it has ended");
        let (pid, pidfd, in_cgroup) = answered.map_err(gone)?.map_err(io::Error::other)?;
        let child = Child {
            pid,
            control: ours,
            pidfd: Arc::new(PidFd::of(pidfd)?),
        };
        // The copy does so as well; whoever comes first, its group is there when somebody ends it.
        if let Ok(number) = number(pid) {
            let _ = setpgid(Some(number), Some(number));
        }
        Ok(Born { child, in_cgroup })
    }

    /// Sends an order. Under the lock, so that answers come in the order of those who wait.
    fn order(
        &self,
        control: &UnixStream,
        cgroup: Option<&File>,
        waits: bool,
    ) -> io::Result<oneshot::Receiver<Answer>> {
        let order = Fork {
            cgroup: cgroup.is_some(),
            waits,
        };
        let order = serde_json::to_vec(&order)?;
        let mut files = vec![control.as_fd()];
        files.extend(cgroup.map(AsFd::as_fd));
        let (asked, answer) = oneshot::channel();
        let mut waiting = lock(&self.waiting);
        let waiting = waiting.as_mut();
        let waiting = waiting.ok_or_else(|| io::Error::other("it has ended"))?;
        passing::send(&self.socket, &order, &files)?;
        waiting.push_back(asked);
        Ok(answer)
    }

    /// Ends it.
    pub fn kill(&self) {
        // One that has ended already is fine.
        let _ = pidfd_send_signal(self.pidfd.as_fd(), Signal::KILL);
    }
}
