//! A component of the Rust SDK for the tests of this crate: fails or panics in the callbacks that `fail` names.

use std::thread;
use std::time::Duration;

use rts_runtime::{Component, Config, Context, Declaration, RtcError, RtcResult, TypeInfo, export};

struct Failing {
    fail: Config<Vec<String>>,
    panics: Config<bool>,
    /// Below 0 it asks for cycles.
    produce: Config<i32>,
    /// A thread of its own asks for cycles once it is activated, until it is told that it has ended.
    thread: Config<bool>,
}

impl Failing {
    fn enter(&self, callback: &str) -> RtcResult {
        let fails = |names: &Vec<String>| names.iter().any(|name| name == callback);
        match (self.fail.with(fails), self.panics.get()) {
            (false, _) => Ok(()),
            (true, false) => Err(RtcError::error("told to")),
            (true, true) => panic!("told to"),
        }
    }

    fn wake(&self, ctx: &Context<'_>) -> RtcResult {
        match self.produce.get() {
            ..0 => ctx.wake(),
            _ => Ok(()),
        }
    }
}

macro_rules! callbacks {
    ($($name:ident)*) => {$(
        fn $name(&mut self, _ctx: &mut Context<'_>) -> RtcResult {
            self.enter(stringify!($name))
        }
    )*};
}

impl Component for Failing {
    const TYPE: TypeInfo = TypeInfo {
        name: "Failing",
        vendor: "tests",
        category: "test",
        version: "1.0",
        description: "fails where it is told to",
        rate: 1000.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            fail: d.parameter("fail", Vec::new()),
            panics: d.parameter("panics", false),
            produce: d.parameter("produce", 0),
            thread: d.parameter("thread", false),
        }
    }

    callbacks! {
        on_initialize on_finalize on_startup on_shutdown on_deactivated on_aborting on_error on_reset
        on_state_update on_rate_changed on_configured
    }

    fn on_activated(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.wake(ctx)?;
        if self.thread.get() {
            let waker = ctx.waker();
            let asks = move || {
                while waker.wake().is_ok() {
                    thread::sleep(Duration::from_millis(1));
                }
            };
            thread::Builder::new()
                .name("waker".to_owned())
                .spawn(asks)?;
        }
        self.enter("on_activated")
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        self.wake(ctx)?;
        self.enter("on_execute")
    }
}

export!(Failing);
