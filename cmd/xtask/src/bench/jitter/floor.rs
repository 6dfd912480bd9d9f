//! What the kernel can do at best: a thread that only sleeps until absolute times.

#![allow(unsafe_code)]

use std::io;
use std::num::NonZeroU64;
use std::thread;
use std::time::Duration;

use anyhow::{Result, anyhow};
use rustix::thread::{ClockId, clock_nanosleep_absolute, set_current_timer_slack};
use rustix::time::{Timespec, clock_gettime};

use super::RATE;
use super::load::bind;
use super::series::{Durations, Measured, Timing};

/// Nanoseconds of a second.
const SECOND: u64 = 1_000_000_000;

/// How late such a thread wakes up, scheduled and bound as the component is.
pub fn measure(cpu: usize, priority: Option<u8>, length: Duration) -> Result<Measured> {
    let measured = thread::spawn(move || {
        bind(cpu)?;
        if let Some(priority) = priority
            && let Err(error) = schedule(priority)
        {
            return Ok(Measured::Refused(format!(
                "sched_setscheduler(SCHED_FIFO, {priority}): {error}"
            )));
        }
        set_current_timer_slack(NonZeroU64::new(1))?;
        Ok(Measured::Timing(sleep(length)))
    });
    let ended = measured.join();
    ended.map_err(|_| anyhow!("the thread that sleeps panicked"))?
}

fn sleep(length: Duration) -> Timing {
    let period = SECOND / u64::from(RATE);
    let cycles = length.as_secs() * u64::from(RATE);
    let mut late = Vec::with_capacity(usize::try_from(cycles).unwrap_or_default());
    let mut overruns = 0;
    let mut next = now() + period;
    for _ in 0..cycles {
        let until = Timespec {
            tv_sec: (next / SECOND) as i64,
            tv_nsec: (next % SECOND) as i64,
        };
        // A signal makes it early, which counts as no lateness.
        let _ = clock_nanosleep_absolute(ClockId::Monotonic, &until);
        let now = now();
        late.push(now.saturating_sub(next));
        next += period;
        if now >= next {
            overruns += 1;
            next += (now - next) / period * period + period;
        }
    }
    Timing {
        overruns,
        jitter: Durations::of(late),
    }
}

fn now() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec as u64 * SECOND + now.tv_nsec as u64
}

fn schedule(priority: u8) -> io::Result<()> {
    let parameters = libc::sched_param {
        sched_priority: priority.into(),
    };
    // SAFETY: 0 is the calling thread, and `parameters` is valid during the call.
    match unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}
