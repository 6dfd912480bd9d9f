//! From the start of a program until its API answers that it is ready.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use crate::bench::stats;

/// Row of the controller.
pub const CONTROLLER: &str = "start-controller";
/// Row of the agent.
pub const AGENT: &str = "start-agent";
/// Row of both, by `rtsctl up`.
pub const BOTH: &str = "start-both";
/// Row of `rtsctl up` until it returns: by then the controller has met the agent.
const UP: &str = "start-both-up-returns";
/// A program that takes longer is broken.
const LIMIT: Duration = Duration::from_secs(30);
/// Between two looks: long enough to leave the processor to those who are measured.
const LOOK: Duration = Duration::from_micros(250);
/// Most that is read of an answer.
const MAX_ANSWER: u64 = 4096;

/// One of the starts, measured in turns with the others.
pub struct Start {
    rows: Vec<String>,
    programs: PathBuf,
    home: PathBuf,
    start: fn(&Path, &Path) -> Result<Vec<Duration>>,
}

impl stats::Turn for Start {
    fn rows(&self) -> (&[String], u32) {
        (&self.rows, 1)
    }

    fn run(&mut self) -> Result<Vec<Duration>> {
        let took = (self.start)(&self.programs, &self.home);
        // A new home each time: a store and a ledger that are there already are another start.
        let _ = std::fs::remove_dir_all(&self.home);
        took
    }
}

/// All starts, each in a home of its own below the folder.
pub fn turns(programs: &Path, folder: &Path) -> Vec<Start> {
    let turn =
        |name: &str, rows: &[&str], start: fn(&Path, &Path) -> Result<Vec<Duration>>| Start {
            rows: rows.iter().map(|row| (*row).to_owned()).collect(),
            programs: programs.to_owned(),
            home: folder.join(name),
            start,
        };
    vec![
        turn("c", &[CONTROLLER], controller),
        turn("a", &[AGENT], agent),
        turn("u", &[BOTH, UP], both),
    ]
}

fn controller(programs: &Path, home: &Path) -> Result<Vec<Duration>> {
    alone(
        programs.join("rts-controller"),
        home,
        &[],
        "run/controller.sock",
    )
}

fn agent(programs: &Path, home: &Path) -> Result<Vec<Duration>> {
    let words = ["--no-controller"];
    alone(
        programs.join("rts-agent"),
        home,
        &words,
        "run/local/agent.sock",
    )
}

/// A daemon without others, until it is ready; then it is ended.
fn alone(program: PathBuf, home: &Path, words: &[&str], socket: &str) -> Result<Vec<Duration>> {
    let begin = Instant::now();
    let mut daemon = Command::new(&program)
        .args(words)
        .arg("--home")
        .arg(home)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .with_context(|| format!("cannot start {}", program.display()))?;
    let ready = wait(&home.join(socket), begin);
    end(&mut daemon)?;
    Ok(vec![ready?])
}

fn end(daemon: &mut Child) -> Result<()> {
    let pid = i32::try_from(daemon.id())?;
    let pid = rustix::process::Pid::from_raw(pid).context("no process id")?;
    rustix::process::kill_process(pid, rustix::process::Signal::TERM)?;
    daemon.wait()?;
    Ok(())
}

/// `rtsctl up`, until both are ready and until it returns.
fn both(programs: &Path, home: &Path) -> Result<Vec<Duration>> {
    let rtsctl = |words: &[&str]| {
        let mut command = Command::new(programs.join("rtsctl"));
        command.args(words).env("RTSCTL_HOME", home);
        command.stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(Stdio::null());
        command
    };
    let begin = Instant::now();
    let mut up = rtsctl(&["up"]).spawn().context("cannot start rtsctl")?;
    let ready = wait(&home.join("run/controller.sock"), begin)
        .and_then(|_| wait(&home.join("run/local/agent.sock"), begin));
    let ended = up.wait()?;
    let returned = begin.elapsed();
    let down = rtsctl(&["down", "--purge", "--yes"]).status()?;
    ensure!(ended.success(), "`rtsctl up` ended with {ended}");
    ensure!(down.success(), "`rtsctl down` ended with {down}");
    Ok(vec![ready?, returned])
}

/// Looks until the API behind a socket is ready.
fn wait(socket: &Path, begin: Instant) -> Result<Duration> {
    while !is_ready(socket) {
        let shown = socket.display();
        ensure!(begin.elapsed() < LIMIT, "{shown} is not ready in time");
        std::thread::sleep(LOOK);
    }
    Ok(begin.elapsed())
}

/// One question on a connection of its own.
fn is_ready(socket: &Path) -> bool {
    let asked = || -> std::io::Result<bool> {
        let mut stream = UnixStream::connect(socket)?;
        stream.set_read_timeout(Some(LIMIT))?;
        stream.write_all(b"GET /readyz HTTP/1.1\r\nHost: local\r\nConnection: close\r\n\r\n")?;
        let mut answer = Vec::new();
        stream.take(MAX_ANSWER).read_to_end(&mut answer)?;
        Ok(answer.starts_with(b"HTTP/1.1 200"))
    };
    asked().unwrap_or(false)
}
