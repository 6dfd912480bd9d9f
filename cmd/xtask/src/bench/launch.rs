//! `cargo xtask bench launch --local`: from `rtsctl apply` to all components Active, beside what it cannot beat.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use super::Common;
use super::stack::Stack;
use super::{floors, stats};

/// Components of each system.
const COMPONENTS: u32 = 10;
/// Type of every component: it has no ports to connect, so that only launching is measured.
pub const TYPE: &str = "ConfigSample";
/// File of its module.
pub const MODULE: &str = "libconfig_sample.so";

/// Arguments of `cargo xtask bench launch`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// On a local stack over Unix sockets (the only way in this version).
    #[arg(long, required = true)]
    local: bool,
    #[command(flatten)]
    common: Common,
}

/// Measures all rows, interleaved run by run, and prints them.
pub fn run(args: &Args) -> Result<()> {
    let (profile, programs) = args.common.programs()?;
    let stack = Stack::start(&programs)?;
    let one = system(&stack, "one", false)?;
    let ten = system(&stack, "ten", true)?;
    let mut rows = [const { Vec::new() }; 4];
    for run in 0..=args.common.runs {
        let times = [
            apply(&stack, "one", &one)?,
            apply(&stack, "ten", &ten)?,
            floors::dlopen_and_create(&programs.join(MODULE), stack.folder.path(), COMPONENTS)?,
            floors::spawn_until_answer(
                &programs.join("rts-manager"),
                stack.folder.path(),
                COMPONENTS,
            )?,
        ];
        if run > 0 {
            rows.iter_mut()
                .zip(times)
                .for_each(|(row, time)| row.push(time));
        }
    }
    stack.stop()?;
    let names = [
        "agent-10-same",
        "agent-10-separate",
        "floor-dlopen",
        "floor-spawn",
    ];
    let rows: Vec<_> = names
        .iter()
        .zip(rows)
        .map(|(name, runs)| stats::Row::new(name, COMPONENTS, runs))
        .collect();
    if !args.common.json {
        println!(
            "{COMPONENTS} components, {profile} build, `rtsctl apply` included in the agent rows"
        );
    }
    stats::print(&rows, args.common.json)
}

/// Writes a profile of components that share a process, or have one each.
fn system(stack: &Stack, name: &str, isolated: bool) -> Result<PathBuf> {
    let components: String = (0..COMPONENTS)
            .map(|i| {
                format!(
                    r#"<rts:Components rts:id="RTC:rtsctl:bench:{TYPE}:1.0" rts:instanceName="{name}{i}" rts:pathUri="localhost/{name}{i}.rtc" rts:compositeType="None" rts:isRequired="true">
<rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="10.0"/>
<rtsExt:Properties rtsExt:name="rtsctl.isolated" rtsExt:value="{isolated}"/>
</rts:Components>
"#
                )
            })
            .collect();
    let text = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:rtsctl:{name}:1.0" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00" rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts" xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
{components}</rts:RtsProfile>
"#
    );
    let file = stack.folder.path().join(format!("{name}.xml"));
    std::fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))?;
    Ok(file)
}

/// Time of one apply until it says converged; the system is taken down again afterwards.
fn apply(stack: &Stack, name: &str, file: &Path) -> Result<Duration> {
    let start = Instant::now();
    stack.rtsctl(&["apply", &file.to_string_lossy()])?;
    let took = start.elapsed();
    stack.rtsctl(&["teardown", name, "--yes"])?;
    Ok(took)
}
