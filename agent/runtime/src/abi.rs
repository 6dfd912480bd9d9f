//! The C ABI, version 0, between a manager process and a module (a shared library with one component type).
//!
//! A module exports one function, [`ENTRY`], that returns its [`Module`]. All structs begin with their version and
//! size. Text is UTF-8 with pointer and length, never zero-terminated. Nothing unwinds across the boundary: each side
//! catches its own panics. Calls on one instance never overlap and come from one thread. Functions of its [`Host`] may be
//! called by that thread alone, and only while it is in a call of the manager: not by threads of the module, nor between
//! two calls.

#![allow(unsafe_code)]

use std::ffi::c_void;

/// Version of this ABI.
pub const ABI_VERSION: u32 = 0;
/// Name of the exported function, of type [`Entry`].
pub const ENTRY: &str = "rts_module_v0";
/// Encoding of samples: CDR (XCDR1), little endian, without an encapsulation header.
pub const ENCODING_CDR_LE: u32 = 1;

/// Type of the exported function. The module lives as long as the process.
pub type Entry = unsafe extern "C" fn() -> *const Module;

/// Borrowed UTF-8 text.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Text {
    /// First byte; may be dangling when `len` is 0.
    pub data: *const u8,
    /// Length in bytes.
    pub len: usize,
}

/// A borrowed sample.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Buffer {
    /// IDL repository id of the type (`IDL:RTC/TimedLong:1.0`).
    pub type_id: Text,
    /// [`ENCODING_CDR_LE`].
    pub encoding: u32,
    /// First byte.
    pub data: *const u8,
    /// Length in bytes.
    pub len: usize,
}

/// Direction of a data port.
pub const PORT_IN: u32 = 0;
/// Direction of a data port.
pub const PORT_OUT: u32 = 1;

/// A data port of a type. Ports are named by their index in [`Module::ports`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Port {
    /// Bare name.
    pub name: Text,
    /// IDL repository id.
    pub type_id: Text,
    /// [`PORT_IN`] or [`PORT_OUT`].
    pub direction: u32,
}

/// A configuration parameter of a type.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name.
    pub name: Text,
    /// Default value as text.
    pub default: Text,
}

/// What a module is.
#[repr(C)]
#[derive(Debug)]
pub struct Module {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// `size_of::<Module>()` of the module's compiler.
    pub size: u32,
    /// Type name.
    pub type_name: Text,
    /// Vendor.
    pub vendor: Text,
    /// Category.
    pub category: Text,
    /// Version.
    pub version: Text,
    /// One line.
    pub description: Text,
    /// Rate in Hz when nothing else is said.
    pub default_rate: f64,
    /// Ports.
    pub ports: *const Port,
    /// Number of ports.
    pub ports_len: usize,
    /// Parameters.
    pub parameters: *const Parameter,
    /// Number of parameters.
    pub parameters_len: usize,
    /// Makes an instance. `host` lives as long as the instance. Returns [`return_code`]; `instance` is set on OK only,
    /// and is then not null.
    pub create: unsafe extern "C" fn(host: *const Host, instance: *mut *mut c_void) -> i32,
    /// Frees an instance.
    pub destroy: unsafe extern "C" fn(instance: *mut c_void),
    /// Calls one of [`callback`]. Returns [`return_code`].
    pub callback: unsafe extern "C" fn(instance: *mut c_void, callback: u32) -> i32,
    /// Sets a parameter of the active set. Returns [`return_code`]: `BAD_PARAMETER` when the value cannot be read.
    pub configure: unsafe extern "C" fn(instance: *mut c_void, name: Text, value: Text) -> i32,
}

/// What a manager offers to one instance. `context` comes first in every call. To be called by the thread that the
/// manager calls the instance from, during such a call.
#[repr(C)]
#[derive(Debug)]
pub struct Host {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// `size_of::<Host>()` of the manager's compiler.
    pub size: u32,
    /// Belongs to the manager.
    pub context: *mut c_void,
    /// Writes a line to the component's log. Levels: 0 trace, 1 debug, 2 info, 3 warn, 4 error.
    pub log: unsafe extern "C" fn(context: *mut c_void, level: u32, message: Text),
    /// Writes a sample to an out-port; copied before it returns. Never blocks.
    pub write: unsafe extern "C" fn(context: *mut c_void, port: u32, sample: *const Buffer) -> i32,
    /// Takes the oldest sample of an in-port among those that had arrived when the running callback began, so a loop
    /// that reads all ends. On OK `sample` is borrowed until the next read of the same port; on
    /// [`NO_DATA`] it is untouched.
    pub read: unsafe extern "C" fn(context: *mut c_void, port: u32, sample: *mut Buffer) -> i32,
    /// Says why the next return code is not OK.
    pub fail: unsafe extern "C" fn(context: *mut c_void, reason: Text),
}

/// `ReturnCode_t` of OMG RTC 1.0 (5.2.2.1).
pub mod return_code {
    /// RTC_OK.
    pub const OK: i32 = 0;
    /// RTC_ERROR.
    pub const ERROR: i32 = 1;
    /// BAD_PARAMETER.
    pub const BAD_PARAMETER: i32 = 2;
    /// UNSUPPORTED.
    pub const UNSUPPORTED: i32 = 3;
    /// OUT_OF_RESOURCES.
    pub const OUT_OF_RESOURCES: i32 = 4;
    /// PRECONDITION_NOT_MET.
    pub const PRECONDITION_NOT_MET: i32 = 5;
}

/// Answer of [`Host::read`] when the port has no sample. Not an error.
pub const NO_DATA: i32 = 100;

/// Callbacks, by number (ComponentAction and DataFlowComponentAction of OMG RTC 1.0).
pub mod callback {
    /// `on_initialize`.
    pub const INITIALIZE: u32 = 0;
    /// `on_finalize`.
    pub const FINALIZE: u32 = 1;
    /// `on_startup`: the execution context starts.
    pub const STARTUP: u32 = 2;
    /// `on_shutdown`: the execution context stops.
    pub const SHUTDOWN: u32 = 3;
    /// `on_activated`.
    pub const ACTIVATED: u32 = 4;
    /// `on_deactivated`.
    pub const DEACTIVATED: u32 = 5;
    /// `on_aborting`: it goes to Error.
    pub const ABORTING: u32 = 6;
    /// `on_error`: it is in Error, once a cycle.
    pub const ERROR: u32 = 7;
    /// `on_reset`.
    pub const RESET: u32 = 8;
    /// `on_execute`, once a cycle while Active.
    pub const EXECUTE: u32 = 9;
    /// `on_state_update`, after each `on_execute`.
    pub const STATE_UPDATE: u32 = 10;
    /// `on_rate_changed`.
    pub const RATE_CHANGED: u32 = 11;
}
