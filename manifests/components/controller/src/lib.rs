//! Controller: drives a measured position to 1 with a proportional law; with Motor and Sensor it closes a loop.

use rts_runtime::types::TimedFloat;
use rts_runtime::{Component, Context, Declaration, InPort, OutPort, RtcResult, TypeInfo};

const TARGET: f32 = 1.0;
const GAIN: f32 = 0.5;

struct Controller {
    input: InPort<TimedFloat>,
    output: OutPort<TimedFloat>,
    position: f32,
}

impl Component for Controller {
    const TYPE: TypeInfo = TypeInfo {
        name: "Controller",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "commands a velocity from a measured position",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            output: d.out_port("out"),
            position: 0.0,
        }
    }

    fn on_activated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.position = 0.0;
        Ok(())
    }

    /// It sends in each cycle, measured or not: otherwise no loop would ever start.
    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        if let Some(measured) = self.input.read_newest(ctx)? {
            self.position = measured.data;
        }
        let velocity = GAIN * (TARGET - self.position);
        self.output.write(ctx, &TimedFloat::now(velocity))?;
        Ok(())
    }
}

rts_runtime::export!(Controller);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn the_command_follows_the_newest_measurement() {
        let mut host = TestHost::of::<Controller>().unwrap();
        host.activate().unwrap();
        host.execute().unwrap();
        host.send("in", &TimedFloat::now(9.0));
        host.send("in", &TimedFloat::now(1.5));
        host.execute().unwrap();
        let commands = host.take::<TimedFloat>("out");
        assert_eq!(
            commands.iter().map(|c| c.data).collect::<Vec<_>>(),
            [0.5, -0.25]
        );
    }
}
