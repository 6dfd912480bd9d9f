//! A module for the tests of this crate, written against the bare C ABI so that it can misbehave.
//!
//! Each `on_execute` reads all samples of `in`, which must be rising numbers, and writes `produce` numbers to `out`.
//! Parameters: `fail` names callbacks that return an error with the reason `reason`; `hang` names one that takes
//! `hang_ms` milliseconds. `code` is refused unless it is a number: it is the return code of failures.

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::time::Duration;

use rts_runtime::abi::port_status::{PORT_BUFFER_EMPTY, PORT_CONNECTION_LOST, PORT_OK};
use rts_runtime::abi::{
    ABI_VERSION, ACTIVITY_PERIODIC, ALL_ACTIONS, Buffer, ENCODING_CDR_LE, EXECUTION_PERIODIC, Host,
    Module, PORT_IN, PORT_OUT, Parameter, Port, Text, callback, return_code,
};

const fn text(text: &'static str) -> Text {
    Text {
        data: text.as_ptr(),
        len: text.len(),
    }
}

const fn port(name: &'static str, type_id: &'static str, direction: u32) -> Port {
    Port {
        abi_version: ABI_VERSION,
        size: size_of::<Port>() as u32,
        name: text(name),
        type_id: text(type_id),
        direction,
        reserved: 0,
    }
}

const fn parameter(name: &'static str, default: &'static str) -> Parameter {
    Parameter {
        abi_version: ABI_VERSION,
        size: size_of::<Parameter>() as u32,
        name: text(name),
        default: text(default),
        value_type: text(""),
        unit: text(""),
        constraint: text(""),
        description: text(""),
    }
}

const NUMBER: &str = "IDL:RTC/TimedDouble:1.0";
static PORTS: Shared<[Port; 3]> = Shared([
    port("in", NUMBER, PORT_IN),
    port("out", NUMBER, PORT_OUT),
    port("text", "IDL:RTC/TimedString:1.0", PORT_IN),
]);
static PARAMETERS: Shared<[Parameter; 6]> = Shared([
    parameter("produce", "0"),
    parameter("fail", ""),
    parameter("reason", ""),
    parameter("code", "1"),
    parameter("hang", ""),
    parameter("hang_ms", "0"),
]);

struct Shared<T>(T);
// SAFETY: constants that nobody writes.
unsafe impl<T> Sync for Shared<T> {}

static MODULE: Shared<Module> = Shared(Module {
    abi_version: ABI_VERSION,
    size: size_of::<Module>() as u32,
    type_name: text("Testmod"),
    vendor: text("tests"),
    category: text("test"),
    version: text("1.0"),
    description: text("misbehaves on demand"),
    idl: text(""),
    default_rate: 1000.0,
    execution_kind: EXECUTION_PERIODIC,
    activity_type: ACTIVITY_PERIODIC,
    max_instances: 0,
    actions: ALL_ACTIONS,
    ports: PORTS.0.as_ptr(),
    ports_len: 3,
    parameters: PARAMETERS.0.as_ptr(),
    parameters_len: 6,
    services: std::ptr::null(),
    services_len: 0,
    create,
    destroy,
    callback: call,
    configure,
});

/// Runs within dlopen: sleeps for the milliseconds in `TESTMOD_INIT_MS`, if it is set.
extern "C" fn initialise() {
    let ms = std::env::var("TESTMOD_INIT_MS").ok();
    if let Some(ms) = ms.and_then(|ms| ms.parse().ok()) {
        std::thread::sleep(Duration::from_millis(ms));
    }
}
#[used]
// SAFETY: the section holds pointers to functions of this type.
#[unsafe(link_section = ".init_array")]
static INITIALISE: extern "C" fn() = initialise;

/// The entry function of the ABI.
// SAFETY: no other function of this name is linked.
#[unsafe(no_mangle)]
pub extern "C" fn rts_module_v1() -> *const Module {
    &raw const MODULE.0
}

struct Component {
    host: *const Host,
    produce: u64,
    fail: String,
    reason: String,
    code: i32,
    hang: String,
    hang_ms: u64,
    written: u64,
    last_read: u64,
}

unsafe extern "C" fn create(host: *const Host, instance: *mut *mut c_void) -> i32 {
    if std::env::var_os("TESTMOD_NULL_INSTANCE").is_some() {
        return return_code::OK;
    }
    let component = Component {
        host,
        produce: 0,
        fail: String::new(),
        reason: String::new(),
        code: return_code::ERROR,
        hang: String::new(),
        hang_ms: 0,
        written: 0,
        last_read: 0,
    };
    // SAFETY: the manager passes a place to write to.
    unsafe { instance.write(Box::into_raw(Box::new(component)).cast()) };
    return_code::OK
}

unsafe extern "C" fn destroy(instance: *mut c_void) {
    // SAFETY: made by `create`, and not used again.
    drop(unsafe { Box::from_raw(instance.cast::<Component>()) });
}

