//! What a callback can ask of its manager: logging and ports.

#![allow(unsafe_code)]

use std::fmt::Display;
use std::ptr;

use crate::abi::{self, Buffer, Host};
use crate::loan::Loan;
use crate::port_status::{PortStatus, refused};
use crate::types::DataError;
use crate::waker::{Waker, Wakers, wake};
use crate::{RtcError, RtcResult, text};

/// Level of a line in the component's log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Every step.
    Trace,
    /// For who looks for a fault.
    Debug,
    /// What a user wants to know.
    Info,
    /// Something is odd, and work goes on.
    Warn,
    /// Something failed.
    Error,
}

/// The manager, as a callback sees it.
#[derive(Debug)]
pub struct Context<'h> {
    host: &'h Host,
    wakers: &'h Wakers,
    /// Callbacks that were left to their default.
    defaults: u32,
}

impl<'h> Context<'h> {
    pub(crate) fn new(host: &'h Host, wakers: &'h Wakers) -> Self {
        Self {
            host,
            wakers,
            defaults: 0,
        }
    }

    /// Writes a line to the component's log.
    pub fn log(&self, level: Level, message: impl Display) {
        let message = message.to_string();
        // SAFETY: the host's own context is passed back to it; the text lives until the call returns.
        unsafe { (self.host.log)(self.host.context, level as u32, text::lend(&message)) }
    }

    /// Logs at level trace.
    pub fn trace(&self, message: impl Display) {
        self.log(Level::Trace, message);
    }

    /// Logs at level debug.
    pub fn debug(&self, message: impl Display) {
        self.log(Level::Debug, message);
    }

    /// Logs at level info: `ctx.info(format_args!("cut-off {f} Hz"))`.
    pub fn info(&self, message: impl Display) {
        self.log(Level::Info, message);
    }

    /// Logs at level warn.
    pub fn warn(&self, message: impl Display) {
        self.log(Level::Warn, message);
    }

    /// Logs at level error.
    pub fn error(&self, message: impl Display) {
        self.log(Level::Error, message);
    }

    /// Says why the return code that follows is not OK.
    pub(crate) fn fail(&self, reason: &str) {
        // SAFETY: as in `log`.
        unsafe { (self.host.fail)(self.host.context, text::lend(reason)) }
    }

    /// A callback was left to its default, which does nothing.
    pub(crate) fn not_implemented(&mut self, callback: u32) {
        self.defaults |= 1 << callback;
    }

    /// Whether the callback that ran is its default.
    pub(crate) fn is_default(&self, callback: u32) -> bool {
        callback < u32::BITS && self.defaults & 1 << callback != 0
    }

    /// Nanoseconds since 1970-01-01 UTC, by the manager's clock.
    pub fn now(&self) -> i64 {
        // SAFETY: the host's own context is passed back to it.
        unsafe { (self.host.now)(self.host.context, abi::CLOCK_REALTIME) }
    }

    /// Nanoseconds of a clock that never goes back.
    pub fn monotonic(&self) -> i64 {
        // SAFETY: as in `now`.
        unsafe { (self.host.now)(self.host.context, abi::CLOCK_MONOTONIC) }
    }

    /// Rate in Hz of the execution context that runs this component.
    pub fn rate(&self) -> f64 {
        // SAFETY: as in `now`.
        unsafe { (self.host.rate)(self.host.context) }
    }

    /// Asks an event-driven execution context for another cycle after this callback.
    pub fn wake(&self) -> RtcResult {
        wake(self.host)
    }

    /// The same for threads of the component's own.
    pub fn waker(&self) -> Waker {
        self.wakers.waker()
    }

    /// Whether an in-port has a sample.
    pub(crate) fn is_new(&self, port: u32) -> bool {
        // SAFETY: as in `now`.
        unsafe { (self.host.is_new)(self.host.context, port) != 0 }
    }

    /// Hands a sample to an out-port.
    pub(crate) fn write(
        &mut self,
        port: u32,
        type_id: &str,
        bytes: &[u8],
    ) -> RtcResult<PortStatus> {
        let sample = Buffer {
            data: bytes.as_ptr(),
            len: bytes.len(),
            ..buffer(type_id, abi::ENCODING_CDR_LE)
        };
        // SAFETY: the host copies the sample before it returns.
        let code = unsafe { (self.host.write)(self.host.context, port, &raw const sample) };
        PortStatus::of("write", code)
    }

    /// Borrows memory of the host for a sample of an out-port.
    pub(crate) fn loan(&mut self, port: u32, len: usize) -> RtcResult<Loan<'_>> {
        let mut loan = abi::Loan {
            abi_version: abi::ABI_VERSION,
            size: size_of::<abi::Loan>() as u32,
            token: 0,
            data: ptr::null_mut(),
            len: 0,
        };
        // SAFETY: `loan` is valid for writing.
        let code = unsafe { (self.host.loan)(self.host.context, port, len, &raw mut loan) };
        match code {
            abi::port_status::PORT_OK => Ok(Loan::new(self.host, loan)),
            code => Err(refused("lend memory", code)),
        }
    }

    /// Takes the oldest sample of an in-port and lets `decode` see its bytes.
    pub(crate) fn read<T>(
        &mut self,
        port: u32,
        type_id: &str,
        decode: impl FnOnce(&[u8]) -> Result<T, DataError>,
    ) -> RtcResult<Option<T>> {
        let mut sample = buffer("", 0);
        // SAFETY: `sample` is valid for writing.
        let code = unsafe { (self.host.read)(self.host.context, port, &raw mut sample) };
        match code {
            abi::port_status::PORT_OK => {}
            code => return PortStatus::of("read", code).map(|_| None),
        }
        // SAFETY: on OK the host lends the sample until the next read of this port, which cannot happen before
        // `decode` returns, as it has no access to this context.
        let (found, bytes) = unsafe {
            let bytes = abi::Text {
                data: sample.data,
                len: sample.len,
            };
            (text::bytes(sample.type_id), text::bytes(bytes))
        };
        if found != type_id.as_bytes() || sample.encoding != abi::ENCODING_CDR_LE {
            let found = String::from_utf8_lossy(found);
            return Err(RtcError::bad_parameter(format_args!(
                "the sample is a {found} in encoding {}, expected {type_id} in encoding {}",
                sample.encoding,
                abi::ENCODING_CDR_LE
            )));
        }
        let value = decode(bytes).map_err(|error| {
            let reason = RtcError::from(error);
            RtcError::bad_parameter(reason.context(format_args!("the sample is no {type_id}")))
        })?;
        Ok(Some(value))
    }
}

/// A sample without bytes.
fn buffer(type_id: &str, encoding: u32) -> Buffer {
    Buffer {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Buffer>() as u32,
        type_id: text::lend(type_id),
        encoding,
        reserved: 0,
        data: ptr::null(),
        len: 0,
    }
}
