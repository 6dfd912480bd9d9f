//! Any bytes as an `rtc.conf` that names itself as a component's file: read, convert, and read what came of it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rts_schemas::diagnostic::{Report, render};
use rts_schemas::form::Format;
use rts_schemas::rtc_conf::{Options, Sources, convert, load};
use rts_schemas::{overlay, rts_profile};

struct Itself<'a>(&'a [u8]);

impl Sources for Itself<'_> {
    fn read(&self, _: &str) -> Result<Option<Vec<u8>>, String> {
        Ok(Some(self.0.to_vec()))
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mut report = Report::default();
    let setup = load(&[("rtc.conf", bytes)], &Itself(bytes), &mut report);
    let options = Options {
        name: None,
        created: "2026-01-15T10:00:00",
        types: &[],
        managers_inside: true,
    };
    let made = convert(&setup, &options);
    report.extend(made.report.clone());
    for finding in &report.findings {
        assert!(!render(finding).contains('\u{1b}'));
    }
    // Whatever it says, what is written can be read.
    let text = made.text(Format::Xml);
    let read =
        rts_profile::read("made.xml", text.as_bytes()).expect("what is written is a profile");
    assert_eq!(read.profile.components.len(), made.profile.components.len());
    overlay::read("made.yaml", made.overlay.as_bytes()).expect("what is written is an overlay");
});
