//! The C ABI, version 1, between a manager process and a module (a shared library with one component type).
//!
//! `include/rtsctl/rts_module.h` is made of this file; `docs/abi.md` explains it. A module exports one function,
//! [`ENTRY`], that returns its [`Module`]. All structs but [`Text`] begin with their version and size. Within a version
//! fields are only ever appended, and those are optional; [`sized`](crate::sized) reads what is shorter or longer. Text is
//! UTF-8 with pointer and length, never zero-terminated. Nothing unwinds across the boundary: each side catches its own
//! panics and exceptions. Calls on one instance never overlap and come from one thread.

#![allow(unsafe_code)]

use std::ffi::c_void;

/// Version of this ABI.
pub const ABI_VERSION: u32 = 1;
/// Name of the exported function, of type [`Entry`]. It ends with the version.
pub const ENTRY: &str = "rts_module_v1";
/// Encoding of samples: CDR (XCDR1), little endian, without an encapsulation header.
pub const ENCODING_CDR_LE: u32 = 1;

/// Type of the exported function. The module lives as long as the process.
pub type Entry = unsafe extern "C" fn() -> *const Module;

/// Borrowed UTF-8 text. The one struct that never grows.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Text {
    /// First byte; may be anything when `len` is 0.
    pub data: *const u8,
    /// Length in bytes.
    pub len: usize,
}

/// A borrowed sample. Whoever passes one sets `abi_version` and `size`, also when it is to be filled.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Buffer {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// Size of this struct for the compiler of its sender.
    pub size: u32,
    /// IDL repository id of the type (`IDL:RTC/TimedLong:1.0`).
    pub type_id: Text,
    /// [`ENCODING_CDR_LE`].
    pub encoding: u32,
    /// Zero.
    pub reserved: u32,
    /// First byte.
    pub data: *const u8,
    /// Length in bytes.
    pub len: usize,
}

/// Memory of the manager that a sample is written into, so that it is not copied. The module sets `abi_version` and
/// `size`, [`Host::loan`] the rest.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Loan {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// Size of this struct for the compiler of the module.
    pub size: u32,
    /// Names the loan when it is given back; never 0.
    pub token: u64,
    /// First byte, at a multiple of 8. All bytes can be read and written, and are zero at first.
    pub data: *mut u8,
    /// Length in bytes.
    pub len: usize,
}

/// Direction of a data port: it reads.
pub const PORT_IN: u32 = 0;
/// Direction of a data port: it writes.
pub const PORT_OUT: u32 = 1;

/// A data port of a type. Ports are named by their index in [`Module::ports`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Port {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// Size of this struct for the compiler of the module: the distance of two in a list.
    pub size: u32,
    /// Bare name.
    pub name: Text,
    /// IDL repository id.
    pub type_id: Text,
    /// [`PORT_IN`] or [`PORT_OUT`].
    pub direction: u32,
    /// Zero.
    pub reserved: u32,
}

/// A service port's interface is offered to others.
pub const SERVICE_PROVIDED: u32 = 0;
/// A service port's interface is used of others.
pub const SERVICE_REQUIRED: u32 = 1;

/// An interface of a service port. Managers of this version show it and connect nothing to it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Service {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// Size of this struct for the compiler of the module: the distance of two in a list.
    pub size: u32,
    /// Name of the port. A port with several interfaces is in the list as often.
    pub port: Text,
    /// Name of the interface in the port.
    pub name: Text,
    /// IDL repository id of the interface (`IDL:Acme/Arm:1.0`).
    pub interface_id: Text,
    /// [`SERVICE_PROVIDED`] or [`SERVICE_REQUIRED`].
    pub polarity: u32,
    /// Zero.
    pub reserved: u32,
}

/// A configuration parameter of a type.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// Size of this struct for the compiler of the module: the distance of two in a list.
    pub size: u32,
    /// Name.
    pub name: Text,
    /// Default value as text. It must be of the type and keep the constraint.
    pub default: Text,
    /// Type as an RTC Profile names it (`double`, `int`, `string`, `std::vector<double>`); empty when any text will do.
    pub value_type: Text,
    /// Unit (`m/s`); may be empty.
    pub unit: Text,
    /// Constraint as an RTC Profile has it (`0<=x<=10`, `(slow,fast)`); empty when there is none.
    pub constraint: Text,
    /// One line; may be empty.
    pub description: Text,
}

/// Execution context: a cycle at a fixed rate.
pub const EXECUTION_PERIODIC: u32 = 0;
/// Execution context: a cycle when a sample arrives or [`Host::wake`] is called.
pub const EXECUTION_EVENT_DRIVEN: u32 = 1;
/// Execution context: a cycle when somebody asks for one.
pub const EXECUTION_EXTERNAL: u32 = 2;

