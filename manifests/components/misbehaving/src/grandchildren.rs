//! Processes that a component starts and leaves behind, as a driver's helpers might be.

use std::io;
use std::process::{Command, Stdio};

/// A shell that ignores SIGTERM, and so does what it starts. Both end by themselves after ten minutes.
const STAY: &str = "trap '' TERM; sleep 600 & wait";

/// Starts two, each with a child of its own: one in the process group of the manager, one in a session of its own.
/// Returns their process ids.
pub fn start() -> io::Result<[u32; 2]> {
    let beside = spawn(&mut Command::new("sh"))?;
    let away = spawn(Command::new("setsid").arg("sh"))?;
    Ok([beside, away])
}

fn spawn(command: &mut Command) -> io::Result<u32> {
    let child = command
        .args(["-c", STAY])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    Ok(child.id())
}
