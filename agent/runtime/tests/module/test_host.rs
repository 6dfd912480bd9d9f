//! What `TestHost` refuses and forgets is what a manager refuses and forgets.

use std::cell::Cell;
use std::ffi::c_void;
use std::ptr;

use rts_runtime::abi::{self, Buffer, Host, Loan, Module, Port, Text, port_status, return_code};
use rts_runtime::testing::TestHost;
use rts_runtime::types::{DataType, TimedDouble, TimedLong};

const IN: u32 = 0;
const OUT: u32 = 1;

thread_local! {
    static HOST: Cell<*const Host> = const { Cell::new(ptr::null()) };
}

unsafe extern "C" fn create(host: *const Host, instance: *mut *mut c_void) -> i32 {
    HOST.set(host);
    // SAFETY: the host gives a place to write to.
    unsafe { *instance = ptr::dangling_mut() };
    return_code::OK
}
unsafe extern "C" fn destroy(_: *mut c_void) {}
unsafe extern "C" fn callback(_: *mut c_void, _: u32) -> i32 {
    return_code::NOT_IMPLEMENTED
}
unsafe extern "C" fn configure(_: *mut c_void, _: Text, _: Text) -> i32 {
    return_code::BAD_PARAMETER
}

fn lend(text: &'static str) -> Text {
    Text {
        data: text.as_ptr(),
        len: text.len(),
    }
}

/// A component that does nothing, and the host that it got.
fn made(execution_kind: u32) -> (TestHost, &'static Host) {
    let port = |name, direction| Port {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Port>() as u32,
        name: lend(name),
        type_id: lend(TimedLong::TYPE_ID),
        direction,
        reserved: 0,
    };
    let ports = Box::leak(Box::new([
        port("in", abi::PORT_IN),
        port("out", abi::PORT_OUT),
    ]));
    let module = Box::leak(Box::new(Module {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Module>() as u32,
        type_name: lend("Idle"),
        vendor: lend(""),
        category: lend(""),
        version: lend(""),
        description: lend(""),
        idl: lend(""),
        default_rate: 1.0,
        execution_kind,
        activity_type: abi::ACTIVITY_PERIODIC,
        max_instances: 0,
        actions: abi::ALL_ACTIONS,
        ports: ports.as_ptr(),
        ports_len: ports.len(),
        parameters: ptr::null(),
        parameters_len: 0,
        services: ptr::null(),
        services_len: 0,
        create,
        destroy,
        callback,
        configure,
    }));
    let made = TestHost::create(module).expect("it does nothing wrong");
    // SAFETY: it lives as long as the TestHost, which every test keeps.
    (made, unsafe { &*HOST.get() })
}

fn buffer(type_id: &'static str, bytes: &'static [u8]) -> Buffer {
    Buffer {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Buffer>() as u32,
        type_id: lend(type_id),
        encoding: abi::ENCODING_CDR_LE,
        reserved: 0,
        data: bytes.as_ptr(),
        len: bytes.len(),
    }
}

fn write(host: &Host, port: u32, sample: Buffer) -> i32 {
    // SAFETY: its own context, and a sample that lives during the call.
    unsafe { (host.write)(host.context, port, &raw const sample) }
}

fn read(host: &Host, port: u32) -> (i32, Vec<u8>) {
    let mut sample = buffer("", &[]);
    // SAFETY: its own context and a place to write to; what is lent is copied at once.
    unsafe {
        let status = (host.read)(host.context, port, &raw mut sample);
        let bytes = std::slice::from_raw_parts(sample.data, sample.len);
        (status, bytes.to_vec())
    }
}

fn loan(host: &Host, port: u32, len: usize) -> (i32, u64) {
    let mut loan = Loan {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Loan>() as u32,
        token: 0,
        data: ptr::null_mut(),
        len: 0,
    };
    // SAFETY: its own context and a place to write to.
    let status = unsafe { (host.loan)(host.context, port, len, &raw mut loan) };
    (status, loan.token)
}

