//! The real machine: processes, control groups, folders and modules of the computer that this agent runs on.

mod cgroup;
mod child;
mod describe;
mod family;
mod finder;
mod groups;
mod launch;
mod node_lock;
mod nursery;
mod pidfd;
mod pull;
mod spawn;
mod tenant;
mod zygote;

use std::fs::{self, File};
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

use futures_util::future::BoxFuture;
use rts_agent_api::messages::{ModuleDescription, ModuleFile, ModuleResolution};
use rts_host::cgroup::{Cgroup, Cgroups, Choice, Version};
use rts_host::files;
use rts_host::identity::{Identity, boot_id};
use rts_manager_api::files::{CONTROL_SOCKET, LOCK, ManagerFile};
use tokio::net::UnixStream;
use tokio::task::spawn_blocking;

use super::{Control, Found, Launched, Machine, Tenant};
use crate::agent::StartError;
use crate::config::Config;
use crate::events::lock;
use crate::folders::{Folders, is_folder_id};
use crate::launch::{Exit, LaunchError, Start};
use crate::{log_mark, log_tail};
use child::Child;
use family::Family;
pub use finder::ModuleFinder;
use groups::Groups;
use launch::{Born, Ground, Launcher};
use node_lock::NodeLock;
use nursery::Nursery;
use pidfd::PidFd;
pub(crate) use pull::Pull;

/// The machine of one node.
#[derive(Debug)]
pub(crate) struct Host {
    folders: Folders,
    groups: Arc<Groups>,
    launcher: Launcher,
    finder: ModuleFinder,
    /// Where modules come from besides the module paths.
    pull: Option<Pull>,
    /// None when it was given back.
    lock: Mutex<Option<NodeLock>>,
    /// That there are no control groups is said once.
    no_cgroups: OnceLock<()>,
}

async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> io::Result<T> + Send + 'static,
) -> io::Result<T> {
    let done = spawn_blocking(work).await;
    done.map_err(io::Error::other).flatten()
}

impl Host {
    /// Makes the folders of a node, and takes it for this process alone.
    pub async fn take(config: &Config, pull: Option<Pull>) -> Result<Self, StartError> {
        let folders = Folders::new(&config.home, &config.node)?;
        folders.make()?;
        let lock = NodeLock::take(&folders, &config.node).await?;
        let program = config.manager_program.as_path();
        let cgroups = Cgroups::of(&folders.home, Choice::from_env());
        let groups = Arc::new(Groups::new(cgroups, folders.clone()));
        let nursery = config.idle_managers.map(|idle| {
            let idle = idle.min(Config::MOST_IDLE);
            Nursery::open(program, &folders.home, groups.clone(), idle)
        });
        Ok(Self {
            groups,
            launcher: Launcher::new(program, nursery),
            finder: ModuleFinder::new(&config.module_path, program),
            pull,
            lock: Mutex::new(Some(lock)),
            no_cgroups: OnceLock::new(),
            folders,
        })
    }

    /// Describes this process beside its socket.
    pub fn describe_self(&self) -> Result<(), StartError> {
        let path = self.folders.description();
        let own = Identity::own(env!("CARGO_PKG_VERSION"));
        let reserve = self.folders.reserve();
        serde_json::to_vec(&own)
            .map_err(io::Error::from)
            .and_then(|text| reserve.write(|| files::replace(&path, &text)))
            .map_err(|source| StartError::File { path, source })?;
        reserve.keep();
        Ok(())
    }

    /// Removes the description of this process. One that another agent has written stays.
    pub fn forget_self(&self) {
        let path = self.folders.description();
        if Identity::read(&path).is_some_and(|i| i.pid == std::process::id()) {
            let _ = fs::remove_file(path);
        }
    }

    /// Gives the node back: another agent may take it.
    pub fn release(&self) {
        if let Some(nursery) = self.launcher.nursery() {
            nursery.close();
        }
        *lock(&self.lock) = None;
    }

    fn keep_now(&self) -> Result<(), StartError> {
        let made = self.folders.make().map_err(StartError::from);
        let kept = made.and_then(|()| lock(&self.lock).as_mut().map_or(Ok(()), NodeLock::keep));
        if !matches!(kept, Err(StartError::Running { .. })) && !self.folders.description().exists()
        {
            return kept.and(self.describe_self());
        }
        kept
    }

    async fn launch_now(&self, start: &Start) -> Result<Launched, LaunchError> {
        let (log, log_start) = launch::open_log(start)?;
        // What the one before left is killed first.
        let is_left = self.groups.is_left(&start.folder);
        let waiting = match is_left {
            true => None,
            false => self.launcher.waiting(start, &log),
        };
        let (child, cgroup) = match waiting {
            Some(waiting) => waiting,
            None => self.bear(start, log).await?,
        };
        let (pid, exit) = (child.pid, child.exit());
        let control = UnixStream::from_std(child.control).map_err(|source| LaunchError {
            what: format!("manager {}", start.key.display_name()),
            source,
        })?;
        Ok(Launched {
            family: Box::new(Family::of_child(pid, cgroup)),
            control: Box::new(control),
            exit,
            log_start,
        })
    }

