//! Misbehaving: passes samples on until it misbehaves as it is told, to try what runs components.

mod fault;
mod grandchildren;
mod leak;

use std::thread;
use std::time::{Duration, Instant};

use rts_runtime::types::TimedLong;
use rts_runtime::{
    Component, Config, Context, Declaration, InPort, OutPort, RtcError, RtcResult, TypeInfo,
};

use fault::{Callback, Fault};

/// How long one call of `on_execute` floods. No shorter than a period, so that it never pauses.
const FLOOD: Duration = Duration::from_millis(10);

struct Misbehaving {
    input: InPort<TimedLong>,
    output: OutPort<TimedLong>,
    /// One of [`fault::WORDS`].
    fault: Config<String>,
    /// Seconds from activation to what comes later.
    after: Config<f64>,
    /// Seconds that a slow callback takes.
    seconds: Config<f64>,
    /// MiB that leak in one process at most.
    leak_limit: Config<u32>,
    /// Exit status of the fault `exit`.
    exit_code: Config<u8>,
    activated: Option<Instant>,
    flooded: i32,
    has_children: bool,
}

impl Component for Misbehaving {
    const TYPE: TypeInfo = TypeInfo {
        name: "Misbehaving",
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
            fault: d.parameter("fault", "none".to_owned()),
            after: d.parameter("after", 1.0).check(is_time),
            seconds: d.parameter("seconds", 2.0).check(is_time),
            leak_limit: d.parameter("leak_limit", 64),
            exit_code: d.parameter("exit_code", 0),
            activated: None,
            flooded: 0,
            has_children: false,
        }
    }

    fn on_initialize(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        if self.fault()? == Fault::CrashAtOnce {
            ctx.warn("crashes in on_initialize");
            std::process::abort();
        }
        self.enter(Callback::Initialize, ctx)
    }

    fn on_finalize(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::Finalize, ctx)
    }

    fn on_startup(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::Startup, ctx)
    }

    fn on_shutdown(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::Shutdown, ctx)
    }

    fn on_activated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::Activate, ctx)?;
        match self.fault()? {
            Fault::SlowActivate => thread::sleep(Duration::from_secs_f64(self.seconds.get())),
            Fault::Grandchildren => self.start_children(ctx)?,
            _ => {}
        }
        self.activated = Some(Instant::now());
        Ok(())
    }

    fn on_deactivated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::Deactivate, ctx)
    }

    fn on_aborting(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::Abort, ctx)
    }

    fn on_error(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::Error, ctx)
    }

    fn on_reset(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::Reset, ctx)
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(sample) = self.input.read(ctx)? {
            self.output.write(ctx, &sample)?;
        }
        if !self.is_later() {
            return Ok(());
        }
        self.enter(Callback::Execute, ctx)?;
        match self.fault()? {
            Fault::CrashLater => {
                ctx.warn("crashes in on_execute");
                std::process::abort()
            }
            Fault::Exit => {
                ctx.warn("ends its process in on_execute");
                std::process::exit(self.exit_code.get().into())
            }
            Fault::Panic => panic!("told to panic in on_execute"),
            Fault::Hang(then) | Fault::Fail(then) if then.is_after_an_error() => {
                Err(told_to_fail(Callback::Execute))
            }
            Fault::Flood => self.flood(ctx),
            Fault::Leak => {
                leak::grow(self.leak_limit.get(), ctx);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn on_state_update(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        match self.is_later() {
            true => self.enter(Callback::StateUpdate, ctx),
            false => Ok(()),
        }
    }

    fn on_rate_changed(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.enter(Callback::RateChanged, ctx)
    }
}

impl Misbehaving {
    fn fault(&self) -> RtcResult<Fault> {
        let fault = self.fault.with(|word| fault::read(word));
        fault.map_err(|why| RtcError::bad_parameter(format_args!("parameter `fault`: {why}")))
    }

    /// Hangs or fails in a callback when that is the fault.
    fn enter(&self, callback: Callback, ctx: &Context<'_>) -> RtcResult {
        match self.fault()? {
            Fault::Hang(here) if here == callback => {
                ctx.warn(format_args!("hangs in {}", callback.method()));
                hang()
            }
            Fault::Fail(here) if here == callback => Err(told_to_fail(callback)),
            _ => Ok(()),
        }
    }

    /// True once the time from the activation to the fault is over.
    fn is_later(&self) -> bool {
        let after = Duration::from_secs_f64(self.after.get());
        self.activated.is_some_and(|since| since.elapsed() >= after)
    }

    fn flood(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        let begin = Instant::now();
        while begin.elapsed() < FLOOD {
            self.flooded = self.flooded.wrapping_add(1);
            self.output.write(ctx, &TimedLong::now(self.flooded))?;
        }
        Ok(())
    }

    fn start_children(&mut self, ctx: &Context<'_>) -> RtcResult {
        if !std::mem::replace(&mut self.has_children, true) {
            let [beside, away] = grandchildren::start()
                .map_err(|e| RtcError::error(format_args!("no process can be started: {e}")))?;
            ctx.warn(format_args!("started processes {beside} and {away}"));
        }
        Ok(())
    }
}

/// A time in seconds that can be waited for.
fn is_time(seconds: &f64) -> Result<(), String> {
    let is_time = (0.0..=1e6).contains(seconds);
    is_time
        .then_some(())
        .ok_or("must be from 0 to 1000000 seconds".into())
}

fn told_to_fail(callback: Callback) -> RtcError {
    RtcError::error(format_args!("told to fail {}", callback.method()))
}

fn hang() -> ! {
    loop {
        thread::sleep(Duration::from_secs(3600));
    }
}

rts_runtime::export!(Misbehaving);

#[cfg(test)]
mod tests;
