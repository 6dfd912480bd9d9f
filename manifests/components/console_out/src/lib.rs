//! ConsoleOut: logs each value that it receives, as OpenRTM's example prints it, and stops short of flooding the log.

use std::time::{Duration, Instant};

use rts_runtime::types::TimedLong;
use rts_runtime::{Component, Context, Declaration, InPort, RtcResult, TypeInfo};

/// Lines that are logged in a second; the values above are counted.
const PER_SECOND: u32 = 100;

struct ConsoleOut {
    input: InPort<TimedLong>,
    limit: Limit,
}

/// Counts lines within the running second.
#[derive(Default)]
struct Limit {
    since: Option<Instant>,
    lines: u32,
}

impl Component for ConsoleOut {
    const TYPE: TypeInfo = TypeInfo {
        name: "ConsoleOut",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "logs the numbers that it receives",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            limit: Limit::default(),
        }
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(sample) = self.input.read(ctx)? {
            let (more, log) = self.limit.line(Instant::now());
            if more > 0 {
                ctx.info(format_args!("received {more} more in that second"));
            }
            if log {
                ctx.info(format_args!("received {}", sample.data));
            }
        }
        Ok(())
    }
}

impl Limit {
    /// How many lines the second before has swallowed, if it has just ended, and whether to log this one.
    fn line(&mut self, now: Instant) -> (u32, bool) {
        let mut more = 0;
        let second = Duration::from_secs(1);
        if self.since.is_none_or(|since| now - since >= second) {
            more = self.lines.saturating_sub(PER_SECOND);
            self.since = Some(now);
            self.lines = 0;
        }
        self.lines = self.lines.saturating_add(1);
        (more, self.lines <= PER_SECOND)
    }
}

rts_runtime::export!(ConsoleOut);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn each_value_is_logged() {
        let mut host = TestHost::of::<ConsoleOut>().unwrap();
        host.activate().unwrap();
        host.send("in", &TimedLong::now(-5));
        host.send("in", &TimedLong::now(6));
        host.execute().unwrap();
        assert_eq!(host.take_log(), ["received -5", "received 6"]);
    }

    #[test]
    fn a_flood_is_counted() {
        let mut limit = Limit::default();
        let start = Instant::now();
        let logged = (0..250).filter(|_| limit.line(start).1).count();
        assert_eq!(logged as u32, PER_SECOND);
        assert_eq!(limit.line(start + Duration::from_secs(1)), (150, true));
        assert_eq!(limit.line(start + Duration::from_secs(2)), (0, true));
    }
}