/// Activity type PERIODIC.
pub const ACTIVITY_PERIODIC: u32 = 0;
/// Activity type SPORADIC.
pub const ACTIVITY_SPORADIC: u32 = 1;
/// Activity type EVENT_DRIVEN.
pub const ACTIVITY_EVENT_DRIVEN: u32 = 2;

/// What a module is.
#[repr(C)]
#[derive(Debug)]
pub struct Module {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// Size of this struct for the compiler of the module.
    pub size: u32,
    /// Type name.
    pub type_name: Text,
    /// Vendor.
    pub vendor: Text,
    /// Category.
    pub category: Text,
    /// Version of the component type.
    pub version: Text,
    /// One line.
    pub description: Text,
    /// IDL source of the types that are the module's own; may be empty.
    pub idl: Text,
    /// Rate in Hz when nothing else is said.
    pub default_rate: f64,
    /// Execution context that it wants when nothing else is said: [`EXECUTION_PERIODIC`] and its like.
    pub execution_kind: u32,
    /// [`ACTIVITY_PERIODIC`] and its like: for people and tools.
    pub activity_type: u32,
    /// Most instances in one process; 0 for any number.
    pub max_instances: u32,
    /// Callbacks that it implements, bit `1 << number` each. The others are never called.
    pub actions: u32,
    /// Data ports.
    pub ports: *const Port,
    /// Number of data ports.
    pub ports_len: usize,
    /// Parameters.
    pub parameters: *const Parameter,
    /// Number of parameters.
    pub parameters_len: usize,
    /// Interfaces of service ports.
    pub services: *const Service,
    /// Number of interfaces of service ports.
    pub services_len: usize,
    /// Makes an instance. `host` lives as long as the instance. Returns a return code; `instance` is set on `OK` only,
    /// and is then not null.
    pub create: unsafe extern "C" fn(host: *const Host, instance: *mut *mut c_void) -> i32,
    /// Frees an instance.
    pub destroy: unsafe extern "C" fn(instance: *mut c_void),
    /// Calls a callback by its number. Returns a return code.
    pub callback: unsafe extern "C" fn(instance: *mut c_void, callback: u32) -> i32,
    /// Sets a parameter. Returns a return code: `BAD_PARAMETER` when the value is refused, and the old one stays.
    pub configure: unsafe extern "C" fn(instance: *mut c_void, name: Text, value: Text) -> i32,
}

/// Clock for [`Host::now`]: since 1970-01-01 UTC. It may jump.
pub const CLOCK_REALTIME: u32 = 0;
/// Clock for [`Host::now`]: since a moment that is the same for the whole process. It never goes back.
pub const CLOCK_MONOTONIC: u32 = 1;

/// What a manager offers to one instance. `context` comes first in every call.
///
/// `log`, `now`, `rate` and `wake` may be called by any thread, from `create` until `destroy` is called. All others only
/// by the thread that the manager calls the instance from, during such a call.
#[repr(C)]
#[derive(Debug)]
pub struct Host {
    /// [`ABI_VERSION`].
    pub abi_version: u32,
    /// Size of this struct for the compiler of the manager.
    pub size: u32,
    /// Belongs to the manager.
    pub context: *mut c_void,
    /// Writes a line to the component's log. Levels: 0 trace, 1 debug, 2 info, 3 warn, 4 error.
    pub log: unsafe extern "C" fn(context: *mut c_void, level: u32, message: Text),
    /// Says why the next return code is not OK.
    pub fail: unsafe extern "C" fn(context: *mut c_void, reason: Text),
    /// Nanoseconds of a clock; 0 for a clock that is not known.
    pub now: unsafe extern "C" fn(context: *mut c_void, clock: u32) -> i64,
    /// Rate in Hz of the execution context that runs the instance.
    pub rate: unsafe extern "C" fn(context: *mut c_void) -> f64,
    /// Asks an event-driven execution context for a cycle. Several calls before it begins are one. Returns a return code:
    /// `PRECONDITION_NOT_MET` when the context is not event-driven.
    pub wake: unsafe extern "C" fn(context: *mut c_void) -> i32,
    /// Writes a sample to an out-port; copied before it returns. Returns a port status.
    pub write: unsafe extern "C" fn(context: *mut c_void, port: u32, sample: *const Buffer) -> i32,
    /// Takes the next sample of an in-port among those that had arrived when the running callback began, so a loop
    /// that reads all ends. On `PORT_OK` `sample` is borrowed until the next read of the same port or the end of the
    /// instance; on any other port status, such as `PORT_BUFFER_EMPTY`, it is untouched.
    pub read: unsafe extern "C" fn(context: *mut c_void, port: u32, sample: *mut Buffer) -> i32,
    /// 1 when [`Host::read`] would give a sample, else 0.
    pub is_new: unsafe extern "C" fn(context: *mut c_void, port: u32) -> i32,
    /// Lends memory for a sample of an out-port. Returns a port status; `loan` is filled on `PORT_OK` only. It is given
    /// back by [`Host::publish`] or [`Host::discard`], at the latest when the instance ends.
    pub loan:
        unsafe extern "C" fn(context: *mut c_void, port: u32, len: usize, loan: *mut Loan) -> i32,
    /// Writes the first `len` bytes of a loan, a sample in [`ENCODING_CDR_LE`], to the port that it was lent for, without
    /// a copy. The memory belongs to the manager from then on, whatever the port status that is returned.
    pub publish: unsafe extern "C" fn(context: *mut c_void, token: u64, len: usize) -> i32,
    /// Gives a loan back unused.
    pub discard: unsafe extern "C" fn(context: *mut c_void, token: u64),
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
    /// Of a callback only: OK, and this one does nothing, so the instance need not be called for it again.
    pub const NOT_IMPLEMENTED: i32 = 100;
}

