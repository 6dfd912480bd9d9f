//! A real controller, and real agents over simulated machines: everything goes through real sockets, but no manager is a
//! process. So a thousand nodes fit on one machine, and what the controller costs is seen.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use super::row::{Row, Sample};
use super::system::{NAME, System};
use crate::bench::process;
use crate::project;

/// Processes that the agents share.
const PROCESSES: u32 = 2;
/// Longest wait until all nodes are Ready.
const LIMIT: Duration = Duration::from_secs(120);
/// Longest time of one command.
const DEADLINE: &str = "600s";
/// Between two looks.
const LOOK: Duration = Duration::from_millis(100);

/// A controller with its fleet.
pub struct Fleet {
    folder: tempfile::TempDir,
    rtsctl: PathBuf,
    controller: Child,
    agents: Vec<Child>,
}

impl Fleet {
    /// Starts it; all nodes are Ready when this returns.
    pub fn start(programs: &Path, nodes: u32) -> Result<Self> {
        let folder = tempfile::Builder::new().prefix("rtsf").tempdir_in("/tmp")?;
        let home = folder.path();
        let mut controller = Command::new(programs.join("rts-controller"));
        controller.args(["--local-node", "n0", "--home"]).arg(home);
        let mut fleet = Self {
            controller: ready(&mut controller)?,
            rtsctl: programs.join("rtsctl"),
            agents: Vec::new(),
            folder,
        };
        let share = nodes.div_ceil(PROCESSES);
        for first in (0..nodes).step_by(share as usize) {
            let count = share.min(nodes - first);
            let mut agents = Command::new(programs.join("simulate"));
            agents.args(["--first", &first.to_string(), "--count", &count.to_string()]);
            agents.arg("--serve").arg(fleet.folder.path());
            fleet.agents.push(ready(&mut agents)?);
        }
        fleet.wait(nodes)?;
        Ok(fleet)
    }

    /// Waits until the controller has met all.
    fn wait(&self, nodes: u32) -> Result<()> {
        let begin = Instant::now();
        loop {
            let text = self.rtsctl(&["get", "nodes", "-o", "json"]);
            let list: Value = text.map_or(Value::Null, |text| {
                serde_json::from_str(&text).unwrap_or_default()
            });
            let items = list["items"].as_array().map_or(&[][..], Vec::as_slice);
            let ready = items.iter().filter(|n| n["status"]["state"] == "Ready");
            let ready = ready.count();
            if ready as u64 == u64::from(nodes) {
                return Ok(());
            }
            ensure!(
                begin.elapsed() < LIMIT,
                "{ready} of {nodes} nodes are Ready after {} s",
                LIMIT.as_secs()
            );
            std::thread::sleep(LOOK);
        }
    }

    fn rtsctl(&self, words: &[&str]) -> Result<String> {
        let home = self.folder.path();
        let mut command = Command::new(&self.rtsctl);
        command.args(words).arg("--controller");
        command.arg(home.join("run/controller.sock"));
        command.env("RTSCTL_HOME", home).stdin(Stdio::null());
        let output = command
            .output()
            .with_context(|| format!("cannot start {}", project::shown(&command)))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let last: Vec<_> = said.lines().rev().take(3).collect();
            bail!(
                "{} ended with {}: {}",
                project::shown(&command),
                output.status,
                last.join(" / ")
            );
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// A command, and what it cost.
    fn measured(&self, words: &[&str]) -> Result<Sample> {
        let pid = self.controller.id();
        let (cpu, begin) = (process::cpu(pid)?, Instant::now());
        self.rtsctl(words)?;
        let took = begin.elapsed();
        let cpu = process::cpu(pid)?.saturating_sub(cpu);
        let memory = process::memory(pid)?;
        Ok(Sample { took, cpu, memory })
    }

    /// What the controller costs while nothing changes, as if it were a command of that length.
    fn rest(&self, rest: Duration) -> Result<Sample> {
        let pid = self.controller.id();
        let (cpu, begin) = (process::cpu(pid)?, Instant::now());
        std::thread::sleep(rest);
        let cpu = process::cpu(pid)?.saturating_sub(cpu);
        let memory = process::memory(pid)?;
        let took = begin.elapsed();
        Ok(Sample { took, cpu, memory })
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        // Agents end when their standard input is closed; the controller is our child.
        for agents in &mut self.agents {
            drop(agents.stdin.take());
        }
        let _ = self.controller.kill();
        let _ = self.controller.wait();
        for agents in &mut self.agents {
            let _ = agents.wait();
        }
    }
}

/// Starts a program that says in a line of JSON that it is ready.
fn ready(command: &mut Command) -> Result<Child> {
    let shown = project::shown(command);
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .with_context(|| format!("cannot start {shown}"))?;
    let mut line = String::new();
    if let Some(stdout) = child.stdout.take() {
        BufReader::new(stdout).read_line(&mut line)?;
    }
    let said: Value = serde_json::from_str(&line).unwrap_or_default();
    if said["ready"] != true {
        let _ = child.kill();
        let _ = child.wait();
        bail!("{shown} does not start: {}", line.trim());
    }
    Ok(child)
}

/// All actions on so many nodes and components, `runs` times in a row on one controller, after a run that is not counted.
pub fn measure(
    programs: &Path,
    nodes: u32,
    components: u32,
    runs: u32,
    watched: Duration,
) -> Result<Vec<Row>> {
    let fleet = Fleet::start(programs, nodes)?;
    let file = |name: &str, value: f64| -> Result<String> {
        let system = System {
            nodes,
            components,
            type_name: "Part",
            parameter: "gain",
            value,
        };
        let file = system.write(&fleet.folder.path().join(name))?;
        Ok(file.to_string_lossy().into_owned())
    };
    let (first, changed) = (file("first.xml", 1.0)?, file("changed.xml", 2.0)?);
    let actions: [(&str, Vec<&str>); 4] = [
        ("apply", vec!["apply", &first, "--timeout", DEADLINE]),
        ("no-op", vec!["apply", &first, "--timeout", DEADLINE]),
        ("one-change", vec!["apply", &changed, "--timeout", DEADLINE]),
        (
            "teardown",
            vec!["teardown", NAME, "--yes", "--timeout", DEADLINE],
        ),
    ];
    let mut samples = vec![Vec::new(); actions.len()];
    let mut rest = Vec::new();
    for run in 0..=runs {
        for (place, (action, words)) in actions.iter().enumerate() {
            let sample = fleet
                .measured(words)
                .with_context(|| format!("{action} of {components} components on {nodes} nodes"))?;
            if run > 0 {
                samples[place].push(sample);
            }
            if run == runs && *action == "one-change" {
                rest.push(fleet.rest(watched)?);
            }
        }
    }
    let row = |action: &str, samples| Row::new(nodes, components, action, samples);
    let mut rows: Vec<Row> = actions
        .iter()
        .zip(samples)
        .map(|((action, _), samples)| row(action, samples))
        .collect();
    rows.push(row("rest", rest));
    Ok(rows)
}
