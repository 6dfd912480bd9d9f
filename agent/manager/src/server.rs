//! The life of the process: take the run folder, accept connections, watch the socket, end in order.

use std::io::{self, Read};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use jiff::Timestamp;
use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::control::Hello;
use rts_manager_api::files::CONTROL_SOCKET;
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};
use rustix::fs::{FileType, Mode, OFlags};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::args::Settings;
use crate::manager::{Leftovers, MAX_CONTROLS, MAX_INCOMING, Manager, Threads};
use crate::own_log::OwnLog;
use crate::pool::Full;
use crate::requests::shutdown;
use crate::run_dir::{RunDir, RunDirError};
use crate::slots::Slots;
use crate::{connection, log};

/// How often the socket's file is looked at.
const WATCH: Duration = Duration::from_secs(1);
/// Time for an orderly end after SIGTERM.
const GRACE: Duration = Duration::from_secs(3);

/// A manager that cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The run folder cannot be used.
    #[error(transparent)]
    RunDir(#[from] RunDirError),
    /// The process cannot be set up.
    #[error("cannot {0}: {1}")]
    Process(&'static str, io::Error),
}

/// What all connections share.
pub struct Shared {
    /// The manager.
    pub manager: Arc<Manager>,
    /// Control connections.
    pub controls: Slots,
    /// Incoming data connections.
    pub incoming: Slots,
    end: OwnedFd,
}

impl Shared {
    /// Lets the process end, after its components have.
    pub fn end(&self) {
        // Fails only when it is signalled already.
        let _ = rustix::io::write(&self.end, &1_u64.to_ne_bytes());
    }
}

/// Serves until a signal or a request ends it.
pub fn run(settings: Settings) -> Result<Leftovers, ServeError> {
    let parent = take_stdin().map_err(process("take standard input over"))?;
    Waiting::prepare()?.serve(settings, parent)
}

/// What went wrong with the process itself.
pub fn process(what: &'static str) -> impl FnOnce(io::Error) -> ServeError {
    move |error| ServeError::Process(what, error)
}

/// A process that is ready to be a manager, whichever.
pub struct Waiting {
    signals: Signals,
    threads: Threads,
    end: OwnedFd,
}

impl Waiting {
    /// Does all that needs no name.
    pub fn prepare() -> Result<Self, ServeError> {
        // Each connection is a file descriptor.
        if let Err(error) = rts_host::limits::try_raise_open_files() {
            log::warn(format_args!(
                "the limit of open files stays as it is: {error}"
            ));
        }
        Ok(Self {
            signals: Signals::listen().map_err(process("listen to signals"))?,
            threads: Threads::new(),
            end: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)
                .map_err(|e| ServeError::Process("make an event", e.into()))?,
        })
    }

    /// Starts the threads that are wanted sooner or later.
    pub fn start_threads(&self) {
        self.threads.prepare();
    }

    /// Becomes readable when a signal wants the end.
    pub fn ends(&self) -> &UnixStream {
        &self.signals.end
    }

    /// Is this manager until a signal or a request ends it. `first` is a connection that is open already.
    pub fn serve(
        self,
        settings: Settings,
        first: Option<UnixStream>,
    ) -> Result<Leftovers, ServeError> {
        // Before anybody can know that this process runs, and move its log away.
        let own_log = OwnLog::of_this_process();
        let hello = Hello {
            version: PROTOCOL_VERSION,
            system: settings.system,
            name: settings.name,
            incarnation: settings.incarnation,
            pid: std::process::id(),
            started: format!("{:.3}", Timestamp::now()),
        };
        let mut run_dir = RunDir::take(&settings.dir, &hello, settings.cgroup)?;
        let socket = settings.dir.join(CONTROL_SOCKET);
        let shared = Arc::new(Shared {
            manager: Arc::new(Manager::new(hello, socket, self.threads)),
            controls: Slots::new(MAX_CONTROLS),
            incoming: Slots::new(MAX_INCOMING),
            end: self.end,
        });
        if let Some(stream) = first {
            admit(stream, &shared);
        }
        if serve(&mut run_dir, &shared, &self.signals, &own_log)? == Ended::Signal {
            log::info(format_args!("a signal ends this manager"));
            shutdown::shutdown(&shared.manager, Instant::now() + GRACE);
        }
        run_dir.leave();
        Ok(shared.manager.leftovers())
    }
}

#[derive(PartialEq, Eq)]
enum Ended {
    Signal,
    Request,
}

