//! A process that a component starts and leaves behind, as a driver's helper might be.

use std::io;
use std::process::{Command, Stdio};

use crate::choices::Child;

/// What is ignored stays ignored in the program that the shell becomes.
const STAY: &str = "trap '' TERM; exec sleep 600";

/// Starts it; returns its process id.
pub fn start(kind: Child) -> io::Result<Option<u32>> {
    let mut command = match kind {
        Child::None => return Ok(None),
        Child::IgnoresTerm => Command::new("sh"),
        Child::OwnSession => {
            let mut command = Command::new("setsid");
            command.arg("sh");
            command
        }
    };
    let child = command
        .args(["-c", STAY])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    Ok(Some(child.id()))
}
