//! What an agent asks of the machine of its node: run folders, manager processes, modules. The real one is `Host`; a
//! simulation passes its own.
//!
//! Whatever a machine does for a caller that gives up, it may do or leave. Paths are only ever handed back to the machine.

mod host;

use std::fmt::Debug;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent_api::messages::{ModuleDescription, ModuleFile, ModuleResolution};
use rts_manager_api::files::ManagerFile;
use rts_plan::observed::Usage;
use tokio::io::{AsyncRead, AsyncWrite};

use crate::agent::StartError;
use crate::launch::{ExitFuture, LaunchError, Start};

pub use host::ModuleFinder;
pub(crate) use host::{Host, Pull};

/// How long a manager may take from its folder to its description: so long it may be nameless.
pub const DESCRIBE: Duration = Duration::from_secs(2);
/// How long the rest of what a manager started may take to die.
pub const GROUP_END: Duration = Duration::from_secs(2);

/// A control connection.
pub trait Control: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Control for T {}

/// Who lives in a run folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Tenant {
    /// There is no folder.
    None,
    /// This very manager.
    Lives(ManagerFile),
    /// A manager that may just be starting, or somebody who holds the lock and does not say who he is.
    Nameless,
    /// Nobody any more. Processes of this group, which once was a manager's, may be left.
    Gone(Option<ManagerFile>),
}

/// What a family is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// End orderly.
    Term,
    /// Go on, should you be stopped.
    Cont,
    /// End now.
    Kill,
}

/// A process that leads its group, and all that it started.
pub trait Family: Debug + Send + Sync {
    /// Its process id.
    fn pid(&self) -> u32;
    /// True when the leader has ended; a zombie has.
    fn has_ended(&self) -> bool;
    /// What the leader uses of the machine; none where nobody knows.
    fn usage(&self) -> Option<Usage> {
        None
    }
    /// Sends each of them a signal, once.
    fn signal(&self, signal: Signal) -> BoxFuture<'_, ()>;
    /// Kills all of them, waits until they are gone, and frees what held them; false when somebody still lives at the
    /// end of the time.
    fn end(&self, limit: Duration) -> BoxFuture<'_, bool>;
}

/// A manager that was started and may not serve yet.
pub struct Launched {
    /// Its process and what that starts.
    pub family: Box<dyn Family>,
    /// The first control connection; its Hello is the sign of readiness.
    pub control: Box<dyn Control>,
    /// Its end.
    pub exit: ExitFuture,
    /// Where in its log this start begins, in bytes.
    pub log_start: u64,
}

/// A manager that was found running.
pub struct Found {
    /// Its process and what that started.
    pub family: Box<dyn Family>,
    /// Its end.
    pub exit: ExitFuture,
}

/// The machine of a node. The agent has it to itself for as long as [`Machine::keep`] says so.
pub trait Machine: Send + Sync + 'static {
    /// Names this boot; none where nobody knows.
    fn boot_id(&self) -> Option<String>;
    /// Makes anew what somebody has removed of the node's own folders and locks; an error of kind
    /// [`StartError::Running`] when another agent has the node by now.
    fn keep(&self) -> BoxFuture<'_, Result<(), StartError>>;
    /// The run folders of managers.
    fn run_folders(&self) -> BoxFuture<'_, Vec<PathBuf>>;
    /// Who lives in a run folder. An error means that nothing is known.
    fn look<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<Tenant>>;
    /// Makes an empty run folder, mode 0700.
    fn make_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<()>>;
    /// Makes an empty run folder, mode 0700, where there is none; false when there is one.
    fn claim_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<bool>> {
        Box::pin(async move {
            let is_free = matches!(self.look(folder).await?, Tenant::None);
            if is_free {
                self.make_folder(folder).await?;
            }
            Ok(is_free)
        })
    }
    /// A batch begins or ends: what can wait is done while none runs.
    fn work(&self, _begins: bool) {}
    /// Removes the run folder of a manager that is gone, if it is there.
    fn remove_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, ()>;
    /// Kills what is left of a manager that is gone, and removes its run folder; an error when something does not die.
    fn bury<'a>(
        &'a self,
        folder: &'a Path,
        file: Option<ManagerFile>,
    ) -> BoxFuture<'a, io::Result<()>>;
    /// Kills what managers without a run folder left behind; `living` are the run folders of those that live.
    fn bury_orphans(&self, living: Vec<PathBuf>) -> BoxFuture<'_, ()>;
    /// Starts a manager in its run folder, which exists and is empty, and kills first what the one before left; the error
    /// [`LaunchError::ending`] when that does not die.
    fn launch<'a>(&'a self, start: &'a Start) -> BoxFuture<'a, Result<Launched, LaunchError>>;
    /// Watches a manager that was found by [`Machine::look`].
    fn find<'a>(
        &'a self,
        folder: &'a Path,
        file: &'a ManagerFile,
    ) -> BoxFuture<'a, io::Result<Found>>;
    /// Opens a control connection to the manager of a run folder.
    fn connect<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<Box<dyn Control>>>;
    /// The last `lines` that a start wrote to its log.
    fn log_end<'a>(&'a self, start: &'a Start, from: u64, lines: usize) -> BoxFuture<'a, String>;
    /// Marks a log in which a new incarnation begins, unless it is new.
    fn mark_log<'a>(&'a self, _log: &'a Path, _who: &'a str) -> BoxFuture<'a, ()> {
        Box::pin(async {})
    }
    /// Where the module of a type is, without a description of it.
    fn resolve<'a>(&'a self, type_name: &'a str) -> BoxFuture<'a, io::Result<ModuleResolution>>;
    /// What a module says of itself; none when it says nothing.
    fn describe<'a>(
        &'a self,
        module: &'a ModuleFile,
        type_name: &'a str,
    ) -> BoxFuture<'a, Option<ModuleDescription>>;
}
