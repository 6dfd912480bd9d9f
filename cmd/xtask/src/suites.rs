//! `cargo xtask test`: every suite in turn, each with a budget of seconds.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::{chaos, fuzz, mutants, project, simulate, tools};

/// Arguments of `cargo xtask test`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Only these suites.
    #[arg(value_name = "SUITE")]
    only: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Budget {
    total: u64,
    suites: BTreeMap<String, u64>,
}

type Suite = (&'static str, fn() -> Result<()>);

const SUITES: [Suite; 12] = [
    ("packages", tools::packages),
    ("tools", install_tools),
    ("fmt", fmt),
    ("build", build),
    ("clippy", clippy),
    ("deny", deny),
    ("tests", tests),
    ("simulate", simulate::short),
    ("chaos", chaos::short),
    ("docs", docs),
    ("mutants", mutants::short),
    ("fuzz", fuzz::short),
];

/// Seed of all random cases. Without it, by `cargo nextest run`, other cases are tried each time.
const SEED: &str = "20261122";

/// Runs the suites and prints the seconds of each.
pub fn run(args: &Args) -> Result<()> {
    let budget: Budget = toml::from_str(include_str!("../budget.toml")).context("budget.toml")?;
    let known = |name: &String| SUITES.iter().any(|(suite, _)| suite == name);
    if let Some(unknown) = args.only.iter().find(|name| !known(name)) {
        bail!(
            "there is no suite {unknown}; there are: {}",
            SUITES.map(|(name, _)| name).join(" ")
        );
    }
    let wanted = |name: &str| args.only.is_empty() || args.only.iter().any(|only| only == name);
    let begun = Instant::now();
    let mut rows = Vec::new();
    let mut ahead = None;
    for (name, suite) in SUITES.into_iter().filter(|(name, _)| wanted(name)) {
        if name == "tests" && wanted("fuzz") {
            ahead = Some(fuzz::build_ahead()?);
        }
        println!("\n==> {name}");
        let start = Instant::now();
        let outcome = suite().with_context(|| format!("suite {name} failed"));
        rows.push((name, start.elapsed()));
        if outcome.is_err() {
            // The seconds are told all the same; the failure comes last.
            let _ = report(&budget, &rows, begun.elapsed());
            return outcome;
        }
    }
    drop(ahead);
    if std::env::var_os("RTSCTL_CORPUS").is_none() {
        println!("\nRTSCTL_CORPUS is not set: the tests of real files were SKIPPED");
    }
    report(&budget, &rows, begun.elapsed())
}

fn report(budget: &Budget, rows: &[(&str, Duration)], total: Duration) -> Result<()> {
    println!("\n{:<10} {:>8} {:>8}", "SUITE", "SECONDS", "BUDGET");
    let mut over = Vec::new();
    let all = rows
        .iter()
        .map(|(name, took)| (*name, *took, budget.suites.get(*name).copied()));
    for (name, took, seconds) in all.chain([("total", total, Some(budget.total))]) {
        let seconds =
            seconds.with_context(|| format!("budget.toml says nothing of suite {name}"))?;
        let spent = took.as_secs_f64();
        let remark = match spent / seconds as f64 {
            share if share > 1.2 => {
                over.push(name);
                "FAILED: above 120 %"
            }
            share if share > 1.0 => "warning: above its budget",
            _ => "",
        };
        println!("{name:<10} {spent:>8.1} {seconds:>8} {remark}");
    }
    if over.is_empty() {
        Ok(())
    } else {
        bail!("above 120 % of the budget: {}", over.join(" "))
    }
}

fn install_tools() -> Result<()> {
    tools::cargo_tool("deny")?;
    tools::cargo_tool("fuzz")?;
    tools::reference()?;
    Ok(())
}

fn fmt() -> Result<()> {
    project::run(project::cargo().args(["fmt", "--all", "--check"]))
}

fn build() -> Result<()> {
    project::run(project::cargo().args(["build", "--workspace", "--all-targets", "--locked"]))
}

fn clippy() -> Result<()> {
    project::run(project::cargo().args([
        "clippy",
        "--workspace",
        "--all-targets",
        "--all-features",
        "--locked",
        "--",
        "-D",
        "warnings",
    ]))
}

fn deny() -> Result<()> {
    let deny = tools::cargo_tool("deny")?;
    project::run(project::command(&deny).args(["check", "bans", "licenses", "sources"]))?;
    // The advisory database lies on a server that not every machine reaches: only then are advisories left out.
    let fetched = project::command(&deny)
        .args(["fetch", "db"])
        .stderr(std::process::Stdio::null())
        .status();
    if !fetched.is_ok_and(|status| status.success()) {
        println!("advisories: NOT CHECKED, their database cannot be reached from here");
        return Ok(());
    }
    project::run(project::command(&deny).args(["check", "advisories"]))
}

fn tests() -> Result<()> {
    let mut command = project::cargo();
    if tools::has_cargo("nextest") {
        // Most of them wait for processes most of the time: one more than there are cores.
        let threads = std::thread::available_parallelism().map_or(2, |cores| cores.get() + 1);
        command.args(["nextest", "run", "--workspace", "--locked"]);
        command.arg(format!("--test-threads={threads}"));
    } else {
        command.args(["test", "--workspace", "--all-targets", "--locked"]);
    }
    // The same cases every time: a test that fails now and then says nothing of the change that it meets.
    command.env("PROPTEST_RNG_SEED", SEED);
    if let Some(python) = tools::reference()? {
        command.env("RTSCTL_REFERENCE", python);
    }
    project::run(command.env("INSTA_UPDATE", "no"))
}

fn docs() -> Result<()> {
    project::run(project::cargo().args(["test", "--workspace", "--doc", "--locked", "--quiet"]))?;
    project::run(
        project::cargo()
            .args([
                "doc",
                "--workspace",
                "--lib",
                "--no-deps",
                "--locked",
                "--quiet",
            ])
            .env(
                "RUSTDOCFLAGS",
                "-D warnings -A rustdoc::private_intra_doc_links",
            ),
    )
}
