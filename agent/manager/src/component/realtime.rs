//! Real time: the processors, the scheduling and the memory of the thread of an execution context.
//!
//! Asked for once, by that thread, before anything of a component runs on it. What the machine does not permit is told with
//! the limit that forbids it, and how it is raised.

#![allow(unsafe_code)]

use std::hint::black_box;
use std::io;
use std::num::NonZeroU64;
use std::sync::atomic::{AtomicBool, Ordering};

use rts_manager_api::control::{Failure, FailureCode, RealtimeInfo, RealtimeRequest};
use rts_schemas::placement::Cpus;
use rustix::io::Errno;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, getpid, getrlimit};
use rustix::thread::{
    CapabilitySet, CpuSet, capabilities, sched_getaffinity, sched_setaffinity,
    set_current_timer_slack,
};

use super::Component;
use crate::failure::failure;
use crate::log::Level;
use crate::manager::Manager;

/// The event of a component that runs without what is not permitted.
const DENIED: &str = "RealTimeDenied";
/// Of its stack, what a callback is likely to use.
const STACK: usize = 256 * 1024;
/// The memory of this process is locked: once, and until it ends.
static LOCKED: AtomicBool = AtomicBool::new(false);

/// Lets the calling thread, which runs an execution context, have what a component asks for that joins it. Refuses what
/// is required and not permitted; what is not required is told.
pub fn join<'a>(
    manager: &Manager,
    component: &Component,
    asked: &RealtimeRequest,
    others: impl Iterator<Item = &'a Component>,
) -> Result<(), Failure> {
    let mut before = others.filter_map(|other| Some((other, other.realtime.get()?)));
    let before = before.next();
    let taken = match before {
        None => take(asked),
        Some((other, found)) => shared(asked, &other.identity.instance, found),
    };
    let denied = taken.denied.join("; ");
    if asked.required && !denied.is_empty() {
        if before.is_none() {
            take(&RealtimeRequest::default());
        }
        let name = &component.identity.instance;
        let message = format!(
            "{name} {denied}; with `resources: {{required: false}}` it runs without what is not permitted"
        );
        return Err(failure(FailureCode::ComponentFailed, message));
    }
    // Only this thread sets it, and only once.
    let _ = component.realtime.set(taken);
    if !denied.is_empty() {
        component.log.write(Level::Warn, &denied);
        manager.events.told(component.target(), DENIED, denied);
    }
    Ok(())
}

/// What a component gets whose execution context has what another one asked for: the same.
fn shared(asked: &RealtimeRequest, other: &str, found: &RealtimeInfo) -> RealtimeInfo {
    let what = |of: &RealtimeRequest| (of.cpus.clone(), of.priority, of.lock_memory);
    let mut denied = found.denied.clone();
    if what(asked) != what(&found.asked) {
        denied.push(format!(
            "cannot have resources of its own on an execution context that {other} shares; say the same `resources` for both"
        ));
    }
    RealtimeInfo {
        asked: asked.clone(),
        denied,
        ..found.clone()
    }
}

/// Takes what is asked for, for the calling thread, and says what it has then. What is not asked for is as in every other
/// thread, but that memory stays locked.
fn take(asked: &RealtimeRequest) -> RealtimeInfo {
    let memory = asked.lock_memory.then(lock_memory);
    let cpus = match &asked.cpus {
        Some(cpus) => Some(bind(cpus)),
        None => {
            unbind();
            None
        }
    };
    let priority = match asked.priority {
        Some(priority) => Some(schedule(priority)),
        None => {
            unschedule();
            None
        }
    };
    if asked.priority.is_some() {
        prefault();
    }
    let taken = [memory, cpus, priority];
    let (scheduler, priority) = scheduling();
    RealtimeInfo {
        asked: asked.clone(),
        scheduler,
        priority,
        cpus: processors().map_or(String::new(), |cpus| cpus.0),
        memory_locked: LOCKED.load(Ordering::Acquire),
        denied: taken
            .into_iter()
            .flatten()
            .filter_map(Result::err)
            .collect(),
    }
}

/// Lets the calling thread wake up when it wants to, and not up to 50 µs later to save power. One on SCHED_FIFO does so
/// anyway.
pub fn wake_in_time() {
    // Without it only jitter grows.
    let _ = set_current_timer_slack(NonZeroU64::new(1));
}

