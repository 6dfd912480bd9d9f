//! Stops the local stack from its run folder and its control groups alone, with every daemon dead if need be.

mod daemons;
mod leftovers;
mod managers;
mod stopped;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::LocalError;
use super::home::Home;
use super::strays::{self, Program};

pub use managers::{LiveManager, live_managers};
pub use stopped::Stopped;

/// Time for each gentle step before a harder one.
const GRACE: Duration = Duration::from_secs(5);
/// Longest wait for a killed process to be gone.
const KILLED: Duration = Duration::from_secs(5);

/// Stops everything: first who could start things anew, then the managers, all at once, then what these left behind.
pub fn stop(home: &Home) -> Result<Stopped, LocalError> {
    let mut stopped = Stopped::default();
    daemons::stop_controller(home, &mut stopped)?;
    daemons::stop_relays(home, &mut stopped)?;
    daemons::stop_agents(home, &mut stopped)?;
    // Before their folders are removed: who left something behind is told by name.
    let names = managers::names(home)?;
    managers::stop(home, &mut stopped)?;
    let strays = daemons::stop_strays(home, Program::Manager, &mut stopped);
    stopped.managers.extend(strays);
    // They have ended with their agents, unless they are stopped or hang.
    daemons::stop_strays(home, Program::Spare, &mut stopped);
    stopped.managers.sort();
    leftovers::end(home, &names, &mut stopped);
    managers::note_held(home, &mut stopped)?;
    Ok(stopped)
}

/// Systems with managers that live now, whether the run folder tells of them or not.
pub fn systems(home: &Home) -> Result<BTreeSet<String>, LocalError> {
    let known = live_managers(home)?;
    let known = known.iter().filter_map(LiveManager::system);
    let mut systems: BTreeSet<_> = known.map(str::to_owned).collect();
    let strays = strays::find(home, Program::Manager);
    systems.extend(strays.into_iter().filter_map(|stray| stray.system));
    Ok(systems)
}

/// The folders in a folder, sorted; none when it is not there. Links are not followed.
fn folders(path: &Path) -> Result<Vec<PathBuf>, LocalError> {
    let entries = match std::fs::read_dir(path) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(LocalError::file("read", path)(e)),
    };
    let mut found: Vec<_> = entries
        .filter_map(Result::ok)
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()))
        .map(|entry| entry.path())
        .collect();
    found.sort();
    Ok(found)
}

fn name_of(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests;
