//! Single steps on the far side: short scripts that say `done`, or what failed.

use std::time::Duration;

use super::found::Found;
use super::service::{Keeper, Service};
use crate::answer::tame;
use crate::diagnose::of_file;
use crate::error::SshError;
use crate::session::Session;

const LOOK: &str = include_str!("look.sh");
const WRITE: &str = include_str!("write.sh");
const UNIT: &str = include_str!("unit.sh");
const START: &str = include_str!("start.sh");
const STOP: &str = include_str!("stop.sh");
const REMOVE: &str = include_str!("remove.sh");

/// The end of the log: of the process, or of the unit.
const LOG: &str = "if [ -n \"$2\" ]; then journalctl $1 -u \"$2\" -n 5 --no-pager -o cat; else tail -n 5 \"$3\"; fi 2>&1";

/// Most lines of a log that are shown.
const LOG_LINES: usize = 5;
/// Between two looks whether the agent serves.
const PAUSE: Duration = Duration::from_millis(100);

/// What is there.
pub(super) async fn look(session: &Session, service: &Service) -> Result<Found, SshError> {
    let what = "what is installed there";
    let (file, _) = service.file();
    let words = [service.home.as_str(), &service.node, &file];
    let ran = session.run(what, LOOK, &words).await?;
    Found::parse(&ran.out).map_err(|reason| SshError::Answer {
        host: session.host().to_owned(),
        what: what.to_owned(),
        said: [reason, ran.err].join(" ").trim_end().to_owned(),
    })
}

/// Looks until an agent of this program serves; false when it does not in time.
pub(super) async fn serves(
    session: &Session,
    service: &Service,
    limit: Duration,
) -> Result<bool, SshError> {
    let end = tokio::time::Instant::now() + limit;
    loop {
        let found = look(session, service).await?;
        if found.runs(service.program()) && found.serves {
            return Ok(true);
        }
        if tokio::time::Instant::now() >= end {
            return Ok(false);
        }
        tokio::time::sleep(PAUSE).await;
    }
}

/// The end of the agent's log, fit to be shown.
pub(super) async fn log(session: &Session, service: &Service) -> String {
    let unit = match service.keeper {
        Keeper::Process => String::new(),
        _ => service.unit_name(),
    };
    let words = [service.keeper.flag(), &unit, &service.log_file()];
    let ran = session.run("its log", LOG, &words).await;
    let text = ran.map(|ran| String::from_utf8_lossy(&ran.out).into_owned());
    let text = text.unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    tame(&lines[lines.len().saturating_sub(LOG_LINES)..].join("\n"))
}

/// Writes a file whole or not at all.
pub(super) async fn write(
    session: &Session,
    file: &str,
    mode: &str,
    text: &str,
) -> Result<(), SshError> {
    step(session, file, WRITE, &[file, mode], text.as_bytes())
        .await
        .map(drop)
}

/// Tells `systemctl` these words, one after the other.
pub(super) async fn systemctl(
    session: &Session,
    keeper: Keeper,
    commands: &[&str],
) -> Result<(), SshError> {
    let words = [&[keeper.flag()], commands].concat();
    step(session, "systemd", UNIT, &words, b"").await.map(drop)
}

/// Starts a plain process.
pub(super) async fn start(session: &Session, service: &Service) -> Result<(), SshError> {
    let script = service.script_file();
    step(session, &script, START, &[&script], b"")
        .await
        .map(drop)
}

/// Ends processes of programs of ours; with `all`, what they started too.
pub(super) async fn stop(
    session: &Session,
    service: &Service,
    pids: &[u32],
    all: bool,
) -> Result<(), SshError> {
    let pids: Vec<String> = pids.iter().map(u32::to_string).collect();
    let root = service.programs();
    let mut words = vec![root.as_str(), if all { "all" } else { "alone" }];
    words.extend(pids.iter().map(String::as_str));
    step(session, "a process", STOP, &words, b"")
        .await
        .map(drop)
}

/// Removes files; gives what is left in the home, if anything is.
pub(super) async fn remove(
    session: &Session,
    service: &Service,
    node: &str,
    file: &str,
) -> Result<Option<String>, SshError> {
    let words = [service.home.as_str(), node, file];
    step(session, &service.home, REMOVE, &words, b"").await
}

/// Lets services of the account run while nobody is logged in, or not; false when that is not permitted.
pub(super) async fn linger(session: &Session, on: bool) -> Result<bool, SshError> {
    let script = "loginctl \"$1\" >/dev/null 2>&1";
    let word = if on {
        "enable-linger"
    } else {
        "disable-linger"
    };
    Ok(session.run(word, script, &[word]).await?.code == Some(0))
}

/// Runs a script that says `done`, and before it perhaps what it `left`.
async fn step(
    session: &Session,
    path: &str,
    script: &str,
    words: &[&str],
    input: &[u8],
) -> Result<Option<String>, SshError> {
    let ran = session.run_with(path, script, words, input).await?;
    let text = String::from_utf8_lossy(&ran.out);
    let mut left = None;
    for line in text.lines() {
        if line == "done" {
            return Ok(left);
        }
        left = line.strip_prefix("left ").map(tame).or(left);
    }
    let said = tame(&text);
    let said = said.strip_prefix("error ").unwrap_or(&said);
    let said = [said, &ran.err].join(" ").trim().to_owned();
    let known = of_file(session.host(), path, 0, None, &said);
    Err(known.unwrap_or_else(|| SshError::Failed {
        host: session.host().to_owned(),
        what: format!("do what is needed with {path}"),
        said,
    }))
}