/// Binds it to processors, of which each must be there.
fn bind(asked: &str) -> Result<(), String> {
    let wanted = Cpus::read(asked).ok_or_else(|| format!("`{asked}` is no list of processors"))?;
    let mut set = CpuSet::new();
    wanted.numbers().for_each(|number| set.set(number as usize));
    let before = processors();
    // Those that are not there are left out without a word, unless none is left.
    let bound = sched_setaffinity(None, &set);
    let now = processors();
    if bound.is_ok() && now.as_ref() == Some(&wanted) {
        return Ok(());
    }
    if let (Ok(()), Some(before)) = (bound, &before) {
        let mut set = CpuSet::new();
        before.numbers().for_each(|number| set.set(number as usize));
        // The caller is refused, or goes on as it was.
        let _ = sched_setaffinity(None, &set);
    }
    let there = match (bound, now.or(before)) {
        (Ok(()), Some(now)) => format!("of them there are only {}", now.0),
        (Err(Errno::INVAL), Some(all)) => format!("none of them is there, but {}", all.0),
        (Err(error), _) => io::Error::from(error).to_string(),
        (Ok(()), None) => "what was reached cannot be read".to_owned(),
    };
    Err(format!(
        "cannot run on the processors {} (resources.cpus): {there}; name processors that `/sys/devices/system/cpu/online` and \
         the cpuset of the agent's control group have",
        wanted.0
    ))
}

/// Lets it run where the first thread of the process does.
fn unbind() {
    if let Ok(set) = sched_getaffinity(Some(getpid())) {
        // Only its own limits can forbid it, and then it stays within them.
        let _ = sched_setaffinity(None, &set);
    }
}

/// The processors that it may run on.
fn processors() -> Option<Cpus> {
    let set = sched_getaffinity(None).ok()?;
    let numbers = 0..CpuSet::MAX_CPU;
    let numbers = numbers.filter(|number| set.is_set(*number));
    Some(Cpus::of_numbers(
        numbers.filter_map(|number| number.try_into().ok()),
    ))
}

/// Puts it on SCHED_FIFO. Threads and processes that it starts are not.
fn schedule(priority: u8) -> Result<(), String> {
    let parameters = libc::sched_param {
        sched_priority: priority.into(),
    };
    let policy = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;
    // SAFETY: 0 is the calling thread, and `parameters` is valid during the call.
    if unsafe { libc::sched_setscheduler(0, policy, &raw const parameters) } == 0 {
        return Ok(());
    }
    let error = io::Error::last_os_error();
    let limit = getrlimit(Resource::Rtprio).current;
    let limited = limit.is_some_and(|limit| limit < priority.into());
    let why = match error.raw_os_error() {
        Some(libc::EPERM) if limited && !may(CapabilitySet::SYS_NICE) => {
            let limit = limit.unwrap_or_default();
            format!(
                "RLIMIT_RTPRIO is {limit}, and there is no CAP_SYS_NICE; start its agent with either: LimitRTPRIO={priority} in a \
                 systemd unit, `rtprio {priority}` in /etc/security/limits.conf, or `ulimit -r {priority}` before `rtsctl up`"
            )
        }
        Some(libc::EPERM) => "limits and capabilities of the process would do, so its control group or container forbids \
                              it; give the group a budget (cpu.rt_runtime_us), or start its agent outside"
            .to_owned(),
        _ => "the kernel refused".to_owned(),
    };
    Err(format!(
        "cannot have SCHED_FIFO priority {priority} (resources.realtimePriority): {error}: {why}"
    ))
}

/// Takes it from SCHED_FIFO, which everyone may.
fn unschedule() {
    if scheduling().0 != "SCHED_FIFO" {
        return;
    }
    let parameters = libc::sched_param { sched_priority: 0 };
    // That its children are as usual stays said: only a privileged thread may take that back.
    let policy = libc::SCHED_OTHER | libc::SCHED_RESET_ON_FORK;
    // SAFETY: 0 is the calling thread, and `parameters` is valid during the call.
    unsafe { libc::sched_setscheduler(0, policy, &raw const parameters) };
}

/// How it is scheduled, and its priority.
fn scheduling() -> (String, u8) {
    // SAFETY: 0 is the calling thread.
    let policy = unsafe { libc::sched_getscheduler(0) };
    let mut parameters = libc::sched_param { sched_priority: 0 };
    // SAFETY: 0 is the calling thread, and `parameters` may be written.
    unsafe { libc::sched_getparam(0, &raw mut parameters) };
    let name = match policy & !libc::SCHED_RESET_ON_FORK {
        libc::SCHED_OTHER => "SCHED_OTHER",
        libc::SCHED_FIFO => "SCHED_FIFO",
        libc::SCHED_RR => "SCHED_RR",
        libc::SCHED_BATCH => "SCHED_BATCH",
        libc::SCHED_IDLE => "SCHED_IDLE",
        _ => "unknown",
    };
    let priority = parameters.sched_priority.try_into().unwrap_or_default();
    (name.to_owned(), priority)
}

