//! What a manager offers to an instance, as C functions. A panic in them ends here, not in the component.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::NonNull;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use rts_runtime::abi::port_status::{
    PORT_BUFFER_EMPTY, PORT_BUFFER_FULL, PORT_BUFFER_TIMEOUT, PORT_ERROR, PORT_INVALID_ARGS,
    PORT_OK,
};
use rts_runtime::abi::{self, ABI_VERSION, Buffer, ENCODING_CDR_LE, Loan, Text, return_code};
use rts_runtime::sized;

use super::loans::Loans;
use super::{Component, PortEnd};
use crate::data::Payload;
use crate::data::in_port::InPort;
use crate::data::out_port::OutPort;
use crate::data::sample::{Read, Written};
use crate::log::{Level, MAX_LINE};
use crate::sync::lock;
use crate::text::{self, lend};
use rts_transport::MAX_SAMPLE;

/// Longest type name of a sample.
const MAX_TYPE: usize = 256;
/// When the monotonic clock was first asked for.
static START: OnceLock<Instant> = OnceLock::new();

/// The host of one instance: two allocations that only this owns and that the module points to, so they are kept as raw
/// pointers. A box that is moved would claim to be the only way to its contents.
pub struct Host {
    abi: NonNull<abi::Host>,
    context: NonNull<Context>,
}

/// Behind [`abi::Host::context`]. All of it may be used by any thread, whatever the module does.
struct Context {
    component: Arc<Component>,
    /// The sample last read of each port, which the component borrows.
    lent: Vec<Mutex<Payload>>,
    /// Memory that the component writes samples into.
    loans: Mutex<Loans>,
    failure: Mutex<Option<String>>,
}

impl Host {
    /// A host for an instance of this component.
    pub fn new(component: &Arc<Component>) -> Self {
        let context = allocate(Context {
            component: Arc::clone(component),
            lent: component.ports.iter().map(|_| Mutex::default()).collect(),
            loans: Mutex::default(),
            failure: Mutex::default(),
        });
        let abi = allocate(abi::Host {
            abi_version: ABI_VERSION,
            size: size_of::<abi::Host>() as u32,
            context: context.as_ptr().cast(),
            log,
            fail,
            now,
            rate,
            wake,
            write,
            read,
            is_new,
            loan,
            publish,
            discard,
        });
        Self { abi, context }
    }

    /// For the module.
    pub fn as_abi(&self) -> *const abi::Host {
        self.abi.as_ptr()
    }

    /// What the component said of the call that just returned.
    pub fn take_failure(&self) -> Option<String> {
        // SAFETY: it lives until the drop of `self`, and is only ever shared.
        let context = unsafe { self.context.as_ref() };
        lock(&context.failure).take()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: both came from a box in `new`, and the instance that pointed to them has been destroyed.
        unsafe {
            drop(Box::from_raw(self.abi.as_ptr()));
            drop(Box::from_raw(self.context.as_ptr()));
        }
    }
}

fn allocate<T>(value: T) -> NonNull<T> {
    NonNull::from(Box::leak(Box::new(value)))
}

impl Context {
    fn in_port(&self, index: u32) -> Option<(usize, &InPort)> {
        match self.component.ports.get(index as usize)? {
            PortEnd::In(port) => Some((index as usize, port)),
            PortEnd::Out(_) => None,
        }
    }

    fn out_port(&self, index: u32) -> Option<&OutPort> {
        match self.component.ports.get(index as usize)? {
            PortEnd::Out(port) => Some(port),
            PortEnd::In(_) => None,
        }
    }

    fn write(&self, port: u32, type_id: &[u8], encoding: u32, bytes: &[u8]) -> i32 {
        match self.out_port(port) {
            Some(port) if encoding == ENCODING_CDR_LE && type_id == port.data_type.as_bytes() => {
                status(port.write(&Payload::copy_from_slice(bytes)))
            }
            _ => PORT_INVALID_ARGS,
        }
    }

    fn loan(&self, port: u32, len: usize) -> Result<(u64, *mut u8), i32> {
        if self.out_port(port).is_none() || len > MAX_SAMPLE {
            return Err(PORT_INVALID_ARGS);
        }
        lock(&self.loans).lend(port, len).ok_or(PORT_BUFFER_FULL)
    }

    fn publish(&self, token: u64, len: usize) -> i32 {
        let given_back = lock(&self.loans).take(token, len);
        match given_back.and_then(|(port, sample)| Some((self.out_port(port)?, sample))) {
            Some((port, sample)) => status(port.write(&sample)),
            None => PORT_INVALID_ARGS,
        }
    }
}

fn status(written: Written) -> i32 {
    match written {
        Written::Taken => PORT_OK,
        Written::BufferFull => PORT_BUFFER_FULL,
        Written::TimedOut => PORT_BUFFER_TIMEOUT,
    }
}

/// Runs a host function for a context; `otherwise` for a null context or a panic.
unsafe fn guarded<T>(context: *mut c_void, otherwise: T, f: impl FnOnce(&Context) -> T) -> T {
    // SAFETY: a module passes back the context of its host, which lives as long as its instance.
    let Some(context) = (unsafe { context.cast::<Context>().as_ref() }) else {
        return otherwise;
    };
    catch_unwind(AssertUnwindSafe(|| f(context))).unwrap_or(otherwise)
}

