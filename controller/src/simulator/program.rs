//! A simulator that is a program of its own. What it takes of memory, and whether it dies, is nothing to the controller, which
//! need not hold the code of a whole cluster for it.
//!
//! The scenario is one line of JSON on its standard input, the answer what it prints. The input stays open: a line [`HURRY`]
//! says that it takes too long, its end that nobody waits.

use std::borrow::Cow;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use rts_controller_api::Problem;
use rts_controller_api::simulate::Simulated;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::{Scenario, Simulator};

/// Said when it takes too long: what there is by now is to be told.
pub const HURRY: &str = "hurry";
/// Longest scenario in bytes.
pub const MAX_SCENARIO: u64 = 256 * 1024 * 1024;
/// Longest answer in bytes.
const MAX_ANSWER: usize = 64 * 1024 * 1024;
/// Bytes that are read at a time.
const PIECE: usize = 64 * 1024;
/// Looks for the end of one that has closed its output.
const ENDING: u32 = 100;
/// Time between two looks whether somebody still waits.
const LOOK: Duration = Duration::from_millis(20);

/// Plays scenarios through in a process of its own each.
#[derive(Debug, Clone)]
pub struct ProgramSimulator {
    program: PathBuf,
}

impl ProgramSimulator {
    /// Nothing is started yet.
    pub fn new(program: impl Into<PathBuf>) -> Self {
        Self {
            program: program.into(),
        }
    }
}

impl Simulator for ProgramSimulator {
    fn simulate(&self, scenario: &Scenario) -> Result<Simulated, Problem> {
        let failed = |e: io::Error| failed(&self.program, &e);
        let mut line = serde_json::to_vec(scenario).map_err(|e| failed(e.into()))?;
        line.push(b'\n');
        let (mut running, stdin, stdout) = Running::start(&self.program).map_err(|e| {
            let program = self.program.display();
            let detail = format!("cannot start {program}, which belongs to the controller: {e}");
            Problem::unavailable("no-simulator", detail)
        })?;
        let answer = converse(&line, stdin, stdout, scenario);
        match answer.map_err(failed)? {
            Some(answer) => serde_json::from_slice(&answer).unwrap_or_else(|e| {
                let (program, end) = (self.program.display(), running.end());
                Err(Problem::internal(format!(
                    "{program} {end} without an answer: {e}"
                )))
            }),
            None => Err(Problem::internal("nobody waits for the simulation")),
        }
    }
}

/// A process that is ended with this.
struct Running(Child);

impl Running {
    fn start(program: &Path) -> io::Result<(Self, ChildStdin, ChildStdout)> {
        let mut child = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let (stdin, stdout) = (child.stdin.take(), child.stdout.take());
        let running = Self(child);
        match (stdin, stdout) {
            (Some(stdin), Some(stdout)) => Ok((running, stdin, stdout)),
            _ => Err(io::Error::other("it has no pipes")),
        }
    }

    /// How it ended, for which it is given a moment.
    fn end(&mut self) -> String {
        for _ in 0..ENDING {
            match self.0.try_wait() {
                Ok(None) => std::thread::sleep(LOOK),
                Ok(Some(status)) => return format!("ended with {status}"),
                Err(_) => break,
            }
        }
        "closed its output".to_owned()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // One that has ended is only reaped.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Says what is to be simulated, and reads what is answered; `None` when nobody waits for it any more. A program that reads
/// nothing holds nobody up.
fn converse(
    line: &[u8],
    stdin: ChildStdin,
    mut stdout: ChildStdout,
    scenario: &Scenario,
) -> io::Result<Option<Vec<u8>>> {
    let mut said = Said::begin(line, stdin)?;
    let mut answer = Vec::new();
    let mut piece = vec![0; PIECE];
    loop {
        if scenario.stop.is_stopped() {
            return Ok(None);
        }
        if scenario.stop.is_late() {
            said.hurry();
        }
        if !said.is_answered(&stdout)? {
            continue;
        }
        match stdout.read(&mut piece)? {
            0 => return Ok(Some(answer)),
            more if answer.len() + more > MAX_ANSWER => {
                let text = format!("its answer is longer than {MAX_ANSWER} bytes");
                return Err(io::Error::new(ErrorKind::FileTooLarge, text));
            }
            more => answer.extend_from_slice(&piece[..more]),
        }
    }
}

/// What is said to a program, which reads it when it likes.
struct Said<'a> {
    /// None when it reads no more: what it says to that is told by how it ends.
    stdin: Option<ChildStdin>,
    text: Cow<'a, [u8]>,
    /// So much of it was taken.
    taken: usize,
    hurried: bool,
}

impl<'a> Said<'a> {
    fn begin(line: &'a [u8], stdin: ChildStdin) -> io::Result<Self> {
        rustix::io::ioctl_fionbio(&stdin, true)?;
        Ok(Self {
            stdin: Some(stdin),
            text: Cow::Borrowed(line),
            taken: 0,
            hurried: false,
        })
    }

