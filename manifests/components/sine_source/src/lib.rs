//! SineSource: a sine wave by the clock, so that its form does not depend on the rate.

use std::f64::consts::TAU;
use std::time::Instant;

use rts_runtime::types::TimedDouble;
use rts_runtime::{Component, Config, Context, Declaration, OutPort, RtcResult, TypeInfo};

struct SineSource {
    out: OutPort<TimedDouble>,
    amplitude: Config<f64>,
    frequency: Config<f64>,
    /// In turns, from 0 to 1.
    phase: f64,
    last: Option<Instant>,
}

impl Component for SineSource {
    const TYPE: TypeInfo = TypeInfo {
        name: "SineSource",
        vendor: "rtsctl",
        category: "example",
        version: "0.1.0",
        description: "sends a sine wave",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            out: d.out_port("out"),
            amplitude: d.parameter("amplitude", 1.0).check(finite),
            frequency: d.parameter("frequency", 1.0).check(finite),
            phase: 0.0,
            last: None,
        }
    }

    fn on_activated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.phase = 0.0;
        self.last = None;
        let (amplitude, frequency) = (self.amplitude.get(), self.frequency.get());
        ctx.info(format_args!("amplitude {amplitude}, {frequency} Hz"));
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        let now = Instant::now();
        let elapsed = self.last.map_or(0.0, |last| (now - last).as_secs_f64());
        self.last = Some(now);
        self.phase = turn(self.phase, self.frequency.get(), elapsed);
        let value = self.amplitude.get() * (TAU * self.phase).sin();
        self.out.write(ctx, &TimedDouble::now(value))?;
        Ok(())
    }
}

fn finite(value: &f64) -> Result<(), String> {
    value
        .is_finite()
        .then_some(())
        .ok_or("must be finite".into())
}

/// Turns the phase on; a new frequency bends the wave but never breaks it.
fn turn(phase: f64, frequency: f64, seconds: f64) -> f64 {
    (phase + frequency * seconds).rem_euclid(1.0)
}

rts_runtime::export!(SineSource);

#[cfg(test)]
mod tests {
    use rts_runtime::testing::TestHost;

    use super::*;

    #[test]
    fn a_quarter_of_a_turn_at_two_hertz_takes_an_eighth_of_a_second() {
        assert!((turn(0.0, 2.0, 0.125) - 0.25).abs() < 1e-12);
        assert!((turn(0.9, 1.0, 0.2) - 0.1).abs() < 1e-12);
        assert!((0.0..1.0).contains(&turn(0.1, -1.0, 0.5)));
    }

    #[test]
    fn it_starts_at_zero_and_stays_within_the_amplitude() {
        let mut host = TestHost::of::<SineSource>().unwrap();
        host.configure("amplitude", "2").unwrap();
        host.configure("frequency", "1e6").unwrap();
        host.activate().unwrap();
        for _ in 0..20 {
            host.execute().unwrap();
        }
        let samples = host.take::<TimedDouble>("out");
        assert_eq!(samples.len(), 20);
        assert_eq!(samples[0].data, 0.0);
        assert!(samples.iter().all(|s| s.data.abs() <= 2.0));
        assert!(samples.iter().any(|s| s.data != 0.0));
        assert!(host.configure("amplitude", "inf").is_err());
    }
}
