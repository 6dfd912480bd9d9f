//! What a manager offers to an instance, as C functions. A panic in them ends here, not in the component.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::mem::size_of;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::NonNull;
use std::sync::{Arc, Mutex};

use rts_manager_api::data::MAX_SAMPLE;
use rts_runtime::abi::{self, ABI_VERSION, Buffer, ENCODING_CDR_LE, NO_DATA, Text, return_code};

use super::{Component, PortEnd};
use crate::data::Payload;
use crate::log::{Level, MAX_LINE};
use crate::sync::lock;
use crate::text::{self, lend};

/// Longest type name of a sample.
const MAX_TYPE: usize = 256;

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
    failure: Mutex<Option<String>>,
}

impl Host {
    /// A host for an instance of this component.
    pub fn new(component: &Arc<Component>) -> Self {
        let context = allocate(Context {
            component: Arc::clone(component),
            lent: component.ports.iter().map(|_| Mutex::default()).collect(),
            failure: Mutex::default(),
        });
        let abi = allocate(abi::Host {
            abi_version: ABI_VERSION,
            size: size_of::<abi::Host>() as u32,
            context: context.as_ptr().cast(),
            log,
            write,
            read,
            fail,
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
    fn write(&self, port: u32, type_id: &[u8], encoding: u32, bytes: &[u8]) -> i32 {
        let Some(PortEnd::Out(port)) = self.component.ports.get(port as usize) else {
            return return_code::BAD_PARAMETER;
        };
        if encoding != ENCODING_CDR_LE {
            return return_code::UNSUPPORTED;
        }
        if type_id != port.data_type.as_bytes() {
            return return_code::BAD_PARAMETER;
        }
        port.write(&Payload::copy_from_slice(bytes));
        return_code::OK
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

unsafe extern "C" fn write(context: *mut c_void, port: u32, sample: *const Buffer) -> i32 {
    // SAFETY: the ABI promises a valid context, and a sample that is null or valid during the call.
    unsafe {
        guarded(context, return_code::ERROR, |context| {
            let Some(sample) = sample.as_ref() else {
                return return_code::BAD_PARAMETER;
            };
            let bytes = Text {
                data: sample.data,
                len: sample.len,
            };
            let (Some(type_id), Some(bytes)) = (
                text::bytes(sample.type_id, MAX_TYPE),
                text::bytes(bytes, MAX_SAMPLE),
            ) else {
                return return_code::BAD_PARAMETER;
            };
            context.write(port, type_id, sample.encoding, bytes)
        })
    }
}

unsafe extern "C" fn read(context: *mut c_void, port: u32, sample: *mut Buffer) -> i32 {
    // SAFETY: the ABI promises a valid context, and a place for a sample that is null or may be written.
    unsafe {
        guarded(context, return_code::ERROR, |context| {
            let index = port as usize;
            let (Some(PortEnd::In(port)), false) =
                (context.component.ports.get(index), sample.is_null())
            else {
                return return_code::BAD_PARAMETER;
            };
            let Some(payload) = port.read().sample() else {
                return NO_DATA;
            };
            let mut lent = lock(&context.lent[index]);
            *lent = payload;
            sample.write(Buffer {
                type_id: lend(&port.data_type),
                encoding: ENCODING_CDR_LE,
                data: lent.as_ptr(),
                len: lent.len(),
            });
            return_code::OK
        })
    }
}
