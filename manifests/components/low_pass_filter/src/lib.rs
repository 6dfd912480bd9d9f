//! LowPassFilter: exponential smoothing, y += alpha (x - y), times a gain.

use rts_runtime::types::TimedDouble;
use rts_runtime::{Component, Config, Context, Declaration, InPort, OutPort, RtcResult, TypeInfo};

struct LowPassFilter {
    input: InPort<TimedDouble>,
    output: OutPort<TimedDouble>,
    alpha: Config<f64>,
    gain: Config<f64>,
    /// None until the first sample, which sets it.
    state: Option<f64>,
}

impl Component for LowPassFilter {
    const TYPE: TypeInfo = TypeInfo {
        name: "LowPassFilter",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "smooths a signal",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            output: d.out_port("out"),
            alpha: d.parameter("alpha", 0.1).check(|alpha| {
                let good = *alpha > 0.0 && *alpha <= 1.0;
                good.then_some(())
                    .ok_or("must be above 0 and at most 1".into())
            }),
            gain: d.parameter("gain", 1.0),
            state: None,
        }
    }

    fn on_activated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.state = None;
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(mut sample) = self.input.read(ctx)? {
            let before = self.state.unwrap_or(sample.data);
            let now = before + self.alpha.get() * (sample.data - before);
            self.state = Some(now);
            sample.data = self.gain.get() * now;
            self.output.write(ctx, &sample)?;
        }
        Ok(())
    }
}

rts_runtime::export!(LowPassFilter);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;
    use rts_runtime::types::Time;

    use super::*;

    fn feed(host: &mut TestHost, values: &[f64]) -> Vec<f64> {
        for (i, &data) in values.iter().enumerate() {
            let tm = Time {
                sec: i as u32,
                nsec: 0,
            };
            host.send("in", &TimedDouble { tm, data });
        }
        host.execute().unwrap();
        let samples = host.take::<TimedDouble>("out");
        assert!(
            samples
                .iter()
                .enumerate()
                .all(|(i, s)| s.tm.sec == i as u32),
            "a sample keeps its time"
        );
        samples.iter().map(|s| s.data).collect()
    }

    #[test]
    fn a_step_is_followed_by_alpha_and_activation_forgets_it() {
        let mut host = TestHost::of::<LowPassFilter>().unwrap();
        host.configure("alpha", "0.5").unwrap();
        host.configure("gain", "2").unwrap();
        host.activate().unwrap();
        assert_eq!(feed(&mut host, &[0.0, 1.0, 1.0]), [0.0, 1.0, 1.5]);
        host.deactivate().unwrap();
        host.activate().unwrap();
        assert_eq!(feed(&mut host, &[4.0]), [8.0]);
    }

    #[test]
    fn alpha_has_a_range() {
        let mut host = TestHost::of::<LowPassFilter>().unwrap();
        let failure = host.configure("alpha", "1.5").unwrap_err();
        assert_eq!(
            failure.to_string(),
            "BAD_PARAMETER: parameter `alpha` = `1.5`: must be above 0 and at most 1"
        );
        assert!(host.configure("alpha", "NaN").is_err());
    }
}
