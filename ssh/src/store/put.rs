//! One file over one channel.

use std::time::Duration;

use openssh::{ChildStdin, Stdio};
use sha2::{Digest, Sha256};
use tokio::fs::File;
use tokio::io::{AsyncReadExt, AsyncWriteExt};

use super::{LocalFile, PIECE, StoredFile, refused};
use crate::answer::{after_mark, tame};
use crate::error::SshError;
use crate::remote::{command_line, ended, mark, read_some};
use crate::session::Session;

const PUT: &str = include_str!("../store_put.sh");

/// Longest time in which not one piece goes.
const STALLED: Duration = Duration::from_secs(60);
/// Longest wait for the answer when all is sent: the disk there may be slow.
const ANSWER: Duration = Duration::from_secs(120);

/// Sends it; it has its name there when this returns.
pub(super) async fn put(
    session: &Session,
    local: &LocalFile,
    there: &StoredFile,
    root: &str,
) -> Result<(), SshError> {
    let (mark, size) = (mark(), there.size.to_string());
    let mode = if local.executable { "500" } else { "400" };
    let words = [root, &there.digest, &there.name, &size, mode];
    let mut child = session
        .mux()
        .arc_raw_command(command_line(PUT, &mark, &words))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .await
        .map_err(|e| session.broken(e))?;
    let out = tokio::spawn(read_some(child.stdout().take()));
    let err = tokio::spawn(read_some(child.stderr().take()));
    let stdin = child.stdin().take();
    let late = |what: &str, limit: Duration| SshError::TimedOut {
        host: session.host().to_owned(),
        what: format!("{what} {}", there.path),
        seconds: limit.as_secs(),
    };
    if let Some(stdin) = stdin {
        send(stdin, local, there).await.map_err(|e| match e {
            NotSent::Stalled => late("sending", STALLED),
            NotSent::Error(e) => e,
        })?;
    }
    let answer = async {
        let (out, err) = (out.await.unwrap_or_default(), err.await.unwrap_or_default());
        (ended(child.wait().await), out, err)
    };
    let answer = tokio::time::timeout(ANSWER, answer).await;
    let (code, out, err) = answer.map_err(|_| late("storing", ANSWER))?;
    let line = after_mark(&out, &mark).map(String::from_utf8_lossy);
    let line = line.as_deref().and_then(|text| text.lines().next());
    if line == Some("stored") {
        return Ok(());
    }
    if session.has_ended().await || (line.is_none() && matches!(code, Ok(None) | Err(_))) {
        return Err(session.lost_error());
    }
    let broken = line.filter(|line| line.starts_with("short ") || line.starts_with("damaged "));
    if let Some(said) = broken {
        let (host, path) = (session.host().to_owned(), there.path.clone());
        return Err(SshError::Damaged {
            host,
            path,
            said: tame(said),
        });
    }
    let err = tame(&String::from_utf8_lossy(&err));
    Err(refused(session, root, there.size, line, &err))
}

/// Why not all was sent. That the far side stopped listening is no reason: it says itself why.
enum NotSent {
    Stalled,
    Error(SshError),
}

/// Sends the file. Its last piece goes only when all that was read has the digest that was promised.
async fn send(mut stdin: ChildStdin, local: &LocalFile, there: &StoredFile) -> Result<(), NotSent> {
    let read = |source| {
        NotSent::Error(SshError::Read {
            path: local.path.clone(),
            source,
        })
    };
    let mut file = File::open(&local.path).await.map_err(read)?;
    let (mut hash, mut size) = (Sha256::new(), 0);
    let (mut piece, mut held) = (vec![0; PIECE], Vec::with_capacity(PIECE));
    loop {
        let count = file.read(&mut piece).await.map_err(read)?;
        size += count as u64;
        if count == 0 {
            break;
        }
        hash.update(&piece[..count]);
        if !listens(&mut stdin, &held).await? {
            return Ok(());
        }
        held.clear();
        held.extend_from_slice(&piece[..count]);
    }
    if size != there.size || format!("{:x}", hash.finalize()) != there.digest {
        return Err(NotSent::Error(SshError::Changed {
            path: local.path.clone(),
        }));
    }
    if listens(&mut stdin, &held).await? {
        let _ = stdin.shutdown().await;
    }
    Ok(())
}

/// Writes a piece; false when nobody reads any more.
async fn listens(stdin: &mut ChildStdin, piece: &[u8]) -> Result<bool, NotSent> {
    match tokio::time::timeout(STALLED, stdin.write_all(piece)).await {
        Ok(written) => Ok(written.is_ok()),
        Err(_) => Err(NotSent::Stalled),
    }
}
