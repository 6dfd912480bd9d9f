//! No file costs more memory than so many times its size and 1 MiB, however it is made.

#![allow(clippy::unwrap_used, unsafe_code)] // A failure here is a failed test; an allocator that counts is unsafe to write.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use rts_schemas::form::Format;
use rts_schemas::span::Text;
use rts_schemas::xml::Document;
use rts_schemas::{overlay, rtc_conf, rtc_profile, rts_profile};

/// Bytes of memory for a byte of the worst file.
const TIMES: usize = 64;
/// Bytes beside that, which the findings of any file may take: there are only so many, and each lists what is known.
const FINDINGS: usize = 5 << 18;

#[allow(dead_code)] // The benchmark asks for bytes.
mod generated;

struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static TOTAL: AtomicUsize = AtomicUsize::new(0);

/// Only one test at a time: other threads would be counted too.
static ALONE: Mutex<()> = Mutex::new(());

fn more(size: usize) {
    let now = NOW.fetch_add(size, Relaxed) + size;
    PEAK.fetch_max(now, Relaxed);
    TOTAL.fetch_add(size, Relaxed);
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
    // What grows is moved by the page tables, or in place: it does not stand there twice.
    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        NOW.fetch_sub(layout.size(), Relaxed);
        more(size);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(at, layout, size) }
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

/// A file that is nearly nothing but one piece, again and again.
fn repeated(head: &str, piece: &str, tail: &str, size: usize) -> String {
    let count = (size - head.len() - tail.len()) / piece.len();
    // Keys of a mapping must differ.
    let piece = |number: usize| piece.replace("%", &format!("{number:x}"));
    let pieces: String = (0..count).map(piece).collect();
    format!("{head}{pieces}{tail}")
}

/// Pieces of hostile files in XML, by the reader that they are for.
const XML: [(&str, &[&str]); 2] = [
    (
        "rts",
        &[
            "<a/>",
            "<a b=''/>",
            "<a>x</a>",
            "<a><b/></a>",
            "x<a/>",
            "<!---->",
            "<?a?>",
            "&#1;<a/>",
            "<?x-yaml {a: 1}?>",
            "<Components><?x-yaml {a: 1}?></Components>",
            "<![CDATA[]]><a/>",
            "\n",
            "<Components/>",
            "<Components id='' a=''/>",
            "<Components><DataPorts/></Components>",
            "<Components><DataPorts a=''/></Components>",
            "<Components><Participants/></Components>",
            "<Components a:b='' xmlns:a='c'/>",
            "<p:Components xmlns:p='http://www.openrtp.org/namespaces/rts'/>",
            "<StartUp/>",
            "<StartUp><targets/></StartUp>",
            "<DataPortConnectors/>",
            "<DataPortConnectors><targetDataPort/></DataPortConnectors>",
            "<Groups/>",
            "<Components><DataPorts><DataPortConnectors/></DataPorts></Components>",
        ],
    ),
    (
        "rtc",
        &[
            "<a/>",
            "<BasicInfo/>",
            "<DataPorts/>",
            "<ServicePorts/>",
            "<ServicePorts><ServiceInterface/></ServicePorts>",
            "<Parameters/>",
            "<Actions><a/></Actions>",
            "<ConfigurationSet><Configuration/></ConfigurationSet>",
            "<Language/>",
        ],
    ),
];

/// Heads, pieces and tails of hostile files in YAML.
const YAML: [(&str, &str, &str); 26] = [
    ("rtsProfile:\n  components:\n", "  - {}\n", ""),
    ("rtsProfile:\n  components:\n", "  - a: b\n", ""),
    ("rtsProfile:\n  components:\n", "  -\n", ""),
    ("rtsProfile:\n  components: [", "{},", "]"),
    ("rtsProfile:\n  components: [", "{a: },", "]"),
    ("rtsProfile:\n  components: [", "{id: 1},", "]"),
    ("rtsProfile:\n  components: [", "1,", "]"),
    ("rtsProfile:\n  components: [{dataPorts: [", "{},", "]}]"),
    ("rtsProfile:\n  startUp: [", "{},", "]"),
    ("rtsProfile:\n  startUp: {targets: [", "{},", "]}"),
    (
        "rtsProfile:\n  startUp: {targets: [",
        "{condition: },",
        "]}",
    ),
    ("rtsProfile:\n  dataPortConnectors: [", "{},", "]"),
    ("rtsProfile:\n  rtsExt::versionUpLogs:\n", "  - a\n", ""),
    ("rtsProfile:\n  rtsExt::versionUpLogs: [", "a,", "]"),
    ("rtsProfile:\n  rtsExt::versionUpLogs: [", "[],", "]"),
    ("rtsProfile:\n  x: [", "a,", "]"),
    ("rtsProfile:\n  x: [", "[],", "]"),
    ("rtsProfile:\n  x: {", "%,", "}"),
    ("rtsProfile:\n", "  %:\n", ""),
    ("rtsProfile:\n", "\n", ""),
    (
        "rtsProfile:\n  x: &x [1,2,3,4,5,6,7,8,9]\n  y: [",
        "*x,",
        "]",
    ),
    (
        "rtsProfile:\n  x: &x [1,2,3,4,5,6,7,8,9]\n  components: [",
        "*x,",
        "]",
    ),
    ("rtsProfile:\n  x-xml: {elements: [", "<a/>,", "]}"),
    ("rtcProfile:\n  dataPorts:\n", "  - {}\n", ""),
    ("rtcProfile:\n  dataPorts: [", "{},", "]"),
    ("rtcProfile:\n  parameters: [", "{},", "]"),
];

