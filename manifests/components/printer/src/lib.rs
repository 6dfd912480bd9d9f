//! Printer: logs the samples that it gets, at most one in 100 ms, so that the log of a fast signal stays small.

use std::time::{Duration, Instant};

use rts_runtime::types::TimedDouble;
use rts_runtime::{Component, Config, Context, Declaration, InPort, RtcResult, TypeInfo};

const INTERVAL: Duration = Duration::from_millis(100);

struct Printer {
    input: InPort<TimedDouble>,
    prefix: Config<String>,
    summary: Summary,
    printed: Option<Instant>,
}

/// What was received since activation.
#[derive(Default)]
struct Summary {
    count: u64,
    min: f64,
    max: f64,
}

impl Component for Printer {
    const TYPE: TypeInfo = TypeInfo {
        name: "Printer",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "logs what it receives",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            prefix: d.parameter("prefix", String::new()),
            summary: Summary::default(),
            printed: None,
        }
    }

    fn on_activated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.summary = Summary::default();
        self.printed = None;
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(sample) = self.input.read(ctx)? {
            self.summary.add(sample.data);
            let now = Instant::now();
            if self.printed.is_none_or(|last| now - last >= INTERVAL) {
                self.printed = Some(now);
                self.prefix
                    .with(|prefix| ctx.info(format_args!("{prefix}{:.6}", sample.data)));
            }
        }
        Ok(())
    }

    fn on_deactivated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        let Summary { count, min, max } = self.summary;
        match count {
            0 => ctx.info("received nothing"),
            _ => ctx.info(format_args!(
                "received {count} samples from {min:.6} to {max:.6}"
            )),
        }
        Ok(())
    }
}

impl Summary {
    fn add(&mut self, value: f64) {
        (self.min, self.max) = match self.count {
            0 => (value, value),
            _ => (self.min.min(value), self.max.max(value)),
        };
        self.count += 1;
    }
}

rts_runtime::export!(Printer);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn the_first_sample_is_printed_and_the_end_has_a_summary() {
        let mut host = TestHost::of::<Printer>().unwrap();
        host.configure("prefix", "x = ").unwrap();
        host.activate().unwrap();
        for value in [1.5, -2.0, 0.25] {
            host.send("in", &TimedDouble::now(value));
        }
        host.execute().unwrap();
        host.deactivate().unwrap();
        let log = host.take_log();
        assert_eq!(log.first().unwrap(), "x = 1.500000");
        assert_eq!(
            log.last().unwrap(),
            "received 3 samples from -2.000000 to 1.500000"
        );
    }

    #[test]
    fn nothing_received_is_said() {
        let mut host = TestHost::of::<Printer>().unwrap();
        host.activate().unwrap();
        host.execute().unwrap();
        host.deactivate().unwrap();
        assert_eq!(host.take_log(), ["received nothing"]);
    }
}
