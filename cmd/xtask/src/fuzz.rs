//! `cargo xtask fuzz`: every fuzz target for some time; the tests run a short part.

use std::fs::File;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;

use anyhow::{Context, Result, bail};
use rustix::process::{Pid, Signal, kill_process_group};

use crate::{project, tools};

/// Seconds per target in the tests.
const SHORT: u32 = 5;

/// Arguments of `cargo xtask fuzz`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Seconds for each target.
    #[arg(long, default_value_t = 300)]
    seconds: u32,
    /// Only these targets.
    #[arg(value_name = "TARGET")]
    only: Vec<String>,
}

/// Runs the targets, as many at once as there are cores.
pub fn run(args: &Args) -> Result<()> {
    let mut wanted = targets()?;
    if let Some(unknown) = args.only.iter().find(|name| !wanted.contains(name)) {
        bail!(
            "there is no target {unknown}; there are: {}",
            wanted.join(" ")
        );
    }
    wanted.retain(|target| args.only.is_empty() || args.only.contains(target));
    project::run(&mut build(&tools::cargo_tool("fuzz")?))?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let waiting = Mutex::new(wanted.into_iter());
    let next = || waiting.lock().ok()?.next();
    let work = || -> Result<()> {
        while let Some(target) = next() {
            fuzz(&target, args.seconds)?;
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .try_for_each(|worker| worker.join().unwrap_or_else(|_| bail!("a worker panicked")))
    })
}

/// The part that the tests run.
pub fn short() -> Result<()> {
    run(&Args {
        seconds: SHORT,
        only: Vec::new(),
    })
}

/// A build of the targets that takes only what of the processors nobody else wants. The suite itself waits for it.
pub struct Ahead(Child);

/// Begins to build the targets while suites run that wait for processes most of the time. What it says is in `fuzz-build.log` in the target folder.
pub fn build_ahead() -> Result<Ahead> {
    let said = project::target().join("fuzz-build.log");
    let said = File::create(&said).with_context(|| format!("cannot make {}", said.display()))?;
    let build = build(&tools::cargo_tool("fuzz")?);
    let mut command = project::command("nice");
    command.args(["-n", "19"]).arg(build.get_program());
    command.args(build.get_args()).stdin(Stdio::null());
    command.stdout(said.try_clone()?).stderr(said);
    let child = command.process_group(0).spawn();
    let child = child.with_context(|| format!("cannot start {}", project::shown(&command)))?;
    Ok(Ahead(child))
}

impl Drop for Ahead {
    /// Nothing goes on when the suites have ended; a build that is done is only reaped.
    fn drop(&mut self) {
        if matches!(self.0.try_wait(), Ok(None))
            && let Some(group) = i32::try_from(self.0.id()).ok().and_then(Pid::from_raw)
        {
            let _ = kill_process_group(group, Signal::KILL);
            let _ = self.0.wait();
        }
    }
}

fn build(cargo_fuzz: &Path) -> Command {
    let mut command = project::command(cargo_fuzz);
    command.args(["build", "-s", "none"]);
    command
}

fn targets() -> Result<Vec<String>> {
    let folder = project::root().join("fuzz/fuzz_targets");
    let mut targets = Vec::new();
    for entry in
        std::fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))?
    {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "rs")
            && let Some(name) = path.file_stem().and_then(|n| n.to_str())
        {
            targets.push(name.to_owned());
        }
    }
    targets.sort();
    Ok(targets)
}

/// Prints what the target says when it ends: several run at once.
fn fuzz(target: &str, seconds: u32) -> Result<()> {
    let corpus = project::root().join("fuzz/corpus").join(target);
    std::fs::create_dir_all(&corpus)
        .with_context(|| format!("cannot make {}", corpus.display()))?;
    let seeds = project::root().join("fuzz/seeds").join(target);
    // Stable compilers have no sanitizers; the targets look for panics, hangs and memory, which need none.
    let mut command = project::command(tools::cargo_tool("fuzz")?);
    command.args(["run", "-s", "none", target]).arg(&corpus);
    if seeds.is_dir() {
        command.arg(&seeds);
    }
    command.args([
        "--",
        "-rss_limit_mb=2048",
        "-timeout=10",
        "-verbosity=0",
        "-print_final_stats=1",
    ]);
    command.arg(format!("-max_total_time={seconds}"));
    let output = command
        .output()
        .with_context(|| format!("cannot start {}", project::shown(&command)))?;
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    println!("fuzzed {target} for {seconds} s\n{}", said.trim_end());
    if output.status.success() {
        Ok(())
    } else {
        bail!("{} ended with {}", project::shown(&command), output.status)
    }
}
