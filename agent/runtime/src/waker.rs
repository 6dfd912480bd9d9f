//! Asks for a cycle from any thread, also when the component has ended meanwhile.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::sync::{Arc, Mutex, PoisonError};

use crate::abi::{self, Host};
use crate::{ReturnCode, RtcError, RtcResult};

/// Asks an event-driven execution context for a cycle, from any thread. Clones are for the same component; they may outlive
/// it, and then only say so.
///
/// ```
/// # use rts_runtime::{Context, RtcResult};
/// # fn on_activated(ctx: &mut Context<'_>) -> RtcResult {
/// let waker = ctx.waker();
/// std::thread::spawn(move || {
///     // A device has something to tell. It ends when the component has ended.
///     while waker.wake().is_ok() {
///         std::thread::sleep(std::time::Duration::from_millis(100));
///     }
/// });
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Waker(Arc<Mutex<Option<Link>>>);

/// Of the host of an instance that has not ended, what asks for a cycle.
#[derive(Debug, Clone, Copy)]
struct Link {
    wake: unsafe extern "C" fn(context: *mut c_void) -> i32,
    context: *mut c_void,
}

// SAFETY: of a host only `wake` is used here, which any thread may call.
unsafe impl Send for Link {}

impl Link {
    fn of(host: &Host) -> Self {
        Self {
            wake: host.wake,
            context: host.context,
        }
    }

    /// # Safety
    /// The instance whose host it is has not ended.
    unsafe fn wake(self) -> RtcResult {
        // SAFETY: the host's own context is passed back to it, and it is there as long as the instance.
        match unsafe { (self.wake)(self.context) } {
            abi::return_code::OK => Ok(()),
            code => Err(RtcError::new(
                ReturnCode::from_number(code),
                "the execution context cannot be woken: it is not event-driven",
            )),
        }
    }
}

impl Waker {
    /// Asks for a cycle. Several calls before it begins are one.
    ///
    /// # Errors
    /// The execution context is not event-driven, or the component has ended.
    pub fn wake(&self) -> RtcResult {
        let link = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*link {
            // SAFETY: the instance takes the link away before it ends, and waits for the lock.
            Some(link) => unsafe { link.wake() },
            None => Err(RtcError::precondition(
                "the component cannot be woken: it has ended",
            )),
        }
    }
}

/// The waker that belongs to an instance. Its drop ends all clones.
#[derive(Debug)]
pub(crate) struct Wakers(Waker);

impl Wakers {
    /// Of an instance with this host.
    ///
    /// # Safety
    /// What the host belongs to lives longer than the result.
    pub unsafe fn new(host: &Host) -> Self {
        Self(Waker(Arc::new(Mutex::new(Some(Link::of(host))))))
    }

    /// One more of them.
    pub fn waker(&self) -> Waker {
        self.0.clone()
    }
}

impl Drop for Wakers {
    fn drop(&mut self) {
        let link = &self.0.0;
        *link.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Asks a host for a cycle, during a call of its instance.
pub(crate) fn wake(host: &Host) -> RtcResult {
    // SAFETY: the instance is being called.
    unsafe { Link::of(host).wake() }
}