#[test]
fn only_who_is_event_driven_is_woken() {
    for (kind, status, woken) in [
        (
            abi::EXECUTION_PERIODIC,
            return_code::PRECONDITION_NOT_MET,
            0,
        ),
        (
            abi::EXECUTION_EXTERNAL,
            return_code::PRECONDITION_NOT_MET,
            0,
        ),
        (abi::EXECUTION_EVENT_DRIVEN, return_code::OK, 1),
    ] {
        let (mut it, host) = made(kind);
        // SAFETY: its own context.
        assert_eq!(unsafe { (host.wake)(host.context) }, status, "{kind}");
        assert_eq!(it.take_woken(), woken, "{kind}");
    }
}

#[test]
fn samples_go_out_of_out_ports_and_are_of_their_type() {
    const BYTES: [u8; 12] = [0; 12];
    let (mut it, host) = made(abi::EXECUTION_PERIODIC);
    let good = buffer(TimedLong::TYPE_ID, &BYTES);
    let refused = [
        (IN, good),
        (9, good),
        (OUT, buffer(TimedDouble::TYPE_ID, &BYTES)),
        (
            OUT,
            Buffer {
                encoding: 2,
                ..good
            },
        ),
        (OUT, Buffer { size: 40, ..good }),
        (
            OUT,
            Buffer {
                abi_version: 2,
                ..good
            },
        ),
        (
            OUT,
            Buffer {
                len: (64 << 20) + 1,
                ..good
            },
        ),
    ];
    for (port, sample) in refused {
        let status = write(host, port, sample);
        assert_eq!(status, port_status::PORT_INVALID_ARGS, "{port} {sample:?}");
    }
    // SAFETY: a null pointer is what is refused.
    let status = unsafe { (host.write)(host.context, OUT, ptr::null()) };
    assert_eq!(status, port_status::PORT_INVALID_ARGS);
    assert_eq!(write(host, OUT, good), port_status::PORT_OK);
    // What went out is not what comes in.
    assert_eq!(read(host, OUT).0, port_status::PORT_INVALID_ARGS);
    assert_eq!(read(host, IN).0, port_status::PORT_BUFFER_EMPTY);
    assert_eq!(it.take::<TimedLong>("out").len(), 1);
}

#[test]
fn loans_are_for_out_ports_and_bounded() {
    let (mut it, host) = made(abi::EXECUTION_PERIODIC);
    assert_eq!(loan(host, IN, 12).0, port_status::PORT_INVALID_ARGS);
    let too_long = loan(host, OUT, (64 << 20) + 1);
    assert_eq!(too_long.0, port_status::PORT_INVALID_ARGS);
    let tokens: Vec<_> = (0..64).map(|_| loan(host, OUT, 12)).collect();
    assert!(
        tokens
            .iter()
            .all(|(status, _)| *status == port_status::PORT_OK)
    );
    assert_eq!(loan(host, OUT, 12).0, port_status::PORT_BUFFER_FULL);
    // SAFETY: its own context.
    let publish = |token, len| unsafe { (host.publish)(host.context, token, len) };
    assert_eq!(publish(tokens[0].1, 13), port_status::PORT_INVALID_ARGS);
    assert_eq!(publish(tokens[1].1, 12), port_status::PORT_OK);
    assert_eq!(publish(tokens[1].1, 12), port_status::PORT_INVALID_ARGS);
    assert_eq!(it.take::<TimedLong>("out").len(), 1);
    assert_eq!(loan(host, OUT, 12).0, port_status::PORT_OK);
}

#[test]
fn a_queue_holds_64_and_forgets_what_came_before_the_activation() {
    let (mut it, host) = made(abi::EXECUTION_PERIODIC);
    it.send("in", &TimedLong::now(1));
    it.activate().expect("it has no callbacks");
    assert_eq!(read(host, IN).0, port_status::PORT_BUFFER_EMPTY);
    for number in 0..65 {
        it.send("in", &TimedLong::now(number));
    }
    let (status, first) = read(host, IN);
    let first = TimedLong::decode(&first).expect("what was sent");
    assert_eq!((status, first.data), (port_status::PORT_OK, 1));
}