unsafe extern "C" fn log(context: *mut c_void, level: u32, message: Text) {
    // SAFETY: the ABI promises a valid context, and a text that is valid during the call.
    unsafe {
        guarded(context, (), |context| {
            let message = text::read_lossy(message, MAX_LINE);
            context
                .component
                .log
                .write(Level::from_abi(level), &message);
        });
    }
}

unsafe extern "C" fn fail(context: *mut c_void, reason: Text) {
    // SAFETY: as for `log`.
    unsafe {
        guarded(context, (), |context| {
            *lock(&context.failure) = Some(text::read_lossy(reason, MAX_LINE));
        });
    }
}

unsafe extern "C" fn now(_context: *mut c_void, clock: u32) -> i64 {
    match clock {
        abi::CLOCK_REALTIME => SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| {
                i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
            }),
        abi::CLOCK_MONOTONIC => {
            let since = START.get_or_init(Instant::now).elapsed();
            i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
        }
        _ => 0,
    }
}

unsafe extern "C" fn rate(context: *mut c_void) -> f64 {
    // SAFETY: as for `log`.
    unsafe { guarded(context, 0.0, |context| context.component.context.rate()) }
}

unsafe extern "C" fn wake(context: *mut c_void) -> i32 {
    // SAFETY: as for `log`.
    unsafe {
        guarded(context, return_code::ERROR, |context| {
            match context.component.wake() {
                true => return_code::OK,
                false => return_code::PRECONDITION_NOT_MET,
            }
        })
    }
}

unsafe extern "C" fn write(context: *mut c_void, port: u32, sample: *const Buffer) -> i32 {
    // SAFETY: the ABI promises a valid context, and a sample that is null or valid during the call.
    unsafe {
        guarded(context, PORT_ERROR, |context| {
            let Ok(sample) = sized::read(sample) else {
                return PORT_INVALID_ARGS;
            };
            let bytes = Text {
                data: sample.data,
                len: sample.len,
            };
            let (Some(type_id), Some(bytes)) = (
                text::bytes(sample.type_id, MAX_TYPE),
                text::bytes(bytes, MAX_SAMPLE),
            ) else {
                return PORT_INVALID_ARGS;
            };
            context.write(port, type_id, sample.encoding, bytes)
        })
    }
}

unsafe extern "C" fn read(context: *mut c_void, port: u32, sample: *mut Buffer) -> i32 {
    // SAFETY: the ABI promises a valid context, and a place for a sample that is null or may be written.
    unsafe {
        guarded(context, PORT_ERROR, |context| {
            let Some((index, port)) = context
                .in_port(port)
                .filter(|_| sized::size(sample).is_ok())
            else {
                return PORT_INVALID_ARGS;
            };
            let payload = match port.read() {
                Read::Sample(payload) => payload,
                Read::Empty => return PORT_BUFFER_EMPTY,
                Read::TimedOut => return PORT_BUFFER_TIMEOUT,
            };
            let mut lent = lock(&context.lent[index]);
            *lent = payload;
            let filled = Buffer {
                abi_version: ABI_VERSION,
                size: size_of::<Buffer>() as u32,
                type_id: lend(&port.data_type),
                encoding: ENCODING_CDR_LE,
                reserved: 0,
                data: lent.as_ptr(),
                len: lent.len(),
            };
            sized::fill(sample, &filled).map_or(PORT_INVALID_ARGS, |()| PORT_OK)
        })
    }
}

unsafe extern "C" fn is_new(context: *mut c_void, port: u32) -> i32 {
    // SAFETY: as for `log`.
    unsafe {
        guarded(context, 0, |context| {
            let port = context.in_port(port);
            port.is_some_and(|(_, port)| port.is_new()).into()
        })
    }
}

unsafe extern "C" fn loan(context: *mut c_void, port: u32, len: usize, loan: *mut Loan) -> i32 {
    // SAFETY: the ABI promises a valid context, and a place for a loan that is null or may be written.
    unsafe {
        guarded(context, PORT_ERROR, |context| {
            if sized::size(loan).is_err() {
                return PORT_INVALID_ARGS;
            }
            match context.loan(port, len) {
                Ok((token, data)) => {
                    let filled = Loan {
                        abi_version: ABI_VERSION,
                        size: size_of::<Loan>() as u32,
                        token,
                        data,
                        len,
                    };
                    sized::fill(loan, &filled).map_or(PORT_INVALID_ARGS, |()| PORT_OK)
                }
                Err(status) => status,
            }
        })
    }
}

unsafe extern "C" fn publish(context: *mut c_void, token: u64, len: usize) -> i32 {
    // SAFETY: as for `log`.
    unsafe { guarded(context, PORT_ERROR, |context| context.publish(token, len)) }
}

unsafe extern "C" fn discard(context: *mut c_void, token: u64) {
    // SAFETY: as for `log`.
    unsafe {
        guarded(context, (), |context| {
            drop(lock(&context.loans).take(token, 0));
        });
    }
}