    /// Says that it takes too long, once.
    fn hurry(&mut self) {
        if !std::mem::replace(&mut self.hurried, true) {
            let word = format!("{HURRY}\n");
            self.text = [self.left(), word.as_bytes()].concat().into();
            self.taken = 0;
        }
    }

    fn left(&self) -> &[u8] {
        &self.text[self.taken..]
    }

    /// Waits for a moment until there is something to read, and says more meanwhile.
    fn is_answered(&mut self, stdout: &ChildStdout) -> io::Result<bool> {
        let look = Timespec {
            tv_sec: 0,
            tv_nsec: i64::from(LOOK.subsec_nanos()),
        };
        let mut polled = vec![PollFd::from_borrowed_fd(stdout.as_fd(), PollFlags::IN)];
        let more = self.stdin.as_ref().filter(|_| !self.left().is_empty());
        polled.extend(more.map(|to| PollFd::from_borrowed_fd(to.as_fd(), PollFlags::OUT)));
        match poll(&mut polled, Some(&look)) {
            Err(rustix::io::Errno::INTR) => return Ok(false),
            ready => drop(ready?),
        }
        let answered = !polled[0].revents().is_empty();
        if polled.get(1).is_some_and(|to| !to.revents().is_empty()) {
            self.say();
        }
        Ok(answered)
    }

    /// Says as much as it takes now.
    fn say(&mut self) {
        let Some(stdin) = &mut self.stdin else {
            return;
        };
        match stdin.write(&self.text[self.taken..]) {
            Ok(taken) => self.taken += taken,
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(_) => self.stdin = None,
        }
    }
}

fn failed(program: &Path, error: &io::Error) -> Problem {
    Problem::internal(format!(
        "cannot simulate with {}: {error}",
        program.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::Stop;
    use crate::store::State;
    use rts_controller_api::requests::ApplyRequest;
    use rts_schemas::system::SystemSpec;
    use std::os::unix::fs::PermissionsExt;

    fn scenario() -> Scenario {
        let spec = serde_json::json!({"name": "x", "fullId": "RTSystem:a:x:1", "components": []});
        let spec: SystemSpec = serde_json::from_value(spec).unwrap();
        Scenario {
            before: State::default(),
            request: ApplyRequest::of(spec),
            local_node: "local".to_owned(),
            nodes: Vec::new(),
            faults: Vec::new(),
            seed: 7,
            limit: Duration::from_secs(300),
            notes: Vec::new(),
            stop: Stop::default(),
        }
    }

    /// What comes of a simulator that is this shell script.
    fn of_script(text: &str, scenario: &Scenario) -> Problem {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("simulator");
        std::fs::write(&program, format!("#!/bin/sh\n{text}\n")).unwrap();
        let mode = std::fs::Permissions::from_mode(0o700);
        std::fs::set_permissions(&program, mode).unwrap();
        // Another test that forks meanwhile may still hold the script open for writing.
        loop {
            match ProgramSimulator::new(&program).simulate(scenario) {
                Err(problem) if problem.detail.contains("Text file busy") => {}
                other => return other.unwrap_err(),
            }
        }
    }

    #[test]
    fn what_the_program_answers_is_told() {
        let bad = r#"read line; echo '{"Err":{"type":"bad-fault","title":"t","status":422}}'"#;
        let problem = of_script(bad, &scenario());
        assert_eq!((problem.status, problem.code.as_str()), (422, "bad-fault"));
    }

    #[test]
    fn a_program_that_dies_or_is_not_there_is_told_of() {
        let problem = of_script("exit 3", &scenario());
        assert!(problem.detail.contains("exit status: 3"), "{problem:?}");
        let none = ProgramSimulator::new("/none/rts-simulator").simulate(&scenario());
        assert_eq!(none.unwrap_err().code, "no-simulator");
    }

    #[test]
    fn one_that_reads_nothing_holds_nobody_up() {
        let mut large = scenario();
        // More than a pipe takes.
        large.notes = vec!["x".repeat(1024 * 1024)];
        let problem = of_script(
            "echo '{\"Err\":{\"type\":\"done\",\"title\":\"t\",\"status\":422}}'; exec >&-; exec sleep 600",
            &large,
        );
        assert_eq!(problem.code, "done");
        large.stop.stop();
        let problem = of_script("exec sleep 600", &large);
        assert!(problem.detail.contains("nobody"), "{problem:?}");
    }

    #[test]
    fn one_that_takes_too_long_is_hurried_and_one_that_nobody_waits_for_is_ended() {
        let late = scenario();
        late.stop.hurry();
        let hurried = r#"read line; read word; echo "{\"Err\":{\"type\":\"$word\",\"title\":\"t\",\"status\":504}}""#;
        assert_eq!(of_script(hurried, &late).code, HURRY);
        let stopped = scenario();
        stopped.stop.stop();
        let problem = of_script("read line; read word; sleep 600", &stopped);
        assert!(problem.detail.contains("nobody"), "{problem:?}");
    }
}
