//! The files of the ledger: two, written over in turn, so that one flush makes a spec durable. One that was torn by a loss
//! of power leaves the other, which holds what was accepted before it, or the same.
//!
//! Each is JSON that people can read, filled up with blanks to a length that seldom changes: then a flush has nothing but
//! its bytes to write. Both have the same length: the next spec finds room although the disk is full. `sequence` tells which is the newer, `checksum` whether it is whole.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use rts_agent_api::messages::LedgerFence;
use rts_host::disk::Disk;

use super::{LedgerError, Sealed, ledger_fence, text};
use crate::events::lock;

/// Names of the files in the state folder.
pub(super) const FILES: [&str; 2] = ["node-spec.json", "node-spec.2.json"];
/// Largest file in bytes: more than a request may have.
const MAX_FILE: u64 = 128 * 1024 * 1024;

/// What one of the files holds, with its number.
pub(super) type Numbered = (u64, Arc<Sealed>);

/// Reads one of the files.
pub(super) fn parse(bytes: &[u8]) -> Result<Numbered, String> {
    let (number, text) = text::read(bytes)?;
    let sealed = Sealed::try_from(text).map_err(|e| e.to_string())?;
    Ok((number, Arc::new(sealed)))
}

/// The files of one ledger.
pub(crate) struct Files {
    disk: Arc<dyn Disk>,
    paths: [PathBuf; 2],
    state: tokio::sync::Mutex<State>,
    saved: Mutex<Saved>,
}

struct State {
    /// Number of what was written last.
    number: u64,
    /// Which of the files is to be written next.
    next: usize,
    /// Their lengths in bytes; none for one that is not there.
    lengths: [Option<usize>; 2],
}

/// What is on the disk.
#[derive(Default)]
struct Saved {
    fence: Option<LedgerFence>,
    /// The last write failed.
    failed: bool,
}

impl Files {
    /// Reads what was written last.
    pub async fn load(
        state: &Path,
        disk: Arc<dyn Disk>,
    ) -> Result<(Self, Option<Numbered>), LedgerError> {
        let paths = FILES.map(|name| state.join(name));
        let mut found: Option<(usize, Numbered)> = None;
        let (mut lengths, mut damage) = ([None; 2], None);
        for (at, path) in paths.iter().enumerate() {
            let read = disk.read(path, MAX_FILE).await;
            let read = read.map_err(|source| LedgerError::Read {
                path: path.clone(),
                source,
            })?;
            let Some(bytes) = read else { continue };
            lengths[at] = Some(bytes.len());
            match parse(&bytes) {
                Ok(one) if found.as_ref().is_none_or(|(_, other)| other.0 < one.0) => {
                    found = Some((at, one));
                }
                Ok(_) => {}
                Err(reason) => drop(damage.get_or_insert((path.clone(), reason))),
            }
        }
        if let Some((path, reason)) = damage {
            if found.is_none() {
                return Err(LedgerError::Damaged { path, reason });
            }
            tracing::warn!(
                "{} was cut off while it was written ({reason}); the spec before it counts",
                path.display()
            );
        }
        let newest = found.as_ref().map(|(at, _)| *at);
        let held = found.map(|(_, numbered)| numbered);
        let files = Self {
            disk,
            paths,
            state: tokio::sync::Mutex::new(State {
                number: held.as_ref().map_or(0, |(number, _)| *number),
                next: newest.map_or(0, |at| 1 - at),
                lengths,
            }),
            saved: Mutex::new(Saved {
                fence: held.as_ref().map(|(_, s)| ledger_fence(s.envelope())),
                failed: false,
            }),
        };
        if let Some((number, sealed)) = &held {
            // An agent of before may have left the other one shorter.
            let mut state = files.state.lock().await;
            files.make_room(&mut state, *number, sealed).await;
        }
        Ok((files, held))
    }

    /// What is on the disk: what a restart begins with.
    pub fn saved(&self) -> Option<LedgerFence> {
        lock(&self.saved).fence.clone()
    }

    /// True when the last write failed.
    pub fn failed(&self) -> bool {
        lock(&self.saved).failed
    }

    /// Writes a spec, unless it or a later one was written. Durable when it ends well; after an error the one before is.
    pub async fn save(&self, number: u64, sealed: &Sealed) -> io::Result<()> {
        let mut state = self.state.lock().await;
        if state.number >= number {
            return Ok(());
        }
        let done = self.write(&mut state, number, sealed, 0).await;
        {
            let mut saved = lock(&self.saved);
            saved.failed = done.is_err();
            if done.is_ok() {
                saved.fence = Some(ledger_fence(sealed.envelope()));
            }
        }
        done?;
        state.number = number;
        state.next = 1 - state.next;
        self.make_room(&mut state, number, sealed).await;
        Ok(())
    }

    /// The other file becomes as long as the one that was written: what takes things down is written there, and must need no
    /// new space when the disk is full by then. It holds the same spec until then.
    async fn make_room(&self, state: &mut State, number: u64, sealed: &Sealed) {
        let (next, written) = (state.next, state.lengths[1 - state.next]);
        if state.lengths[next] >= written {
            return;
        }
        let made = self
            .write(state, number, sealed, written.unwrap_or(0))
            .await;
        if let Err(e) = made {
            tracing::warn!(
                "cannot make {} long enough for the next spec: {e}",
                self.paths[next].display()
            );
        }
    }

    /// Writes at least so many bytes.
    async fn write(
        &self,
        state: &mut State,
        number: u64,
        sealed: &Sealed,
        least: usize,
    ) -> io::Result<()> {
        let (path, length) = (&self.paths[state.next], state.lengths[state.next]);
        let text = text::written(number, sealed, length.unwrap_or(0).max(least))?;
        let written = text.len();
        match length {
            // What was cut off behind it must not be left there: it is never shorter than before.
            Some(_) => self.disk.save_over(path, text).await?,
            // Its name must outlive a power cut, too.
            None => self.disk.replace(path, text).await?,
        }
        state.lengths[state.next] = Some(written);
        Ok(())
    }
}

/// The text of what counts, of both files of a ledger; none when neither is whole.
pub fn newest<'a>(files: &[&'a [u8]]) -> Option<&'a [u8]> {
    let whole = files
        .iter()
        .filter_map(|bytes| Some((parse(bytes).ok()?.0, *bytes)));
    let newest = whole.max_by_key(|(number, _)| *number);
    newest.map(|(_, bytes)| bytes)
}
