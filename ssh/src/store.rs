//! Files on the far side, each in a folder that has its SHA-256 for a name: what is there is never sent again, half of a file
//! never has a file's name, and two that copy at once do each other no harm.

mod put;

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::diagnose::of_file;
use crate::error::SshError;
use crate::session::Session;

const NEED: &str = include_str!("store_need.sh");

/// Most files of one call.
const MAX_FILES: usize = 10_000;
/// Bytes that are read at once.
const PIECE: usize = 64 * 1024;

/// A file of this machine that is to be there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LocalFile {
    /// Where it is here.
    pub path: PathBuf,
    /// File name that it has there.
    pub name: String,
    /// It is a program.
    pub executable: bool,
}

impl LocalFile {
    /// A program, which keeps its file name.
    pub fn program(path: impl Into<PathBuf>) -> Self {
        Self {
            executable: true,
            ..Self::data(path)
        }
    }

    /// A file that is only read (or mapped, as a module is), which keeps its file name.
    pub fn data(path: impl Into<PathBuf>) -> Self {
        let path = path.into();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        Self {
            path,
            name,
            executable: false,
        }
    }
}

/// A file that is there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredFile {
    /// Its name.
    pub name: String,
    /// SHA-256 in lower-case hexadecimal digits.
    pub digest: String,
    /// Bytes.
    pub size: u64,
    /// Where it is there.
    pub path: String,
    /// It was not there before.
    pub sent: bool,
}

/// The files that are there now, in the order in which they were asked for.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Stored {
    /// The files.
    pub files: Vec<StoredFile>,
}

impl Stored {
    /// Bytes that had to be sent.
    pub fn sent_bytes(&self) -> u64 {
        self.files
            .iter()
            .filter(|file| file.sent)
            .map(|file| file.size)
            .sum()
    }

    /// Files that had to be sent.
    pub fn sent_files(&self) -> usize {
        self.files.iter().filter(|file| file.sent).count()
    }

    /// Where the file of this name is.
    pub fn path(&self, name: &str) -> Option<&str> {
        let file = self.files.iter().find(|file| file.name == name)?;
        Some(&file.path)
    }
}

/// SHA-256 of a file in lower-case hexadecimal digits, and its size.
pub fn digest_of(path: &Path) -> io::Result<(String, u64)> {
    let mut file = std::fs::File::open(path)?;
    let (mut hash, mut size, mut piece) = (Sha256::new(), 0, vec![0; PIECE]);
    loop {
        let read = file.read(&mut piece)?;
        if read == 0 {
            return Ok((format!("{:x}", hash.finalize()), size));
        }
        hash.update(&piece[..read]);
        size += read as u64;
    }
}

/// What is done besides looking.
#[derive(Debug, Clone, Copy)]
enum Make<'a> {
    /// Nothing.
    Nothing,
    /// The folder, and a lease that names the files, unless its file has no name.
    Folder(&'a str),
}

/// Looks which are there; those of which `sent` is said are not.
pub(crate) async fn look(
    session: &Session,
    files: &[LocalFile],
    root: &str,
) -> Result<(Stored, Option<u64>), SshError> {
    prepare(session, files, root, Make::Nothing).await
}

async fn prepare(
    session: &Session,
    files: &[LocalFile],
    root: &str,
    make: Make<'_>,
) -> Result<(Stored, Option<u64>), SshError> {
    if files.len() > MAX_FILES {
        let what = format!("take more than {MAX_FILES} files at once");
        return Err(failed(session, &what, "there are more"));
    }
    if !root.starts_with('/') {
        return Err(failed(
            session,
            "store files in a folder that is not absolute",
            root,
        ));
    }
    let mut stored = Vec::new();
    for file in files {
        stored.push(described(session, file, root).await?);
    }
    let free = note_needed(session, &mut stored, root, make).await?;
    Ok((Stored { files: stored }, free))
}

/// Copies what is not there yet. `lease` is the file of the lease that keeps it, or nothing.
pub(crate) async fn store(
    session: &Session,
    files: &[LocalFile],
    root: &str,
    lease: &str,
) -> Result<Stored, SshError> {
    let (stored, free) = prepare(session, files, root, Make::Folder(lease)).await?;
    let needed = stored.sent_bytes();
    if free.is_some_and(|free| free < needed) {
        let (host, path) = (session.host().to_owned(), root.to_owned());
        return Err(SshError::Full {
            host,
            path,
            needed,
            free,
        });
    }
    for (local, there) in files.iter().zip(&stored.files) {
        if there.sent {
            put::put(session, local, there, root).await?;
        }
    }
    Ok(stored)
}