/// Status of what was done with a port: `DataPortStatus` of OpenRTM-aist, with its numbers.
pub mod port_status {
    /// Done.
    pub const PORT_OK: i32 = 0;
    /// Anything else.
    pub const PORT_ERROR: i32 = 1;
    /// The buffer failed.
    pub const PORT_BUFFER_ERROR: i32 = 2;
    /// The buffer of a connector was full, and its policy kept the new sample out.
    pub const PORT_BUFFER_FULL: i32 = 3;
    /// There is no sample. Not an error.
    pub const PORT_BUFFER_EMPTY: i32 = 4;
    /// The time to wait for a buffer is over.
    pub const PORT_BUFFER_TIMEOUT: i32 = 5;
    /// The way out of a connector was full.
    pub const PORT_SEND_FULL: i32 = 6;
    /// The time to wait for the way out is over.
    pub const PORT_SEND_TIMEOUT: i32 = 7;
    /// Nothing came from the other end.
    pub const PORT_RECV_EMPTY: i32 = 8;
    /// The time to wait for the other end is over.
    pub const PORT_RECV_TIMEOUT: i32 = 9;
    /// No such port, another type or encoding, or a struct that cannot be used.
    pub const PORT_INVALID_ARGS: i32 = 10;
    /// Not now.
    pub const PORT_PRECONDITION_NOT_MET: i32 = 11;
    /// The other end of a connector is lost.
    pub const PORT_CONNECTION_LOST: i32 = 12;
    /// Not known.
    pub const PORT_UNKNOWN_ERROR: i32 = 13;
}

/// Callbacks, by number (ComponentAction and DataFlowComponentAction of OMG RTC 1.0).
pub mod callback {
    /// `on_initialize`.
    pub const ON_INITIALIZE: u32 = 0;
    /// `on_finalize`.
    pub const ON_FINALIZE: u32 = 1;
    /// `on_startup`: the execution context starts.
    pub const ON_STARTUP: u32 = 2;
    /// `on_shutdown`: the execution context stops.
    pub const ON_SHUTDOWN: u32 = 3;
    /// `on_activated`.
    pub const ON_ACTIVATED: u32 = 4;
    /// `on_deactivated`.
    pub const ON_DEACTIVATED: u32 = 5;
    /// `on_aborting`: it goes to Error.
    pub const ON_ABORTING: u32 = 6;
    /// `on_error`: it is in Error, once a cycle.
    pub const ON_ERROR: u32 = 7;
    /// `on_reset`.
    pub const ON_RESET: u32 = 8;
    /// `on_execute`, once a cycle while Active.
    pub const ON_EXECUTE: u32 = 9;
    /// `on_state_update`, after each `on_execute`.
    pub const ON_STATE_UPDATE: u32 = 10;
    /// `on_rate_changed`.
    pub const ON_RATE_CHANGED: u32 = 11;
    /// `on_configured`: values were set while it runs, all of one update before the call.
    pub const ON_CONFIGURED: u32 = 12;
    /// How many callbacks there are.
    pub const CALLBACKS: u32 = 13;
}

/// All callbacks, for [`Module::actions`].
pub const ALL_ACTIONS: u32 = (1 << 13) - 1;
