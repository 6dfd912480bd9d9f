//! Faulty: passes samples on until it misbehaves as it is told, to test what runs components.

mod child;
mod choices;

use std::thread;
use std::time::{Duration, Instant};

use rts_runtime::types::TimedDouble;
use rts_runtime::{
    Component, Config, Context, Declaration, InPort, OutPort, RtcError, RtcResult, TypeInfo,
};

use choices::{Child, Hang, Mode};

struct Faulty {
    input: InPort<TimedDouble>,
    output: OutPort<TimedDouble>,
    mode: Config<Mode>,
    /// A callback that does not return.
    hang: Config<Hang>,
    /// Milliseconds from activation to the fault.
    after_ms: Config<u64>,
    /// Calls of `on_execute` before the fault.
    after_executions: Config<u64>,
    /// Exit status of the mode `exit_after`.
    exit_code: Config<u8>,
    /// Milliseconds that `on_activated` takes.
    activation_ms: Config<u64>,
    child: Config<Child>,
    activated: Option<Instant>,
    executions: u64,
    has_child: bool,
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
            hang: d.parameter("hang", Hang::Nowhere),
            after_ms: d.parameter("after_ms", 0),
            after_executions: d.parameter("after_executions", 0),
            exit_code: d.parameter("exit_code", 0),
            activation_ms: d.parameter("activation_ms", 0),
            child: d.parameter("child", Child::None),
            activated: None,
            executions: 0,
            has_child: false,
        }
    }

    fn on_initialize(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.hang_in(Hang::Initialize);
        match self.mode.get() {
            Mode::FailInitialize => Err(RtcError::error("told to fail on_initialize")),
            _ => Ok(()),
        }
    }

    fn on_activated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.hang_in(Hang::Activated);
        match self.mode.get() {
            Mode::FailActivate => return Err(RtcError::error("told to fail on_activated")),
            Mode::HangActivate => hang(),
            _ => {}
        }
        self.start_child(ctx)?;
        thread::sleep(Duration::from_millis(self.activation_ms.get()));
        self.activated = Some(Instant::now());
        self.executions = 0;
        Ok(())
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(sample) = self.input.read(ctx)? {
            self.output.write(ctx, &sample)?;
        }
        if !self.is_time() {
            return Ok(());
        }
        self.hang_in(Hang::Execute);
        match self.mode.get() {
            Mode::ErrorAfter => Err(RtcError::error("told to fail on_execute")),
            Mode::PanicAfter => panic!("told to panic in on_execute"),
            Mode::CrashAfter => std::process::abort(),
            Mode::ExitAfter => std::process::exit(self.exit_code.get().into()),
            Mode::HangExecute => hang(),
            Mode::None | Mode::FailInitialize | Mode::FailActivate | Mode::HangActivate => Ok(()),
        }
    }

    fn on_deactivated(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.hang_in(Hang::Deactivated);
        Ok(())
    }

    fn on_error(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.hang_in(Hang::Error);
        Ok(())
    }

    fn on_reset(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.hang_in(Hang::Reset);
        Ok(())
    }

    fn on_finalize(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
        self.hang_in(Hang::Finalize);
        Ok(())
    }
}

impl Faulty {
    fn hang_in(&self, callback: Hang) {
        if self.hang.get() == callback {
            hang();
        }
    }

    /// Counts an execution; true once the time and the executions before the fault are over.
    fn is_time(&mut self) -> bool {
        let before = self.executions;
        self.executions += 1;
        let after = Duration::from_millis(self.after_ms.get());
        before >= self.after_executions.get()
            && self.activated.is_some_and(|since| since.elapsed() >= after)
    }

    fn start_child(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        if self.has_child {
            return Ok(());
        }
        let started = child::start(self.child.get());
        let pid = started.map_err(|e| RtcError::error(format!("no child process: {e}")))?;
        if let Some(pid) = pid {
            ctx.info(format_args!("started process {pid}"));
            self.has_child = true;
        }
        Ok(())
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
             error_after, panic_after, crash_after, exit_after, hang_activate, hang_execute"
        );
    }

    #[test]
    fn a_fault_waits_for_its_executions_after_each_activation() {
        let mut host = host("error_after");
        host.configure("after_executions", "2").unwrap();
        for _ in 0..2 {
            host.activate().unwrap();
            host.execute().unwrap();
            host.execute().unwrap();
            host.execute().unwrap_err();
        }
    }

    #[test]
    fn an_activation_takes_as_long_as_it_is_told_to() {
        let mut host = host("none");
        host.configure("activation_ms", "30").unwrap();
        let begin = Instant::now();
        host.activate().unwrap();
        assert!(begin.elapsed() >= Duration::from_millis(30));
    }

    /// Words of `/proc/PID/stat` from the state on.
    fn stat(pid: &str) -> Vec<String> {
        let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
        let rest = text.rsplit_once(") ").unwrap().1;
        rest.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn a_child_ignores_sigterm_and_has_a_session_of_its_own_when_told_to() {
        for (kind, alone) in [("ignores_term", false), ("own_session", true)] {
            let mut host = host("none");
            host.configure("child", kind).unwrap();
            host.activate().unwrap();
            let log = host.take_log().join("\n");
            let pid = log.rsplit_once("started process ").unwrap().1.to_owned();
            let begin = Instant::now();
            let sleeps =
                || std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap() == "sleep\n";
            while !sleeps() {
                assert!(begin.elapsed() < Duration::from_secs(10));
                thread::sleep(Duration::from_millis(2));
            }
            assert_eq!(stat(&pid)[3] == pid, alone, "its session");
            let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
            let ignored = status.lines().find_map(|l| l.strip_prefix("SigIgn:\t"));
            let ignored = u64::from_str_radix(ignored.unwrap(), 16).unwrap();
            assert_ne!(ignored & 1 << 14, 0, "SIGTERM is ignored");
            let kill = std::process::Command::new("kill")
                .args(["-KILL", &pid])
                .status();
            assert!(kill.unwrap().success());
        }
    }
}
