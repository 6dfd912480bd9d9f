//! The SDK writes and reads samples of a fixed size without memory from the heap, once the buffer has grown: their bytes,
//! and the way through the ports.

#![allow(unsafe_code)] // An allocator that counts is unsafe to write.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use std::ffi::c_void;
use std::ptr;

use rts_runtime::abi::{self, Buffer, Host, Loan, Text, callback, port_status, return_code};
use rts_runtime::export::ModuleCell;
use rts_runtime::types::{DataType, Pose3D, Time, TimedDouble, TimedLong, TimedPose3D};
use rts_runtime::{Component, Context, Declaration, InPort, OutPort, RtcResult, TypeInfo};

struct Counting;

thread_local! {
    /// Of this thread alone: other tests run at the same time.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator as it is; only their number is noted.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations<T: DataType + PartialEq>(sample: &T) -> usize {
    let mut buffer = Vec::new();
    sample.encode(&mut buffer).expect("encodable");
    let before = COUNT.get();
    for _ in 0..10 {
        sample.encode(&mut buffer).expect("encodable");
        assert!(T::decode(&buffer).expect("what was encoded") == *sample);
    }
    COUNT.get() - before
}

#[test]
fn samples_of_a_fixed_size_take_no_memory() {
    let tm = Time { sec: 1, nsec: 2 };
    assert_eq!(allocations(&TimedLong { tm, data: 1 }), 0);
    assert_eq!(allocations(&TimedDouble { tm, data: 0.5 }), 0);
    let data = Default::default();
    assert_eq!(allocations(&TimedPose3D { tm, data }), 0);
}

/// Passes on what comes.
struct Echo {
    input: InPort<TimedPose3D>,
    output: OutPort<TimedPose3D>,
}

impl Component for Echo {
    const TYPE: TypeInfo = TypeInfo {
        name: "Echo",
        vendor: "",
        category: "",
        version: "",
        description: "",
        rate: 1.0,
    };

    fn declare(d: &mut Declaration) -> Self {
        Self {
            input: d.in_port("in"),
            output: d.out_port("out"),
        }
    }

    fn on_execute(&mut self, ctx: &mut Context<'_>) -> RtcResult {
        while let Some(sample) = self.input.read(ctx)? {
            self.output.write(ctx, &sample)?;
        }
        Ok(())
    }
}

thread_local! {
    /// Samples that can be read.
    static WAITING: Cell<usize> = const { Cell::new(0) };
    static WRITTEN: Cell<usize> = const { Cell::new(0) };
}

const POSE: [u8; 56] = [0; 56];

unsafe extern "C" fn read(_: *mut c_void, _: u32, sample: *mut Buffer) -> i32 {
    let Some(left) = WAITING.get().checked_sub(1) else {
        return port_status::PORT_BUFFER_EMPTY;
    };
    WAITING.set(left);
    // SAFETY: the SDK gives a place to write to.
    unsafe {
        (*sample).type_id = Text {
            data: TimedPose3D::TYPE_ID.as_ptr(),
            len: TimedPose3D::TYPE_ID.len(),
        };
        (*sample).encoding = abi::ENCODING_CDR_LE;
        (*sample).data = POSE.as_ptr();
        (*sample).len = POSE.len();
    }
    port_status::PORT_OK
}
unsafe extern "C" fn write(_: *mut c_void, _: u32, _: *const Buffer) -> i32 {
    WRITTEN.set(WRITTEN.get() + 1);
    port_status::PORT_OK
}
unsafe extern "C" fn log(_: *mut c_void, _: u32, _: Text) {}
unsafe extern "C" fn fail(_: *mut c_void, _: Text) {}
unsafe extern "C" fn now(_: *mut c_void, _: u32) -> i64 {
    0
}
unsafe extern "C" fn rate(_: *mut c_void) -> f64 {
    1.0
}
unsafe extern "C" fn wake(_: *mut c_void) -> i32 {
    0
}
unsafe extern "C" fn is_new(_: *mut c_void, _: u32) -> i32 {
    0
}
unsafe extern "C" fn loan(_: *mut c_void, _: u32, _: usize, _: *mut Loan) -> i32 {
    port_status::PORT_ERROR
}
unsafe extern "C" fn publish(_: *mut c_void, _: u64, _: usize) -> i32 {
    port_status::PORT_ERROR
}
unsafe extern "C" fn discard(_: *mut c_void, _: u64) {}

#[test]
fn ports_take_no_memory() {
    static MODULE: ModuleCell = ModuleCell::new();
    let module = MODULE.get::<Echo>();
    let host = Host {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Host>() as u32,
        context: ptr::null_mut(),
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
    };
    assert_eq!(
        TimedPose3D::decode(&POSE).expect("zeros").data,
        Pose3D::default()
    );
    let mut instance = ptr::null_mut();
    // SAFETY: the host outlives the instance, which is used by this thread alone and not after its end.
    let taken = unsafe {
        assert_eq!(
            (module.create)(&raw const host, &raw mut instance),
            return_code::OK
        );
        let execute = |samples| {
            WAITING.set(samples);
            assert_eq!(
                (module.callback)(instance, callback::ON_EXECUTE),
                return_code::OK
            );
        };
        execute(1);
        let before = COUNT.get();
        execute(10);
        let taken = COUNT.get() - before;
        (module.destroy)(instance);
        taken
    };
    assert_eq!(WRITTEN.get(), 11);
    assert_eq!(taken, 0);
}
