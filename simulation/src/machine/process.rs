//! The beginning of a manager's process: it takes its folder, describes itself there, and serves.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use rts_agent::launch::{Exit, LaunchError, Start};
use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::control::{Hello, SystemId};
use rts_manager_api::files::ManagerFile;
use tokio::io::DuplexStream;
use tokio::sync::watch;
use tokio::time::{Instant, sleep};

use super::Shared;
use super::connection;
use super::handle::Handle;
use super::state::{Folder, Process, Run, State};
use crate::life::Life;
use crate::truth::{Cause, Happened};

/// Time from its start until it serves, in microseconds.
const START: (u64, u64) = (2_000, 40_000);
/// How often it looks after its files.
const WATCH: Duration = Duration::from_secs(1);
/// Longest log in bytes.
const MAX_LOG: usize = 64 * 1024;
/// Name of the program, for errors.
const PROGRAM: &str = "rts-manager (simulated)";

/// Makes the process, which then goes its own way. `first` is its end of the connection to whoever starts it.
pub(super) fn start(
    shared: &Arc<Shared>,
    start: &Start,
    first: DuplexStream,
    life: Life,
) -> Result<Handle, LaunchError> {
    let (incarnation, started) = (start.incarnation.clone(), shared.now());
    let (child, fails) = shared.change(|state| {
        let child = shared.streams.faults.chance(state.grandchildren);
        (child, state.fails_to_start)
    });
    let handle = shared.change(|state| {
        if !state.folders.contains_key(&start.folder) {
            let source = std::io::Error::from(std::io::ErrorKind::NotFound);
            let what = PROGRAM.to_owned();
            return Err(LaunchError { what, source });
        }
        state.pid += 1;
        let number = state.number();
        let system = start.key.system.as_ref().map(|system| SystemId {
            name: system.name.clone(),
            uid: system.uid.clone(),
        });
        let process = Process {
            number,
            key: start.key.clone(),
            hello: Hello {
                version: PROTOCOL_VERSION,
                system,
                name: start.key.name.clone(),
                incarnation: incarnation.clone(),
                pid: state.pid,
                started,
            },
            start_ticks: shared.truth.now().as_millis() as u64 / 10,
            folder: start.folder.clone(),
            serves: false,
            run: watch::Sender::new(Run::Runs),
            stopping: false,
            grandchildren: u32::from(child),
            blemished: false,
            ended: None,
            modules: BTreeMap::new(),
            opened: BTreeMap::new(),
            stamps: BTreeMap::new(),
            components: BTreeMap::new(),
            ends: BTreeMap::new(),
            listeners: Vec::new(),
        };
        let handle = Handle::new(shared.clone(), &process);
        state.processes.insert(number, process);
        state.news.push(Happened::ProcessStarted {
            node: state.node.clone(),
            manager: start.key.clone(),
            process: incarnation.clone(),
        });
        if fails {
            state.blemish(number, None, "it cannot start".to_owned());
        }
        Ok(handle)
    })?;
    let serve = serve(handle.clone(), start.clone(), first, life, fails);
    handle.spawn(serve);
    Ok(handle)
}

/// What the process does until it ends.
async fn serve(handle: Handle, start: Start, first: DuplexStream, life: Life, fails: bool) {
    handle.work(START.0, START.1).await;
    let number = handle.number;
    if fails {
        handle.change(|state| {
            state.log(&start, "ERROR it cannot start (simulated)");
            state.end(number, Exit::Code(1), Cause::Fault);
        });
    }
    handle.runs().await;
    if !handle.change(|state| state.take_folder(number)) {
        handle.change(|state| {
            state.log(&start, "ERROR its folder is held by another manager");
            state.end(number, Exit::Code(1), Cause::Asked);
        });
    }
    handle.runs().await;
    connection::open(&handle, first, life);
    loop {
        sleep(WATCH).await;
        handle.runs().await;
        handle.change(|state| state.take_folder(number));
    }
}

impl State {
    /// Takes the lock of its folder and describes itself there, unless that is done; false when another one has it.
    fn take_folder(&mut self, number: u64) -> bool {
        let Some(process) = self.living(number) else {
            return false;
        };
        if process.stopping {
            return process.serves;
        }
        let folder = process.folder.clone();
        let others = |tenant: &Process| tenant.number != number;
        if self.tenant(&folder).is_some_and(others) {
            return false;
        }
        let boot_id = self.boot_id.clone();
        let Some(process) = self.living(number) else {
            return false;
        };
        process.serves = true;
        let file = process.describe(boot_id);
        let found = self.folders.entry(folder).or_insert_with(Folder::new);
        if found.file.as_ref() != Some(&file) {
            found.changed = Instant::now();
            found.file = Some(file);
        }
        true
    }

    /// Adds a line to the log of a start.
    pub fn log(&mut self, start: &Start, line: &str) {
        let log = self.logs.entry(start.log.clone()).or_default();
        if log.len() > MAX_LOG {
            log.clear();
        }
        log.push_str(line);
        log.push('\n');
    }
}

impl Folder {
    /// An empty one.
    pub fn new() -> Self {
        Self {
            changed: Instant::now(),
            file: None,
        }
    }
}

impl Process {
    /// What its file says.
    fn describe(&self, boot_id: String) -> ManagerFile {
        ManagerFile {
            protocol_version: self.hello.version,
            system: self.hello.system.clone(),
            name: self.hello.name.clone(),
            incarnation: self.hello.incarnation.clone(),
            pid: self.hello.pid,
            start_ticks: self.start_ticks,
            boot_id,
            started: self.hello.started.clone(),
            cgroup: None,
        }
    }
}