/// Heads, pieces and tails of hostile overlays.
const OVERLAY: [(&str, &str, &str); 5] = [
    ("spec: {components: {", "%,", "}}"),
    ("spec: {components: {", "%: {a: },", "}}"),
    ("spec: {components: {", "%: {node: 1},", "}}"),
    ("", "%:\n", ""),
    ("[", "{},", "]"),
];

/// Files in which few things stand often, and many things in each other.
fn twisted(size: usize) -> Vec<(&'static str, String)> {
    const RTS: &str = "<RtsProfile xmlns='http://www.openrtp.org/namespaces/rts'>";
    let half = size / 2;
    let long = "n".repeat(half);
    let deep = "<a>".repeat(100);
    let back = "</a>".repeat(100);
    let connectors = "<DataPortConnectors/>".repeat(half / 21);
    let targets = "<targetDataPort/>".repeat(half / 17);
    let properties = "<e:Properties/>".repeat(half / 15);
    let open = "[".repeat(100);
    let close = "]".repeat(100);
    vec![
        (
            "a long name in each of many nested connectors",
            format!("{RTS}<Components id='{long}' instanceName='{long}'><DataPorts>{connectors}</DataPorts></Components></RtsProfile>"),
        ),
        (
            "many properties for each of many targets",
            format!("{RTS}<DataPortConnectors xmlns:e='http://www.openrtp.org/namespaces/rts_ext'>{properties}{targets}</DataPortConnectors></RtsProfile>"),
        ),
        (
            "deep elements",
            format!("{RTS}{}</RtsProfile>", format!("{deep}{back}").repeat(size / 700)),
        ),
        (
            "deep lists",
            format!("rtsProfile: {{x: [{}]}}", format!("{open}{close},").repeat(size / 201)),
        ),
        (
            "aliases of aliases",
            "a: &a [1,1,1,1]\nb: &b [*a,*a,*a,*a,*a,*a,*a,*a]\nc: &c [*b,*b,*b,*b,*b,*b,*b,*b]\nd: &d [*c,*c,*c,*c,*c,*c,*c,*c]\ne: &e [*d,*d,*d,*d,*d,*d,*d,*d]\nf: &f [*e,*e,*e,*e,*e,*e,*e,*e]\ng: &g [*f,*f,*f,*f,*f,*f,*f,*f]\nrtsProfile: [*g,*g,*g,*g,*g,*g,*g,*g]\n".to_owned(),
        ),
        (
            "no line end",
            format!("rtsProfile: {{components: [{}]}}", "{x: 1}, ".repeat(size / 8)),
        ),
        ("no UTF-8", "\u{e9}".repeat(half).chars().map(|_| "\u{e9}").collect()),
    ]
}

