//! When, where and on what a benchmark ran, and how busy the machine was: a figure without that says little.

use std::fmt;
use std::fs;
use std::num::NonZero;

use jiff::Zoned;
use serde::Serialize;

/// A machine with more than this share of its processors at work when a run begins is not quiet.
const QUIET: f64 = 0.25;

/// Date, machine, kernel, build and load.
#[derive(Debug, Clone, Serialize)]
pub struct Scene {
    /// Day on which the run began.
    pub date: String,
    /// Model of the processors, as the kernel names it.
    pub machine: String,
    /// Processors that the run could use.
    pub cpus: usize,
    /// Kernel release.
    pub kernel: String,
    /// Cargo profile of what was measured.
    pub build: String,
    /// Load average of the last minute when the run began.
    pub load_begin: f64,
    /// The same when it ended, the run's own part included.
    pub load_end: f64,
}

impl Scene {
    /// At the begin of a run of what this cargo profile built.
    pub fn begin(build: &str) -> Self {
        let load = load();
        Self {
            date: Zoned::now().date().to_string(),
            machine: machine(),
            cpus: std::thread::available_parallelism().map_or(1, NonZero::get),
            kernel: first_line("/proc/sys/kernel/osrelease"),
            build: build.to_owned(),
            load_begin: load,
            load_end: load,
        }
    }

    /// At its end.
    #[must_use]
    pub fn end(mut self) -> Self {
        self.load_end = load();
        self
    }

    /// True when others were at work when the run began.
    fn is_loaded(&self) -> bool {
        self.load_begin > QUIET * self.cpus as f64
    }
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {}, {} CPUs, Linux {}, {} build, load {:.2} at the begin and {:.2} at the end",
            self.date,
            self.machine,
            self.cpus,
            self.kernel,
            self.build,
            self.load_begin,
            self.load_end
        )?;
        match self.is_loaded() {
            true => write!(
                f,
                "\nLOADED MACHINE: others were at work when this began; compare rows, not figures"
            ),
            false => Ok(()),
        }
    }
}

fn load() -> f64 {
    let text = first_line("/proc/loadavg");
    let first = text.split_whitespace().next();
    first.and_then(|load| load.parse().ok()).unwrap_or(f64::NAN)
}

fn machine() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        (name.trim() == "model name").then(|| value.trim().to_owned())
    });
    model.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

fn first_line(file: &str) -> String {
    let text = fs::read_to_string(file).unwrap_or_default();
    text.lines().next().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_on_which_others_work_is_told() {
        let scene = |load_begin| Scene {
            date: "2026-01-01".to_owned(),
            machine: "a machine".to_owned(),
            cpus: 2,
            kernel: "6.18".to_owned(),
            build: "release".to_owned(),
            load_begin,
            load_end: 2.0,
        };
        assert_eq!(
            scene(0.1).to_string(),
            "2026-01-01, a machine, 2 CPUs, Linux 6.18, release build, load 0.10 at the begin and 2.00 at the end"
        );
        assert!(scene(1.0).to_string().contains("LOADED MACHINE"));
    }

    #[test]
    fn this_machine_says_what_it_is() {
        let scene = Scene::begin("dev").end();
        assert!(!scene.kernel.is_empty() && !scene.machine.is_empty());
        assert!(scene.cpus > 0 && scene.load_begin >= 0.0);
    }
}
