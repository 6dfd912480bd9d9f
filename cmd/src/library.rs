//! Finds RTC Profiles in files and folders, within bounds.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use rts_schemas::check::Library;
use rts_schemas::diagnostic::{Report, Severity};
use rts_schemas::rtc_profile;

use crate::input::shown;
use crate::output::Output;

/// Folders in folders that are searched.
const DEPTH: usize = 12;

/// Entries that are looked at.
const ENTRIES: usize = 100_000;

/// Profiles that are read.
const PROFILES: usize = 5000;

/// Bytes in which a profile names its kind.
const HEAD: u64 = 4096;

/// Reads every RTC Profile at these paths. Files of a folder that are no RTC Profile are passed over; one that is, and
/// cannot be read, is a note: a component of its type, if there is one, lacks its RTC Profile, and that is a warning.
pub(crate) fn read(
    paths: &[PathBuf],
    bytes: &mut impl FnMut(&Path) -> Option<Vec<u8>>,
    report: &mut Report,
    out: &Output,
) -> Library {
    let mut library = Library::default();
    let mut left = ENTRIES;
    for path in paths {
        let is_folder = path.is_dir();
        let files = match is_folder {
            true => {
                let mut found = Vec::new();
                search(path, DEPTH, &mut left, &mut found);
                found
            }
            false => vec![path.clone()],
        };
        for file in files {
            if library.len() >= PROFILES {
                out.warn(&format!(
                    "more than {PROFILES} RTC Profiles were found; the others were not read"
                ));
                return library;
            }
            if is_folder && !looks_right(&file) {
                continue;
            }
            let Some(bytes) = bytes(&file) else { continue };
            match rtc_profile::read(&shown(&file), &bytes) {
                Ok(profile) => library.add(profile),
                Err(fault) => report.extend(lessened(fault, is_folder)),
            }
        }
    }
    if left == 0 {
        out.warn(&format!(
            "more than {ENTRIES} files lie there; the others were not looked at"
        ));
    }
    library
}

/// Nobody asked for this very file.
fn lessened(mut fault: Report, found: bool) -> Report {
    if found {
        fault
            .findings
            .retain(|finding| finding.code != "wrong-root");
        for finding in &mut fault.findings {
            finding.severity = Severity::Note;
        }
    }
    fault
}

/// All files with a fitting name, in the order of their names. Links to folders are not followed.
fn search(folder: &Path, depth: usize, left: &mut usize, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    let mut entries: Vec<_> = entries.flatten().take(*left).collect();
    *left -= entries.len();
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        let hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        match entry.file_type() {
            Ok(kind) if kind.is_dir() && !hidden && depth > 0 => {
                search(&path, depth - 1, left, found);
            }
            Ok(kind) if !kind.is_dir() && is_profile_name(&path) => found.push(path),
            _ => {}
        }
    }
}

fn is_profile_name(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    let ending = ending.unwrap_or_default().to_ascii_lowercase();
    matches!(ending.as_str(), "xml" | "yaml" | "yml")
}

/// True when its first bytes name an RTC Profile; in a file of two bytes a letter too.
fn looks_right(path: &Path) -> bool {
    // Opening a pipe would wait for somebody to write to it.
    if !std::fs::metadata(path).is_ok_and(|of| of.is_file()) {
        return false;
    }
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    head.retain(|byte| *byte != 0);
    let has = |word: &[u8]| {
        head.windows(word.len())
            .any(|part| part.eq_ignore_ascii_case(word))
    };
    read.is_ok() && has(b"RtcProfile")
}
