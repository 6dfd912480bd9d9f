//! The machine as one life of an agent has it: the agent may crash before, during and after each call.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use futures_util::future::BoxFuture;
use rts_agent::StartError;
use rts_agent::launch::{Exit, LaunchError, Start};
use rts_agent::machine::{Control, DESCRIBE, Found, Launched, Machine, Tenant};
use rts_agent_api::messages::{ModuleDescription, ModuleFile, ModuleResolution};
use rts_manager_api::files::ManagerFile;

use super::family::SimFamily;
use super::handle::Handle;
use super::state::{Folder, Process, State};
use super::wire::wire;
use super::{Shared, connection, process};
use crate::life::Life;
use crate::truth::Cause;

/// Usual time of a call in microseconds, from and to.
const USUAL: (u64, u64) = (50, 2_000);
/// How SIGKILL ends a process.
const KILLED: Exit = Exit::Signal(9);

/// A machine in the hands of one life.
pub(super) struct Grip {
    pub shared: Arc<Shared>,
    pub life: Life,
}

impl Grip {
    /// One call: some time, the effect, some time.
    fn call<'a, T: Send + 'a>(
        &'a self,
        effect: impl FnOnce(&mut State) -> T + Send + 'a,
    ) -> BoxFuture<'a, T> {
        Box::pin(self.life.call(async move {
            self.shared.pause(USUAL.0, USUAL.1).await;
            let done = self.shared.change(effect);
            self.shared.pause(USUAL.0, USUAL.1).await;
            done
        }))
    }

    fn family(&self, handle: &Handle, pid: u32) -> SimFamily {
        SimFamily {
            handle: handle.clone(),
            pid,
            life: self.life.clone(),
        }
    }
}

impl State {
    fn look(&self, folder: &Path) -> Tenant {
        let Some(found) = self.folders.get(folder) else {
            return Tenant::None;
        };
        match &found.file {
            Some(file) => {
                let is = |p: &Process| p.lives() && p.is(file, &self.boot_id);
                if self.processes.values().any(is) {
                    Tenant::Lives(file.clone())
                } else {
                    Tenant::Gone(Some(file.clone()))
                }
            }
            None if found.changed.elapsed() < DESCRIBE => Tenant::Nameless,
            None if self.tenant(folder).is_some() => Tenant::Nameless,
            None => Tenant::Gone(None),
        }
    }

    /// Kills all that was ever started for these folders.
    fn kill_all(&mut self, of: impl Fn(&Process) -> bool) {
        let processes = self.processes.values().filter(|p| of(p));
        let numbers: Vec<u64> = processes.map(|p| p.number).collect();
        for number in numbers {
            self.end(number, KILLED, Cause::Asked);
            self.kill_grandchildren(number);
        }
    }
}

impl Machine for Grip {
    fn boot_id(&self) -> Option<String> {
        Some(self.shared.change(|state| state.boot_id.clone()))
    }

    fn keep(&self) -> BoxFuture<'_, Result<(), StartError>> {
        self.call(|_| Ok(()))
    }

    fn run_folders(&self) -> BoxFuture<'_, Vec<PathBuf>> {
        self.call(|state| state.folders.keys().cloned().collect())
    }

    fn look<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<Tenant>> {
        self.call(|state| Ok(state.look(folder)))
    }

    fn make_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        self.call(|state| {
            let folders = &mut state.folders;
            folders.entry(folder.to_owned()).or_insert_with(Folder::new);
            Ok(())
        })
    }

    fn remove_folder<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, ()> {
        self.call(|state| {
            state.folders.remove(folder);
        })
    }

    fn bury<'a>(
        &'a self,
        folder: &'a Path,
        file: Option<ManagerFile>,
    ) -> BoxFuture<'a, io::Result<()>> {
        self.call(move |state| {
            let boot_id = state.boot_id.clone();
            let named = |p: &Process| file.as_ref().is_some_and(|file| p.is(file, &boot_id));
            state.kill_all(|p| p.folder == folder || named(p));
            state.folders.remove(folder);
            Ok(())
        })
    }

    fn bury_orphans(&self, living: Vec<PathBuf>) -> BoxFuture<'_, ()> {
        self.call(move |state| {
            let folders: Vec<PathBuf> = state.folders.keys().cloned().collect();
            state.kill_all(|p| !living.contains(&p.folder) && !folders.contains(&p.folder));
        })
    }

    fn launch<'a>(&'a self, start: &'a Start) -> BoxFuture<'a, Result<Launched, LaunchError>> {
        Box::pin(self.life.call(async move {
            self.shared.pause(USUAL.0, USUAL.1).await;
            let log_start = self.shared.change(|state| {
                state.kill_all(|p| p.folder == start.folder);
                state.logs.get(&start.log).map_or(0, String::len)
            });
            let (ours, theirs) = wire(self.life.clone());
            let handle = process::start(&self.shared, start, theirs, self.life.clone())?;
            let pid = handle.with(|p| p.hello.pid).unwrap_or_default();
            self.shared.pause(USUAL.0, USUAL.1).await;
            let family = self.family(&handle, pid);
            Ok(Launched {
                exit: family.exit(true),
                family: Box::new(family),
                control: Box::new(ours),
                log_start: log_start as u64,
            })
        }))
    }

    fn find<'a>(
        &'a self,
        _folder: &'a Path,
        file: &'a ManagerFile,
    ) -> BoxFuture<'a, io::Result<Found>> {
        self.call(|state| {
            let boot_id = &state.boot_id;
            let mut living = state.processes.values().filter(|p| p.lives());
            let process = living.find(|p| p.is(file, boot_id));
            let process = process.ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))?;
            let handle = Handle::new(self.shared.clone(), process);
            let family = self.family(&handle, file.pid);
            Ok(Found {
                exit: family.exit(false),
                family: Box::new(family),
            })
        })
    }

    fn connect<'a>(&'a self, folder: &'a Path) -> BoxFuture<'a, io::Result<Box<dyn Control>>> {
        Box::pin(self.life.call(async move {
            self.shared.pause(USUAL.0, USUAL.1).await;
            let handle = self.shared.change(|state| {
                let process = state.tenant(folder);
                process.map(|process| Handle::new(self.shared.clone(), process))
            });
            let refused = || io::Error::from(io::ErrorKind::ConnectionRefused);
            let handle = handle.ok_or_else(refused)?;
            let (ours, theirs) = wire(self.life.clone());
            connection::open(&handle, theirs, self.life.clone());
            Ok(Box::new(ours) as Box<dyn Control>)
        }))
    }

    fn log_end<'a>(&'a self, start: &'a Start, from: u64, lines: usize) -> BoxFuture<'a, String> {
        self.call(move |state| {
            let log = state.logs.get(&start.log).map_or("", String::as_str);
            let from = usize::try_from(from).unwrap_or(usize::MAX);
            let written: Vec<&str> = log.get(from..).unwrap_or(log).lines().collect();
            let skipped = written.len().saturating_sub(lines);
            written[skipped..]
                .iter()
                .map(|l| format!("{l}\n"))
                .collect()
        })
    }

    fn resolve<'a>(&'a self, type_name: &'a str) -> BoxFuture<'a, io::Result<ModuleResolution>> {
        self.call(|state| Ok(state.modules.resolve(type_name)))
    }

    fn describe<'a>(
        &'a self,
        module: &'a ModuleFile,
        type_name: &'a str,
    ) -> BoxFuture<'a, Option<ModuleDescription>> {
        self.call(|state| state.modules.describe(module, type_name))
    }
}