fn serve(
    run_dir: &mut RunDir,
    shared: &Arc<Shared>,
    signals: &Signals,
    own_log: &OwnLog,
) -> Result<Ended, ServeError> {
    let mut watched = Instant::now();
    loop {
        let wait = WATCH.saturating_sub(watched.elapsed());
        let mut fds = [
            PollFd::new(run_dir.listener(), PollFlags::IN),
            PollFd::new(&signals.end, PollFlags::IN),
            PollFd::new(&signals.reopen, PollFlags::IN),
            PollFd::new(&shared.end, PollFlags::IN),
        ];
        let timeout = Timespec::try_from(wait).unwrap_or(Timespec {
            tv_sec: 1,
            tv_nsec: 0,
        });
        match poll(&mut fds, Some(&timeout)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(ServeError::Process("wait for connections", error.into())),
        }
        let [connections, signal, hang_up, end] = fds.map(|fd| !fd.revents().is_empty());
        if end {
            return Ok(Ended::Request);
        }
        if signal {
            return Ok(Ended::Signal);
        }
        if hang_up {
            signals.calm();
            reopen(own_log);
        }
        if connections {
            accept(run_dir, shared);
        }
        if watched.elapsed() >= WATCH {
            rotate(own_log);
            // Whoever ends it may be removing the folder already.
            if !shared.manager.is_stopping() {
                run_dir.repair();
                shared.manager.watch();
            }
            watched = Instant::now();
        }
    }
}

fn accept(run_dir: &RunDir, shared: &Arc<Shared>) {
    match run_dir.listener().accept() {
        Ok((stream, _)) => {
            if stream.set_nonblocking(false).is_ok() {
                admit(stream, shared);
            }
        }
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
        Err(error) => {
            log::warn(format_args!("a connection could not be accepted: {error}"));
            // Out of file descriptors, most likely: it stays ready, so do not spin.
            thread::sleep(Duration::from_millis(50));
        }
    }
}

/// Gives a connection its thread.
fn admit(stream: UnixStream, shared: &Arc<Shared>) {
    let may_grow = shared.manager.may_start_threads();
    let job = {
        let shared = Arc::clone(shared);
        move || connection::serve(stream, &shared)
    };
    if let Err(Full) = shared.manager.connections.run(may_grow, 0, job) {
        log::warn(format_args!("a connection was closed: too many are open"));
    }
}

/// A socket as standard input is a connection that the parent has open already.
pub fn take_stdin() -> io::Result<Option<UnixStream>> {
    let stdin = rustix::stdio::stdin();
    let Ok(stat) = rustix::fs::fstat(stdin) else {
        return Ok(None);
    };
    if FileType::from_raw_mode(stat.st_mode) != FileType::Socket {
        return Ok(None);
    }
    let socket = rustix::io::fcntl_dupfd_cloexec(stdin, 3)?;
    let null = rustix::fs::open("/dev/null", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())?;
    rustix::stdio::dup2_stdin(&null)?;
    let stream = UnixStream::from(socket);
    stream.set_nonblocking(false)?;
    Ok(Some(stream))
}

/// Streams that become readable at a signal. SIGPIPE is ignored by Rust's start-up code.
struct Signals {
    /// SIGTERM and SIGINT.
    end: UnixStream,
    /// SIGHUP.
    reopen: UnixStream,
}

impl Signals {
    fn listen() -> io::Result<Self> {
        let (end, write) = UnixStream::pair()?;
        signal_hook::low_level::pipe::register(SIGTERM, write.try_clone()?)?;
        signal_hook::low_level::pipe::register(SIGINT, write)?;
        let (reopen, write) = UnixStream::pair()?;
        reopen.set_nonblocking(true)?;
        signal_hook::low_level::pipe::register(SIGHUP, write)?;
        Ok(Self { end, reopen })
    }

    /// Takes note of SIGHUP.
    fn calm(&self) {
        while (&self.reopen).read(&mut [0; 64]).is_ok_and(|n| n > 0) {}
    }
}

/// Opens the log anew after somebody else has moved it away.
fn reopen(own_log: &OwnLog) {
    match own_log.reopen() {
        Ok(()) => log::info(format_args!("the log was opened anew")),
        Err(error) => log::warn(format_args!("the log cannot be opened anew: {error}")),
    }
}

/// Exchanges the log when it is full.
fn rotate(own_log: &OwnLog) {
    match own_log.rotate() {
        Ok(true) => log::info(format_args!(
            "the log was full; what came before is in its .1"
        )),
        Ok(false) => {}
        Err(error) => log::warn(format_args!("the full log cannot be opened anew: {error}")),
    }
}
