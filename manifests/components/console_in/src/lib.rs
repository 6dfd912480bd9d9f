//! ConsoleIn: sends numbers.
//!
//! Under a manager there is no terminal, so the numbers come from the file or FIFO that `path` names, one a line; a
//! file that grows is followed. Without a path it counts up.

mod lines;

use std::time::{Duration, Instant};

use rts_runtime::types::TimedLong;
use rts_runtime::{
    Component, Config, Context, Declaration, OutPort, RtcError, RtcResult, TypeInfo,
};

use lines::Lines;

/// Lines that are sent in a cycle: well below what an in-port's queue holds.
const PER_CYCLE: usize = 16;
/// Time between two warnings of lines that are no number.
const QUIET: Duration = Duration::from_secs(1);

struct ConsoleIn {
    out: OutPort<TimedLong>,
    path: Config<String>,
    lines: Option<Lines>,
    count: i32,
    skipped: u64,
    warned: Option<Instant>,
}

impl Component for ConsoleIn {
    const TYPE: TypeInfo = TypeInfo {
        name: "ConsoleIn",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "sends numbers from a file, or counts up",
        rate: 10.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            out: d.out_port("out"),
            path: d.parameter("path", String::new()),
            lines: None,
            count: 0,
            skipped: 0,
            warned: None,
        }
    }

    fn on_activated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.count = 0;
        self.skipped = 0;
        self.warned = None;
        self.open()
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        if self.path.changed() {
            self.open()?;
        }
        let Some(lines) = &mut self.lines else {
            self.count = self.count.wrapping_add(1);
            self.out.write(ctx, &TimedLong::now(self.count))?;
            return Ok(());
        };
        for _ in 0..PER_CYCLE {
            let Some(line) = lines.next_line()? else {
                break;
            };
            let line = line.trim();
            match line.parse::<i32>() {
                Ok(number) => {
                    self.out.write(ctx, &TimedLong::now(number))?;
                }
                Err(_) if line.is_empty() => {}
                Err(error) => {
                    self.skipped += 1;
                    if self.warned.is_none_or(|last| last.elapsed() >= QUIET) {
                        self.warned = Some(Instant::now());
                        let skipped = self.skipped;
                        ctx.warn(format_args!(
                            "`{line}` is no number: {error} ({skipped} lines skipped so far)"
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    fn on_deactivated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.lines = None;
        Ok(())
    }
}

impl ConsoleIn {
    fn open(&mut self) -> RtcResult {
        self.path.changed();
        let path = self.path.get();
        self.lines = match path.as_str() {
            "" => None,
            path => {
                let lines = Lines::open(path).map_err(|error| {
                    RtcError::from(error).context(format_args!("cannot open `{path}`"))
                })?;
                Some(lines)
            }
        };
        Ok(())
    }
}

rts_runtime::export!(ConsoleIn);

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write;

    use rts_runtime::testing::TestHost;

    use super::*;

    fn numbers(host: &mut TestHost) -> Vec<i32> {
        host.execute().unwrap();
        let samples = host.take::<TimedLong>("out");
        samples.iter().map(|s| s.data).collect()
    }

    #[test]
    fn without_a_path_it_counts_up() {
        let mut host = TestHost::of::<ConsoleIn>().unwrap();
        host.activate().unwrap();
        assert_eq!(numbers(&mut host), [1]);
        assert_eq!(numbers(&mut host), [2]);
    }

    #[test]
    fn a_file_is_followed_and_what_is_no_number_is_skipped() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("numbers");
        fs::write(&path, "1\n x\n\n-2\n3").unwrap();
        let mut host = TestHost::of::<ConsoleIn>().unwrap();
        host.configure("path", path.to_str().unwrap()).unwrap();
        host.activate().unwrap();
        assert_eq!(numbers(&mut host), [1, -2]);
        assert_eq!(
            host.take_log(),
            ["`x` is no number: invalid digit found in string (1 lines skipped so far)"]
        );
        let mut file = fs::OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(b"4\n").unwrap();
        assert_eq!(numbers(&mut host), [34]);
        assert_eq!(numbers(&mut host), [0; 0]);
    }

    #[test]
    fn a_long_file_is_sent_in_portions_and_warned_of_once() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("numbers");
        let lines: Vec<_> = (0..40).map(|n| format!("{n}\nx\n")).collect();
        fs::write(&path, lines.concat()).unwrap();
        let mut host = TestHost::of::<ConsoleIn>().unwrap();
        host.configure("path", path.to_str().unwrap()).unwrap();
        host.activate().unwrap();
        let portions: Vec<_> = (0..6).map(|_| numbers(&mut host)).collect();
        assert_eq!(
            portions.iter().map(Vec::len).collect::<Vec<_>>(),
            [8, 8, 8, 8, 8, 0]
        );
        assert_eq!(portions.concat(), (0..40).collect::<Vec<_>>());
        assert_eq!(host.take_log().len(), 1);
    }

    #[test]
    fn a_fifo_that_nobody_writes_to_blocks_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("fifo");
        let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        rustix::fs::mkfifoat(rustix::fs::CWD, &path, mode).unwrap();
        let mut host = TestHost::of::<ConsoleIn>().unwrap();
        host.configure("path", path.to_str().unwrap()).unwrap();
        host.activate().unwrap();
        assert_eq!(numbers(&mut host), [0; 0]);
        for number in [7, 8] {
            let mut writer = fs::OpenOptions::new().write(true).open(&path).unwrap();
            writeln!(writer, "{number}").unwrap();
            assert_eq!(numbers(&mut host), [number]);
            drop(writer);
            assert_eq!(numbers(&mut host), [0; 0], "the writer is gone");
        }
    }

    #[test]
    fn a_path_that_cannot_be_opened_fails_the_activation_with_its_name() {
        let mut host = TestHost::of::<ConsoleIn>().unwrap();
        host.configure("path", "/does/not/exist").unwrap();
        let failure = host.activate().unwrap_err();
        assert_eq!(
            failure.reason,
            "cannot open `/does/not/exist`: No such file or directory (os error 2)"
        );
    }
}