/// Name of a reader, and the reader.
type Reader = (&'static str, fn(&[u8]));

#[test]
fn memory_is_bounded_by_the_size_of_the_file() {
    let _alone = ALONE.lock().unwrap();
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for size in [3_000, 100_000] {
        for (kind, pieces) in XML {
            let root = if kind == "rts" {
                "RtsProfile"
            } else {
                "RtcProfile"
            };
            let head = format!("<{root} xmlns='http://www.openrtp.org/namespaces/{kind}'>");
            let tail = format!("</{root}>");
            for piece in pieces {
                let text = repeated(&head, piece, &tail, size);
                files.push((format!("{kind} {piece}"), text.into_bytes()));
            }
        }
        for (head, piece, tail) in YAML.into_iter().chain(OVERLAY) {
            let text = repeated(head, piece, tail, size);
            files.push((format!("{head}{piece}{tail}"), text.into_bytes()));
        }
        for (name, text) in twisted(size) {
            files.push((name.to_owned(), text.into_bytes()));
        }
    }
    let mut beyond = Vec::new();
    for line in [
        "a\n", "a:\n", "a: 1\n", "\\a\n", "a: \\\n", "#\n", "\n", "a\\b\\",
    ] {
        let numbered = |number: usize| line.replace('a', &format!("k{number}"));
        for text in [line.repeat(100_000), (0..9_000).map(numbered).collect()] {
            let used = peak(|| drop(rtc_conf::read("f", text.as_bytes())));
            let times = used / text.len();
            if used > TIMES * text.len() + (1 << 20) {
                beyond.push(format!("{times} x conf {line:?}"));
            }
        }
    }
    let mut worst = (0, String::new());
    for (name, file) in &files {
        let readers: [Reader; 2] = [
            match file
                .windows(10)
                .any(|piece| piece.eq_ignore_ascii_case(b"rtcProfile"))
            {
                true => ("rtc", |file| drop(rtc_profile::read("f", file))),
                false => ("rts", |file| drop(rts_profile::read("f", file))),
            },
            match file.starts_with(b"<") {
                true => ("document", |file| drop(Document::open("f", file))),
                false => ("overlay", |file| drop(overlay::read("f", file))),
            },
        ];
        for (reader, read) in readers {
            let used = peak(|| read(file));
            let times = used.saturating_sub(FINDINGS) / file.len();
            if used > TIMES * file.len() + FINDINGS {
                let size = file.len();
                beyond.push(format!("{times} x {size} bytes by {reader}: {name:?}"));
            }
            if times > worst.0 {
                worst = (times, format!("{name:?} by {reader}"));
            }
        }
    }
    println!(
        "{} files, the worst {} x and what findings take: {}",
        files.len(),
        worst.0,
        worst.1
    );
    assert!(beyond.is_empty(), "{}", beyond.join("\n"));
}

/// What is done with a profile.
type Work = (&'static str, fn(&str));

/// Ten times the components take about ten times the memory, all that was ever asked for counted.
#[test]
fn work_grows_with_the_size_of_the_file() {
    let _alone = ALONE.lock().unwrap();
    let small = generated::of_components(50);
    let large = generated::of_components(500);
    let works: [Work; 4] = [
        ("read", |text| drop(read(text))),
        ("load", |text| {
            let loaded = rts_profile::load_with_places("f", text.as_bytes(), None, &[]);
            assert!(loaded.unwrap().report.findings.is_empty());
        }),
        ("write", |text| {
            let read = read(text);
            assert!(rts_profile::format(&read.shape, &read.around, read.format).len() > 1000);
        }),
        ("edit", edit_every_second),
    ];
    let total = |work: fn(&str), text: &str| {
        let before = TOTAL.load(Relaxed);
        work(text);
        TOTAL.load(Relaxed) - before
    };
    for (name, work) in works {
        let forms = [
            ("xml", small.clone(), large.clone()),
            ("yaml", in_yaml(&small), in_yaml(&large)),
        ];
        for (format, small, large) in forms {
            if name == "edit" && format == "yaml" {
                continue;
            }
            let (few, many) = (total(work, &small), total(work, &large));
            println!("{name} {format}: {few} and {many} bytes");
            assert!(many <= 12 * few, "{name} {format}: {few} and {many} bytes");
        }
    }
}

fn read(text: &str) -> rts_profile::ReadProfile {
    rts_profile::read("f", text.as_bytes()).unwrap()
}

fn in_yaml(text: &str) -> String {
    let read = read(text);
    rts_profile::format(&read.shape, &read.around, Format::Yaml)
}

/// Changes, removes and adds elements all over the file.
fn edit_every_second(text: &str) {
    let document = Document::open("f", text.as_bytes()).unwrap();
    let old = read(text).shape;
    let mut new = old.clone();
    let rts_profile::forms::Shape::V02(profile) = &mut new else {
        panic!("it is of version 0.2");
    };
    let mut number = 0;
    profile.components.retain_mut(|component| {
        number += 1;
        component.path_uri = Some(Text::new(format!("localhost/{number}.rtc"), component.span));
        number % 7 != 0
    });
    let added = vec![rts_profile::forms::Component::default(); profile.components.len() / 2];
    profile.components.extend(added);
    rts_profile::patch(&document, &old, &new).unwrap();
}
