//! Sensor: turns encoder counts into a position.

use rts_runtime::types::{TimedFloat, TimedLong};
use rts_runtime::{Component, Context, Declaration, InPort, OutPort, RtcResult, TypeInfo};

/// Encoder counts per unit of position.
const COUNTS: f32 = 1000.0;

struct Sensor {
    input: InPort<TimedLong>,
    output: OutPort<TimedFloat>,
}

impl Component for Sensor {
    const TYPE: TypeInfo = TypeInfo {
        name: "Sensor",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "turns encoder counts into a position",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            output: d.out_port("out"),
        }
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(TimedLong { tm, data }) = self.input.read(ctx)? {
            let data = data as f32 / COUNTS;
            self.output.write(ctx, &TimedFloat { tm, data })?;
        }
        Ok(())
    }
}

rts_runtime::export!(Sensor);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn counts_become_a_position_of_the_same_time() {
        let mut host = TestHost::of::<Sensor>().unwrap();
        host.activate().unwrap();
        let sample = TimedLong::now(-1500);
        host.send("in", &sample);
        host.execute().unwrap();
        let out = host.take::<TimedFloat>("out");
        assert_eq!((out[0].tm, out[0].data), (sample.tm, -1.5));
    }
}
