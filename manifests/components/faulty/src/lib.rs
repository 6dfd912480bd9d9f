//! Faulty: passes samples on until it misbehaves as it is told, to test what runs components.

mod mode;

use std::thread;
use std::time::{Duration, Instant};

use rts_runtime::types::TimedDouble;
use rts_runtime::{
    Component, Config, Context, Declaration, InPort, OutPort, RtcError, RtcResult, TypeInfo,
};

use mode::Mode;

struct Faulty {
    input: InPort<TimedDouble>,
    output: OutPort<TimedDouble>,
    mode: Config<Mode>,
    /// Milliseconds from activation to the fault.
    after_ms: Config<u64>,
    activated: Option<Instant>,
}

impl Component for Faulty {
    const TYPE: TypeInfo = TypeInfo {
        name: "Faulty",
        vendor: "rtsctl",
        category: "test",
        version: "0.1.0",
        description: "misbehaves as it is told",
        rate: 100.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            output: d.out_port("out"),
            mode: d.parameter("mode", Mode::None),
            after_ms: d.parameter("after_ms", 0),
            activated: None,
        }
    }

    fn on_initialize(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        match self.mode.get() {
            Mode::FailInitialize => Err(RtcError::error("told to fail on_initialize")),
            _ => Ok(()),
        }
    }

    fn on_activated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        match self.mode.get() {
            Mode::FailActivate => return Err(RtcError::error("told to fail on_activated")),
            Mode::HangActivate => hang(),
            _ => {}
        }
        self.activated = Some(Instant::now());
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(sample) = self.input.read(ctx)? {
            self.output.write(ctx, &sample)?;
        }
        let after = Duration::from_millis(self.after_ms.get());
        if self.activated.is_none_or(|since| since.elapsed() < after) {
            return Ok(());
        }
        match self.mode.get() {
            Mode::ErrorAfter => Err(RtcError::error("told to fail on_execute")),
            Mode::PanicAfter => panic!("told to panic in on_execute"),
            Mode::CrashAfter => std::process::abort(),
            Mode::HangExecute => hang(),
            Mode::None | Mode::FailInitialize | Mode::FailActivate | Mode::HangActivate => Ok(()),
        }
    }
}

fn hang() -> ! {
    loop {
        thread::sleep(Duration::from_secs(3600));
    }
}

rts_runtime::export!(Faulty);

#[cfg(test)]
mod tests {
    use rts_runtime::ReturnCode;
    use rts_runtime::abi::callback;
    use rts_runtime::testing::TestHost;

    use super::*;

    fn host(mode: &str) -> TestHost {
        let mut host = TestHost::of::<Faulty>().unwrap();
        host.configure("mode", mode).unwrap();
        host
    }

    #[test]
    fn without_a_mode_it_passes_samples_on() {
        let mut host = host("none");
        host.activate().unwrap();
        host.send("in", &TimedDouble::now(4.5));
        host.execute().unwrap();
        assert_eq!(host.take::<TimedDouble>("out")[0].data, 4.5);
    }

    #[test]
    fn it_fails_where_it_is_told_to() {
        let mut initialize = host("fail_initialize");
        let failure = initialize.callback(callback::INITIALIZE).unwrap_err();
        assert_eq!(failure.reason, "told to fail on_initialize");
        let failure = host("fail_activate").activate().unwrap_err();
        assert_eq!(failure.reason, "told to fail on_activated");
    }

    #[test]
    fn a_fault_while_active_waits_for_its_time() {
        for (mode, reason) in [
            ("error_after", "told to fail on_execute"),
            ("panic_after", "told to panic in on_execute"),
        ] {
            let mut host = host(mode);
            host.configure("after_ms", "3600000").unwrap();
            host.activate().unwrap();
            host.execute().unwrap();
            host.configure("after_ms", "0").unwrap();
            let failure = host.execute().unwrap_err();
            assert_eq!(failure.code, ReturnCode::Error);
            assert!(failure.reason.ends_with(reason), "{failure}");
        }
    }

    #[test]
    fn an_unknown_mode_names_the_known_ones() {
        let mut host = host("none");
        assert_eq!(
            host.configure("mode", "sulk").unwrap_err().reason,
            "parameter `mode`: cannot read `sulk`, expected one of none, fail_initialize, fail_activate, \
             error_after, panic_after, crash_after, hang_activate, hang_execute"
        );
    }
}
