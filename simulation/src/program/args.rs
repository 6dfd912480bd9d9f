//! Arguments.

use std::collections::BTreeSet;
use std::num::NonZero;
use std::path::PathBuf;
use std::str::FromStr;

use crate::served::Served;

/// What `--help` says.
pub(super) const HELP: &str = "\
Runs the real controller and the real agents in a simulated world in which things go wrong.

Usage: simulate [OPTIONS]

  --seeds N        number of seeds [default: 1000]
  --start S        the first of them [default: 0]
  --jobs J         seeds at a time [default: one for each core]
  --keep-going     go on after a seed that fails
  --seed X         only this one
  --without NAMES  leave these out of its schedule, with commas between (f0,d2,A1)
  --trace          print all that happens in it, with its time
  --log            the same, with what the programs log
  --schedule       print its schedule and do not run it
  --minimise       make a schedule that fails smaller [default with --seeds]
  --no-minimise    do not
  --json           print what came of it as one line of JSON
  --serve HOME     no seed: serve agents over simulated machines to the real controller of this home, in real time, until
                   standard input is closed; prints a line of JSON when all serve
  --first N        number of the first node, whose name is nN [default: 0]
  --count N        number of nodes [default: 1]
  -h, --help       print this

Exit code: 0 when all invariants held, 1 when one did not, 2 when it cannot run.";

/// Settled arguments.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Args {
    pub seeds: u64,
    pub start: u64,
    pub jobs: usize,
    pub keep_going: bool,
    pub seed: Option<u64>,
    pub without: BTreeSet<String>,
    pub trace: bool,
    pub log: bool,
    pub schedule: bool,
    pub minimise: bool,
    pub json: bool,
    pub serve: Option<PathBuf>,
    pub first: u32,
    pub count: u32,
    pub help: bool,
}

/// What is to be run.
pub(super) enum Mode {
    One(u64),
    Many,
    Serve(Served),
}

impl Args {
    pub fn mode(&self) -> Mode {
        match (&self.serve, self.seed) {
            (Some(home), _) => Mode::Serve(Served {
                home: home.clone(),
                first: self.first,
                count: self.count,
            }),
            (None, Some(seed)) => Mode::One(seed),
            (None, None) => Mode::Many,
        }
    }
}

/// Understands arguments, without the program's name.
pub(super) fn parse(args: impl Iterator<Item = String>) -> Result<Args, String> {
    let mut found = Args {
        seeds: 1000,
        start: 0,
        jobs: std::thread::available_parallelism().map_or(1, NonZero::get),
        keep_going: false,
        seed: None,
        without: BTreeSet::new(),
        trace: false,
        log: false,
        schedule: false,
        minimise: true,
        json: false,
        serve: None,
        first: 0,
        count: 1,
        help: false,
    };
    let mut minimise = None;
    let mut args = args.flat_map(|arg| match arg.split_once('=') {
        Some((name, value)) if name.starts_with("--") => vec![name.to_owned(), value.to_owned()],
        _ => vec![arg],
    });
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or_else(|| format!("{arg} needs a value"));
        match arg.as_str() {
            "--seeds" => found.seeds = number(&arg, &value()?)?,
            "--start" => found.start = number(&arg, &value()?)?,
            "--jobs" => found.jobs = number::<NonZero<usize>>(&arg, &value()?)?.get(),
            "--keep-going" => found.keep_going = true,
            "--seed" => found.seed = Some(number(&arg, &value()?)?),
            "--without" => found.without = value()?.split(',').map(str::to_owned).collect(),
            "--trace" => found.trace = true,
            "--log" => (found.trace, found.log) = (true, true),
            "--schedule" => found.schedule = true,
            "--minimise" => minimise = Some(true),
            "--no-minimise" => minimise = Some(false),
            "--json" => found.json = true,
            "--serve" => found.serve = Some(value()?.into()),
            "--first" => found.first = number(&arg, &value()?)?,
            "--count" => found.count = number(&arg, &value()?)?,
            "-h" | "--help" => found.help = true,
            _ => return Err(format!("there is no option {arg}")),
        }
    }
    found.minimise = minimise.unwrap_or(found.seed.is_none());
    Ok(found)
}

fn number<T: FromStr>(option: &str, value: &str) -> Result<T, String> {
    let number = value.parse();
    number.map_err(|_| format!("{option}: {value:?} is no number that fits"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(args: &[&str]) -> Result<Args, String> {
        parse(args.iter().map(|arg| (*arg).to_owned()))
    }

    #[test]
    fn options_are_understood_or_refused() {
        let args = of(&["--seeds=7", "--start", "3", "--jobs", "2", "--json"]).unwrap();
        assert_eq!((args.seeds, args.start, args.jobs), (7, 3, 2));
        assert!(args.json && args.minimise && !args.trace);
        let one = of(&["--seed", "42", "--without", "f0,d1", "--log"]).unwrap();
        assert_eq!(one.seed, Some(42));
        assert!(one.trace && !one.minimise && one.without.contains("d1"));
        let served = of(&["--serve=/h", "--first", "3", "--count", "2"]).unwrap();
        let Mode::Serve(served) = served.mode() else {
            panic!("agents were to be served");
        };
        assert_eq!((served.first, served.count), (3, 2));
        for wrong in [
            &["--seeds"][..],
            &["--serve"],
            &["--count", "-1"],
            &["--jobs", "0"],
            &["--seed", "x"],
            &["more"],
        ] {
            assert!(of(wrong).is_err(), "{wrong:?}");
        }
    }
}
