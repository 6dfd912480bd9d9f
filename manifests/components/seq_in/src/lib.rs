//! SeqIn: receives what SeqOut sends and logs, once a second, how many samples came at each port.

use std::fmt::Write;
use std::time::{Duration, Instant};

use rts_runtime::types::{
    DataType, TimedDouble, TimedDoubleSeq, TimedFloat, TimedFloatSeq, TimedLong, TimedLongSeq,
    TimedOctet, TimedOctetSeq, TimedShort, TimedShortSeq,
};
use rts_runtime::{Component, Context, Declaration, InPort, RtcResult, TypeInfo};

const INTERVAL: Duration = Duration::from_secs(1);

struct SeqIn {
    octet: Counted<TimedOctet>,
    short: Counted<TimedShort>,
    long: Counted<TimedLong>,
    float: Counted<TimedFloat>,
    double: Counted<TimedDouble>,
    octets: Counted<TimedOctetSeq>,
    shorts: Counted<TimedShortSeq>,
    longs: Counted<TimedLongSeq>,
    floats: Counted<TimedFloatSeq>,
    doubles: Counted<TimedDoubleSeq>,
    since: Option<Instant>,
}

/// An in-port that counts its samples.
struct Counted<T> {
    name: &'static str,
    port: InPort<T>,
    count: u64,
}

/// A port of any type.
trait Port {
    fn drain(&mut self, ctx: &mut Context<'_>) -> RtcResult;
    /// Writes ` Name=count` unless the count is 0, and starts anew.
    fn report(&mut self, line: &mut String);
}

impl<T: DataType> Counted<T> {
    fn new(d: &mut Declaration, name: &'static str) -> Self {
        let port = d.in_port(name);
        let count = 0;
        Self { name, port, count }
    }
}

impl<T: DataType> Port for Counted<T> {
    fn drain(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while self.port.read(ctx)?.is_some() {
            self.count += 1;
        }
        Ok(())
    }

    fn report(&mut self, line: &mut String) {
        let count = std::mem::take(&mut self.count);
        if count > 0 {
            // Writing to a String cannot fail.
            let _ = write!(line, " {}={count}", self.name);
        }
    }
}

impl Component for SeqIn {
    const TYPE: TypeInfo = TypeInfo {
        name: "SeqIn",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "receives every basic type and logs how many came",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            octet: Counted::new(d, "Octet"),
            short: Counted::new(d, "Short"),
            long: Counted::new(d, "Long"),
            float: Counted::new(d, "Float"),
            double: Counted::new(d, "Double"),
            octets: Counted::new(d, "OctetSeq"),
            shorts: Counted::new(d, "ShortSeq"),
            longs: Counted::new(d, "LongSeq"),
            floats: Counted::new(d, "FloatSeq"),
            doubles: Counted::new(d, "DoubleSeq"),
            since: None,
        }
    }

    fn on_activated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.since = Some(Instant::now());
        self.take_report();
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        for port in self.ports() {
            port.drain(ctx)?;
        }
        if self.since.is_none_or(|since| since.elapsed() >= INTERVAL) {
            self.since = Some(Instant::now());
            let report = self.take_report();
            ctx.info(format_args!("in 1 s received{report}"));
        }
        Ok(())
    }

    fn on_deactivated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        let report = self.take_report();
        ctx.info(format_args!("at last received{report}"));
        Ok(())
    }
}

impl SeqIn {
    fn ports(&mut self) -> [&mut dyn Port; 10] {
        [
            &mut self.octet,
            &mut self.short,
            &mut self.long,
            &mut self.float,
            &mut self.double,
            &mut self.octets,
            &mut self.shorts,
            &mut self.longs,
            &mut self.floats,
            &mut self.doubles,
        ]
    }

    fn take_report(&mut self) -> String {
        let mut line = String::new();
        for port in self.ports() {
            port.report(&mut line);
        }
        match line.is_empty() {
            true => " nothing".into(),
            false => line,
        }
    }
}

rts_runtime::export!(SeqIn);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn what_came_since_the_last_report_is_counted_by_port() {
        let mut host = TestHost::of::<SeqIn>().unwrap();
        host.activate().unwrap();
        host.send("Octet", &TimedOctet::now(1));
        host.send("DoubleSeq", &TimedDoubleSeq::now([1.0]));
        host.send("DoubleSeq", &TimedDoubleSeq::now([]));
        host.execute().unwrap();
        host.deactivate().unwrap();
        host.deactivate().unwrap();
        assert_eq!(
            host.take_log(),
            [
                "at last received Octet=1 DoubleSeq=2",
                "at last received nothing"
            ]
        );
    }
}
