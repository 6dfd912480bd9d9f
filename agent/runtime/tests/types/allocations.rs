//! Samples of a fixed size are written and read without memory from the heap, once the buffer has grown.

#![allow(unsafe_code)] // An allocator that counts is unsafe to write.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use rts_runtime::types::{DataType, Time, TimedDouble, TimedLong, TimedPose3D};

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
