//! Motor: a velocity moves it; sends its position in encoder counts.

use rts_runtime::types::TimedFloat;
use rts_runtime::types::TimedLong;
use rts_runtime::{Component, Config, Context, Declaration, InPort, OutPort, RtcResult, TypeInfo};

/// Encoder counts per unit of position.
const COUNTS: f64 = 1000.0;
/// How long a command lasts, in seconds. Fixed, so that the position depends on the commands alone.
const STEP: f64 = 0.01;

struct Motor {
    input: InPort<TimedFloat>,
    output: OutPort<TimedLong>,
    motor_id: Config<i32>,
    position: f64,
}

impl Component for Motor {
    const TYPE: TypeInfo = TypeInfo {
        name: "Motor",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "integrates a velocity to an encoder position",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            output: d.out_port("out"),
            motor_id: d.parameter("motor_id", 0),
            position: 0.0,
        }
    }

    fn on_activated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.position = 0.0;
        ctx.info(format_args!("motor {} is on", self.motor_id.get()));
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(velocity) = self.input.read(ctx)? {
            self.position += f64::from(velocity.data) * STEP;
            // Saturates at the ends of the encoder.
            let counts = (self.position * COUNTS).round() as i32;
            self.output.write(ctx, &TimedLong::now(counts))?;
        }
        Ok(())
    }

    fn on_deactivated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        ctx.info(format_args!("motor {} is off", self.motor_id.get()));
        Ok(())
    }
}

rts_runtime::export!(Motor);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn velocity_becomes_position() {
        let mut host = TestHost::of::<Motor>().unwrap();
        host.configure("motor_id", "3").unwrap();
        host.activate().unwrap();
        for velocity in [0.5, 0.5, -2.0, 1e30] {
            host.send("in", &TimedFloat::now(velocity));
        }
        host.execute().unwrap();
        let counts = host.take::<TimedLong>("out");
        assert_eq!(
            counts.iter().map(|c| c.data).collect::<Vec<_>>(),
            [5, 10, -10, i32::MAX]
        );
        assert_eq!(host.take_log(), ["motor 3 is on"]);
    }
}
