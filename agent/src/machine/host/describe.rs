//! What a module says of itself: `rts-manager --describe` opens it in a process of its own, so that a bad one harms
//! nobody.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use rts_agent_api::messages::{ModuleDescription, ParameterLimits};
use rts_host::identity::Identity;
use rts_host::process::signal_group_of;
use rts_manager_api::control::{ModuleInfo, ParameterFacts};
use rustix::process::Signal;
use tokio::io::AsyncReadExt;
use tokio::process::{Child, Command};
use tokio::time::timeout;

use super::spawn::environment;
use crate::inventory::port;

/// How long a module may take.
const LIMIT: Duration = Duration::from_secs(5);
/// Longest answer in bytes.
const MAX_ANSWER: u64 = 1024 * 1024;

/// Why there is no description.
#[derive(Debug, thiserror::Error)]
pub(super) enum DescribeError {
    /// The program cannot be run: it may be another time.
    #[error("cannot run {program}: {source}")]
    Run {
        /// The program.
        program: String,
        /// Why.
        source: std::io::Error,
    },
    /// It did not end.
    #[error("it was not described within {} s", LIMIT.as_secs())]
    Late,
    /// The program refused, or does not know how to.
    #[error("it cannot be described: {0}")]
    Refused(String),
}

/// Asks. `program` is the manager program.
pub(super) async fn describe(
    program: &Path,
    module: PathBuf,
    type_name: &str,
) -> Result<ModuleDescription, DescribeError> {
    let failed = |source| DescribeError::Run {
        program: program.display().to_string(),
        source,
    };
    let mut child = Command::new(program)
        .arg("--describe")
        .arg(module)
        .args(["--type", type_name])
        .env_clear()
        .envs(environment())
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .kill_on_drop(true)
        .spawn()
        .map_err(failed)?;
    let _group = Group(child.id().and_then(Identity::of));
    let (ok, out, err) = timeout(LIMIT, answer(&mut child))
        .await
        .map_err(|_| DescribeError::Late)?
        .map_err(failed)?;
    if !ok {
        let reason = String::from_utf8_lossy(&err).trim().to_owned();
        return Err(DescribeError::Refused(reason));
    }
    let info: ModuleInfo =
        serde_json::from_slice(&out).map_err(|e| DescribeError::Refused(e.to_string()))?;
    Ok(ModuleDescription {
        ports: info.ports.into_iter().map(port).collect(),
        parameters: info.parameters,
        limits: info.facts.into_iter().map(limits).collect(),
    })
}

fn limits((name, facts): (String, ParameterFacts)) -> (String, ParameterLimits) {
    let limits = ParameterLimits {
        value_type: facts.value_type,
        constraint: facts.constraint,
    };
    (name, limits)
}

async fn answer(child: &mut Child) -> std::io::Result<(bool, Vec<u8>, Vec<u8>)> {
    let (out, err) = (child.stdout.take(), child.stderr.take());
    let (out, err) = tokio::join!(read(out), read(err));
    let status = child.wait().await?;
    Ok((status.success(), out?, err?))
}

/// Reads what it writes, and no more than the longest answer; whoever writes more then finds the pipe closed.
async fn read(from: Option<impl tokio::io::AsyncRead + Unpin>) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    if let Some(from) = from {
        from.take(MAX_ANSWER).read_to_end(&mut bytes).await?;
    }
    Ok(bytes)
}

/// Kills the process group, however the question ends: a module may have started others.
struct Group(Option<Identity>);

impl Drop for Group {
    fn drop(&mut self) {
        if let Some(leader) = &self.0
            && let Err(e) = signal_group_of(leader, Signal::KILL)
        {
            tracing::warn!(pid = leader.pid, "cannot kill its process group: {e}");
        }
    }
}
