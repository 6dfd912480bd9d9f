//! What a callback can ask of its manager: logging and ports.

#![allow(unsafe_code)]

use std::fmt::Display;

use crate::abi::{self, Buffer, Host};
use crate::types::DataError;
use crate::{ReturnCode, RtcError, RtcResult, text};

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
}

impl<'h> Context<'h> {
    pub(crate) fn new(host: &'h Host) -> Self {
        Self { host }
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

    /// Hands a sample to an out-port.
    pub(crate) fn write(&mut self, port: u32, type_id: &str, bytes: &[u8]) -> RtcResult {
        let sample = Buffer {
            type_id: text::lend(type_id),
            encoding: abi::ENCODING_CDR_LE,
            data: bytes.as_ptr(),
            len: bytes.len(),
        };
        // SAFETY: the host copies the sample before it returns.
        let code = unsafe { (self.host.write)(self.host.context, port, &raw const sample) };
        match code {
            abi::return_code::OK => Ok(()),
            code => Err(refused("write", code)),
        }
    }

    /// Takes the oldest sample of an in-port and lets `decode` see its bytes.
    pub(crate) fn read<T>(
        &mut self,
        port: u32,
        type_id: &str,
        decode: impl FnOnce(&[u8]) -> Result<T, DataError>,
    ) -> RtcResult<Option<T>> {
        let mut sample = Buffer {
            type_id: text::lend(""),
            encoding: 0,
            data: std::ptr::null(),
            len: 0,
        };
        // SAFETY: `sample` is valid for writing.
        let code = unsafe { (self.host.read)(self.host.context, port, &raw mut sample) };
        match code {
            abi::return_code::OK => {}
            abi::NO_DATA => return Ok(None),
            code => return Err(refused("read", code)),
        }
        // SAFETY: on OK the host lends the sample until the next read of this port, which cannot happen before
        // `decode` returns, as it has no access to this context.
        let (found, bytes) = unsafe { (text::read(sample.type_id), bytes(&sample)) };
        if found != type_id || sample.encoding != abi::ENCODING_CDR_LE {
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

/// # Safety
/// `sample` must be as [`Buffer`] says for the time that the result is used.
unsafe fn bytes(sample: &Buffer) -> &[u8] {
    if sample.len == 0 || sample.data.is_null() {
        return &[];
    }
    // SAFETY: not null and not empty, and the caller vouches for the rest.
    unsafe { std::slice::from_raw_parts(sample.data, sample.len) }
}

fn refused(what: &str, code: i32) -> RtcError {
    let code = ReturnCode::from_number(code);
    RtcError::new(code, format_args!("the manager refused to {what}: {code}"))
}