async fn described(
    session: &Session,
    file: &LocalFile,
    root: &str,
) -> Result<StoredFile, SshError> {
    let sound = !file.name.is_empty()
        && !file.name.starts_with('.')
        && file.name.chars().all(|c| c.is_ascii_graphic() && c != '/');
    if !sound {
        return Err(failed(
            session,
            "have a file of this name",
            &format!("{:?}", file.name),
        ));
    }
    let path = file.path.clone();
    let read = tokio::task::spawn_blocking(move || digest_of(&path)).await;
    let read = read.unwrap_or_else(|e| Err(io::Error::other(e)));
    let (digest, size) = read.map_err(|source| SshError::Read {
        path: file.path.clone(),
        source,
    })?;
    Ok(StoredFile {
        path: format!("{}/{digest}/{}", root.trim_end_matches('/'), file.name),
        name: file.name.clone(),
        digest,
        size,
        sent: true,
    })
}

/// Asks which are there; gives the free bytes, as far as known.
async fn note_needed(
    session: &Session,
    files: &mut [StoredFile],
    root: &str,
    make: Make<'_>,
) -> Result<Option<u64>, SshError> {
    let list: String = files
        .iter()
        .map(|f| format!("{} {} {}\n", f.digest, f.size, f.name))
        .collect();
    let digests: Vec<String> = files.iter().map(|file| file.digest.clone()).collect();
    let mut words = vec![root];
    match make {
        Make::Nothing => words.extend(["", ""]),
        Make::Folder("") => words.extend(["make", ""]),
        Make::Folder(lease) => {
            words.extend(["make", lease]);
            words.extend(digests.iter().map(String::as_str));
        }
    }
    let what = "which files are there";
    let ran = session
        .run_with(what, NEED, &words, list.as_bytes())
        .await?;
    let answer = String::from_utf8_lossy(&ran.out).into_owned();
    let mut lines = answer.lines();
    for file in files.iter_mut() {
        file.sent = match lines.next() {
            Some("have") => false,
            Some("need") => true,
            other => return Err(refused(session, root, 0, other, &ran.err)),
        };
    }
    let free = lines.next().and_then(|line| line.strip_prefix("free "));
    Ok(free.and_then(|free| free.trim().parse::<u64>().ok()?.checked_mul(1024)))
}

/// What a line means that says that something did not work.
fn refused(session: &Session, path: &str, needed: u64, line: Option<&str>, err: &str) -> SshError {
    let host = session.host();
    let said = crate::answer::tame(line.unwrap_or_default());
    let Some(said) = said.strip_prefix("error ") else {
        let said = [said.as_str(), err].join(" ").trim().to_owned();
        return SshError::Answer {
            host: host.to_owned(),
            what: format!("write {path}"),
            said,
        };
    };
    of_file(host, path, needed, None, said)
        .unwrap_or_else(|| failed(session, &format!("write {path}"), said))
}

fn failed(session: &Session, what: &str, said: &str) -> SshError {
    SshError::Failed {
        host: session.host().to_owned(),
        what: what.to_owned(),
        said: said.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};
    use std::time::{Duration, SystemTime};

    /// What the script says here of one file.
    fn need(words: &[&str], file: &str) -> String {
        use std::io::Write;
        let mut sh = Command::new("/bin/sh")
            .args(["-c", NEED, "sh"])
            .args(words)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = sh.stdin.take().unwrap();
        writeln!(stdin, "{file}").unwrap();
        drop(stdin);
        let out = sh.wait_with_output().unwrap();
        let said = String::from_utf8(out.stdout).unwrap();
        said.lines().next().unwrap_or_default().to_owned()
    }

    #[test]
    fn a_look_touches_nothing_and_what_is_to_be_copied_has_a_lease_first() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("programs/abc");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("file"), "x").unwrap();
        let old = SystemTime::now() - Duration::from_secs(3600);
        let opened = std::fs::File::open(&folder).unwrap();
        opened.set_modified(old).unwrap();
        let used = || opened.metadata().unwrap().modified().unwrap();
        let path = |name: &str| home.path().join(name).display().to_string();
        let (root, lease) = (path("programs"), path("leases/mine"));
        assert_eq!(need(&[&root, "", ""], "abc 1 file"), "have");
        assert_eq!(used(), old);
        assert_eq!(need(&[&root, "make", ""], "abc 2 file"), "need");
        assert!(used() > old);
        assert!(!home.path().join("leases").exists());
        let words = [root.as_str(), "make", &lease, "abc", "def"];
        assert_eq!(need(&words, "abc 1 file"), "have");
        assert_eq!(std::fs::read_to_string(&lease).unwrap(), "abc def\n");
        // Without space for it the files count all the same.
        std::fs::remove_dir_all(home.path().join("leases")).unwrap();
        std::fs::write(home.path().join("leases"), "in the way").unwrap();
        assert_eq!(need(&words, "abc 1 file"), "have");
    }
}
