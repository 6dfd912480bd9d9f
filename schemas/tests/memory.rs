//! No file costs more memory than so many times its size and 1 MiB, however it is made.

#![allow(clippy::unwrap_used, unsafe_code)] // A failure here is a failed test; an allocator that counts is unsafe to write.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use rts_schemas::{rtc_conf, rtc_profile, rts_profile};

/// Bytes of memory for a byte of the worst file.
const TIMES: usize = 256;

struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn more(size: usize) {
    let now = NOW.fetch_add(size, Relaxed) + size;
    PEAK.fetch_max(now, Relaxed);
}

// SAFETY: every call goes to the system's allocator as it is; only sizes are noted.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The most that was in use at once while a file was read, beyond what was before.
fn peak(read: impl FnOnce()) -> usize {
    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    read();
    PEAK.load(Relaxed) - before
}

/// All in one test: other threads would be counted too.
#[test]
fn memory_is_bounded_by_the_size_of_the_file() {
    let xml = |name: &str, namespace: &str, inner: &str| {
        let head = format!("<{name} xmlns=\"http://www.openrtp.org/namespaces/{namespace}\">");
        format!("{head}{}</{name}>", inner.repeat(250_000 / inner.len()))
    };
    let yaml = |head: &str, item: &str| format!("{head}{}", item.repeat(60_000 / item.len()));
    let rts = [
        "<a/>",
        "<Components/>",
        "<Components><DataPorts/></Components>",
        "<StartUp/>",
        "<DataPortConnectors/>",
        "<Groups/>",
        "<!---->",
        "<?a?>",
        "<Components id='' a=''/>",
    ]
    .map(|inner| {
        (
            format!("rts {inner}"),
            xml("RtsProfile", "rts", inner),
            true,
        )
    });
    let rtc = ["<a/>", "<DataPorts/>", "<ServicePorts/>", "<Parameters/>"].map(|inner| {
        (
            format!("rtc {inner}"),
            xml("RtcProfile", "rtc", inner),
            false,
        )
    });
    let yaml = [
        ("rtsProfile:\n  components:\n", "  - {}\n", true),
        ("rtsProfile:\n  components:\n", "  - a: b\n", true),
        ("rtsProfile:\n  rtsExt::versionUpLogs:\n", "  - a\n", true),
        ("rtsProfile:\n  x: [", "a,", true),
        ("rtcProfile:\n  dataPorts:\n", "  - {}\n", false),
    ]
    .map(|(head, item, rts)| (format!("{head}{item}"), yaml(head, item), rts));
    let mut beyond = Vec::new();
    for (name, text, is_rts) in rts.into_iter().chain(rtc).chain(yaml) {
        let used = peak(|| {
            if is_rts {
                drop(rts_profile::read("f", text.as_bytes()));
            } else {
                drop(rtc_profile::read("f", text.as_bytes()));
            }
        });
        let times = used / text.len();
        println!("{times:4} x {name:?}");
        if used > TIMES * text.len() + (1 << 20) {
            beyond.push(format!("{times} x {name:?}"));
        }
    }
    for line in [
        "a\n", "a:\n", "a: 1\n", "\\a\n", "a: \\\n", "#\n", "\n", "a\\b\\",
    ] {
        let numbered = |number: usize| line.replace('a', &format!("k{number}"));
        for text in [line.repeat(100_000), (0..9_000).map(numbered).collect()] {
            let used = peak(|| drop(rtc_conf::read("f", text.as_bytes())));
            let times = used / text.len();
            println!("{times:4} x conf {line:?}");
            if used > 64 * text.len() + (1 << 20) {
                beyond.push(format!("{times} x conf {line:?}"));
            }
        }
    }
    assert!(beyond.is_empty(), "{}", beyond.join("\n"));
}