/// Locks all memory of the process, also what it takes later. With a limit it would get no more memory at some time
/// and die of that, so there must be none.
fn lock_memory() -> Result<(), String> {
    let limit = getrlimit(Resource::Memlock).current;
    let why = match limit {
        Some(limit) if !may(CapabilitySet::IPC_LOCK) => format!(
            "RLIMIT_MEMLOCK is {} KiB, and there is no CAP_IPC_LOCK; start its agent with either: LimitMEMLOCK=infinity in a \
             systemd unit, `memlock unlimited` in /etc/security/limits.conf, or `ulimit -l unlimited` before `rtsctl up`",
            limit / 1024
        ),
        _ => match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
            Ok(()) => {
                LOCKED.store(true, Ordering::Release);
                return Ok(());
            }
            Err(error) => format!("{}; is there enough memory?", io::Error::from(error)),
        },
    };
    Err(format!(
        "cannot lock the memory of its process (resources.lockMemory): {why}"
    ))
}

/// Whether the calling thread has a capability.
fn may(capability: CapabilitySet) -> bool {
    capabilities(None).is_ok_and(|sets| sets.effective.contains(capability))
}

/// Touches its stack, so that no callback waits for a page of it.
#[inline(never)]
fn prefault() {
    let mut stack = [0_u8; STACK];
    for page in stack.chunks_mut(4096) {
        page[0] = 1;
    }
    black_box(&stack);
}

#[cfg(test)]
mod tests {
    use rustix::process::{Rlimit, setrlimit};
    use rustix::thread::set_capabilities;

    use super::*;

    fn asked(cpus: Option<&str>, priority: Option<u8>, lock_memory: bool) -> RealtimeRequest {
        RealtimeRequest {
            cpus: cpus.map(str::to_owned),
            priority,
            lock_memory,
            required: true,
        }
    }

    /// In a thread of its own, as all of it is of a thread.
    fn taken(asked: RealtimeRequest) -> RealtimeInfo {
        std::thread::spawn(move || take(&asked)).join().unwrap()
    }

    /// The same without any permission.
    fn forbidden(asked: RealtimeRequest) -> RealtimeInfo {
        let thread = std::thread::spawn(move || {
            let mut sets = capabilities(None).unwrap();
            sets.effective -= CapabilitySet::SYS_NICE | CapabilitySet::IPC_LOCK;
            set_capabilities(None, sets).unwrap();
            for (resource, most) in [(Resource::Rtprio, 0), (Resource::Memlock, 65_536)] {
                let maximum = getrlimit(resource).maximum;
                let current = Some(most);
                setrlimit(resource, Rlimit { current, maximum }).unwrap();
            }
            take(&asked)
        });
        thread.join().unwrap()
    }

    #[test]
    fn it_runs_on_the_processors_that_it_asks_for() {
        let first = processors().unwrap().numbers().next().unwrap().to_string();
        let found = taken(asked(Some(&first), None, false));
        assert_eq!((found.cpus, found.denied), (first, vec![]));
    }

    #[test]
    fn a_processor_that_is_not_there_is_told_and_nothing_changes() {
        let all = processors().unwrap();
        let first = all.numbers().next().unwrap();
        for (cpus, why) in [
            (
                format!("{first},1023"),
                format!("of them there are only {first};"),
            ),
            (
                "1023".to_owned(),
                format!("none of them is there, but {};", all.0),
            ),
        ] {
            let found = taken(asked(Some(&cpus), None, false));
            assert_eq!(found.cpus, all.0);
            assert!(found.denied[0].contains(&why), "{:?}", found.denied);
        }
    }

    #[test]
    fn what_is_not_permitted_names_the_limit() {
        let found = forbidden(asked(None, Some(50), true));
        assert_eq!(
            (found.scheduler.as_str(), found.priority),
            ("SCHED_OTHER", 0)
        );
        insta::assert_snapshot!(found.denied.join("\n"));
    }

    /// Where the machine permits it, and the reason where not.
    #[test]
    fn fifo_and_locked_memory_are_reached_or_refused() {
        let found = taken(asked(None, Some(7), true));
        match found
            .denied
            .iter()
            .find(|why| why.contains("SCHED_FIFO priority 7"))
        {
            None => assert_eq!(
                (found.scheduler.as_str(), found.priority),
                ("SCHED_FIFO", 7)
            ),
            Some(why) => {
                assert_eq!(found.priority, 0);
                assert!(
                    why.contains("RLIMIT_RTPRIO") || why.contains("control group"),
                    "{why}"
                );
            }
        }
        let refused = found
            .denied
            .iter()
            .any(|why| why.contains("lock the memory"));
        assert_eq!(found.memory_locked, !refused);
    }
}