    /// Starts one, in the control group of its run folder where one is permitted.
    async fn bear(&self, start: &Start, log: File) -> Result<(Child, Option<Cgroup>), LaunchError> {
        let cgroup = self.group(start).await?;
        let birth = cgroup.as_ref().filter(|c| c.version() == Version::V2);
        let ground = Ground {
            log,
            // Without it, a process is put there after its birth.
            cgroup: birth.and_then(|cgroup| File::open(cgroup.path()).ok()),
        };
        match self.launcher.launch(start, ground).await {
            Ok(born) if born.in_cgroup => Ok((born.child, cgroup)),
            // It starts nothing before it was greeted.
            Ok(Born { child, .. }) => {
                let cgroup = self.enter(cgroup, child.pid).await;
                Ok((child, cgroup))
            }
            Err(e) => {
                if let Some(cgroup) = cgroup {
                    // It cannot panic.
                    let _ = spawn_blocking(move || family::remove(&cgroup)).await;
                }
                Err(e)
            }
        }
    }

    async fn find_now(&self, folder: &Path, file: &ManagerFile) -> io::Result<Found> {
        let cgroup = self.cgroup_of(folder, file).await?;
        let pidfd = PidFd::open(file.pid, Some(file.start_ticks))?;
        let exit = async move {
            pidfd.ended().await;
            Exit::Unknown
        };
        Ok(Found {
            family: Box::new(Family::new(tenant::identity(file), cgroup)),
            exit: Box::pin(exit),
        })
    }
}

impl Machine for Host {
    fn boot_id(&self) -> Option<String> {
        boot_id()
    }

    fn keep(&self) -> BoxFuture<'_, Result<(), StartError>> {
        Box::pin(async { self.keep_now() })
    }

    fn run_folders(&self) -> BoxFuture<'_, Vec<PathBuf>> {
        let run = self.folders.run.clone();
        Box::pin(async {
            let list = spawn_blocking(move || {
                let entries = fs::read_dir(run).into_iter().flatten().flatten();
                let named =
                    |entry: &fs::DirEntry| entry.file_name().to_str().is_some_and(is_folder_id);
                entries.filter(named).map(|entry| entry.path()).collect()
            });
            list.await.unwrap_or_default()
        })
    }

    fn look<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<Tenant>> {
        let folder = folder.to_owned();
        Box::pin(blocking(move || tenant::look(&folder)))
    }

    fn make_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async { files::private_folder(folder) })
    }

    fn remove_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, ()> {
        let path = folder.to_owned();
        Box::pin(async move {
            // What a manager leaves that has ended orderly; another thread is asked for more.
            let _ = fs::remove_file(path.join(LOCK));
            if fs::remove_dir(&path).is_ok() {
                return;
            }
            match blocking(move || fs::remove_dir_all(path)).await {
                Err(e) if e.kind() != io::ErrorKind::NotFound => {
                    tracing::warn!("cannot remove {}: {e}", folder.display());
                }
                _ => {}
            }
        })
    }

    fn bury<'a>(
        &'a self,
        folder: &'a Path,
        file: Option<ManagerFile>,
    ) -> BoxFuture<'a, io::Result<()>> {
        let (groups, folder) = (self.groups.clone(), folder.to_owned());
        Box::pin(blocking(move || {
            tenant::bury(&folder, file.as_ref(), &groups)
        }))
    }

    fn bury_orphans(&self, living: Vec<PathBuf>) -> BoxFuture<'_, ()> {
        Box::pin(self.bury_cgroups(living))
    }

    fn work(&self, begins: bool) {
        if let Some(nursery) = self.launcher.nursery() {
            nursery.work(begins);
        }
    }

    fn claim_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<bool>> {
        // So short a look is shorter than to ask another thread for it.
        Box::pin(async move {
            match fs::DirBuilder::new().mode(0o700).create(folder) {
                Ok(()) => Ok(true),
                // Somebody lives or lived there; or the folder above is gone and has to be made as well.
                Err(e)
                    if matches!(
                        e.kind(),
                        io::ErrorKind::AlreadyExists | io::ErrorKind::NotFound
                    ) =>
                {
                    Ok(false)
                }
                Err(e) => Err(e),
            }
        })
    }

    fn launch<'a>(&'a self, start: &'a Start) -> BoxFuture<'a, Result<Launched, LaunchError>> {
        Box::pin(self.launch_now(start))
    }

    fn find<'a>(
        &'a self,
        folder: &'a Path,
        file: &'a ManagerFile,
    ) -> BoxFuture<'a, io::Result<Found>> {
        Box::pin(self.find_now(folder, file))
    }

    fn connect<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<Box<dyn Control>>> {
        Box::pin(async move {
            let control = UnixStream::connect(folder.join(CONTROL_SOCKET)).await?;
            Ok(Box::new(control) as Box<dyn Control>)
        })
    }

    fn log_end<'a>(&'a self, start: &'a Start, from: u64, lines: usize) -> BoxFuture<'a, String> {
        let log = start.log.clone();
        Box::pin(async move {
            let read = blocking(move || log_tail::tail_from(&log, from, lines));
            read.await.unwrap_or_default()
        })
    }

    fn mark_log<'a>(&'a self, log: &'a Path, who: &'a str) -> BoxFuture<'a, ()> {
        // So short a work is shorter than to ask another thread for it.
        Box::pin(async move {
            if let Err(e) = log_mark::mark(log, who) {
                // A full disk must not stop a robot.
                tracing::warn!("cannot mark the log {}: {e}", log.display());
            }
        })
    }

    fn resolve<'a>(&'a self, type_name: &'a str) -> BoxFuture<'a, io::Result<ModuleResolution>> {
        Box::pin(async move {
            match &self.pull {
                Some(pull) => pull.resolve(&self.finder, type_name).await,
                None => self.finder.resolve(type_name).await,
            }
        })
    }

    fn describe<'a>(
        &'a self,
        module: &'a ModuleFile,
        type_name: &'a str,
    ) -> BoxFuture<'a, Option<ModuleDescription>> {
        Box::pin(self.finder.describe(module, type_name))
    }
}