unsafe extern "C" fn configure(instance: *mut c_void, name: Text, value: Text) -> i32 {
    // SAFETY: made by `create`; one thread at a time; texts are valid during the call.
    let (component, name, value) = unsafe {
        let bytes = |text: Text| match text.len {
            0 => &[][..],
            len => std::slice::from_raw_parts(text.data, len),
        };
        let string = |text| String::from_utf8_lossy(bytes(text)).into_owned();
        (
            &mut *instance.cast::<Component>(),
            string(name),
            string(value),
        )
    };
    match (name.as_str(), value.parse::<i32>()) {
        ("fail", _) => component.fail = value,
        ("reason", _) => component.reason = value,
        ("hang", _) => component.hang = value,
        ("produce", Ok(number)) => component.produce = number as u64,
        ("code", Ok(number)) => component.code = number,
        ("hang_ms", Ok(number)) => component.hang_ms = number as u64,
        _ => {
            component.say_why("it is not a number");
            return return_code::BAD_PARAMETER;
        }
    }
    return_code::OK
}

unsafe extern "C" fn call(instance: *mut c_void, number: u32) -> i32 {
    // SAFETY: made by `create`; one thread at a time.
    let component = unsafe { &mut *instance.cast::<Component>() };
    let name = match number {
        callback::ON_INITIALIZE => "on_initialize",
        callback::ON_FINALIZE => "on_finalize",
        callback::ON_STARTUP => "on_startup",
        callback::ON_SHUTDOWN => "on_shutdown",
        callback::ON_ERROR => "on_error",
        callback::ON_ACTIVATED => "on_activated",
        callback::ON_DEACTIVATED => "on_deactivated",
        callback::ON_ABORTING => "on_aborting",
        callback::ON_RESET => "on_reset",
        callback::ON_EXECUTE => "on_execute",
        callback::ON_STATE_UPDATE => "on_state_update",
        callback::ON_RATE_CHANGED => "on_rate_changed",
        callback::ON_CONFIGURED => "on_configured",
        _ => return return_code::UNSUPPORTED,
    };
    if !matches!(
        number,
        callback::ON_EXECUTE | callback::ON_STATE_UPDATE | callback::ON_ERROR
    ) {
        component.log(name);
    }
    if component.hang == name {
        std::thread::sleep(Duration::from_millis(component.hang_ms));
    }
    if component.fail.split(',').any(|callback| callback == name) {
        if !component.reason.is_empty() {
            component.say_why(&component.reason);
        }
        return component.code;
    }
    if number == callback::ON_EXECUTE && !component.execute() {
        return return_code::ERROR;
    }
    return_code::OK
}

impl Component {
    fn execute(&mut self) -> bool {
        while let Some(number) = self.read() {
            if number <= self.last_read {
                self.say_why(&format!("read {number} after {}", self.last_read));
                return false;
            }
            self.last_read = number;
        }
        for _ in 0..self.produce {
            self.written += 1;
            self.write(self.written);
        }
        true
    }

    fn read(&self) -> Option<u64> {
        let mut sample = buffer("", &[]);
        // SAFETY: the host outlives the instance; the sample is borrowed until the next read.
        unsafe {
            let host = &*self.host;
            match (host.read)(host.context, 0, &raw mut sample) {
                PORT_BUFFER_EMPTY => None,
                PORT_OK if sample.len == 8 => Some(sample.data.cast::<u64>().read_unaligned()),
                other => panic!("read returned {other} with {} bytes", sample.len),
            }
        }
    }

    fn write(&self, number: u64) {
        let bytes = number.to_ne_bytes();
        let sample = buffer(NUMBER, &bytes);
        // SAFETY: the host outlives the instance; the sample is copied.
        let code = unsafe {
            let host = &*self.host;
            (host.write)(host.context, 1, &raw const sample)
        };
        // Between the loss of a peer and what its policy does about it there may be a cycle.
        assert!(
            matches!(code, PORT_OK | PORT_CONNECTION_LOST),
            "write returned {code}"
        );
    }

    fn log(&self, message: &str) {
        // SAFETY: the host outlives the instance; the text is copied.
        unsafe {
            let host = &*self.host;
            (host.log)(host.context, 2, lend(message));
        }
    }

    fn say_why(&self, reason: &str) {
        // SAFETY: as for `log`.
        unsafe {
            let host = &*self.host;
            (host.fail)(host.context, lend(reason));
        }
    }
}

fn buffer(type_id: &str, bytes: &[u8]) -> Buffer {
    Buffer {
        abi_version: ABI_VERSION,
        size: size_of::<Buffer>() as u32,
        type_id: lend(type_id),
        encoding: ENCODING_CDR_LE,
        reserved: 0,
        data: bytes.as_ptr(),
        len: bytes.len(),
    }
}

fn lend(text: &str) -> Text {
    Text {
        data: text.as_ptr(),
        len: text.len(),
    }
}
