//! What holds of every profile that is read.

#![allow(dead_code)] // Each target takes what it needs.

use rts_schemas::diagnostic::{Report, render};
use rts_schemas::form::{Format, same};
use rts_schemas::xml::Document;
use rts_schemas::{rtc_profile, rts_profile};

#[path = "counting.rs"]
mod counting;

pub use counting::bounded;

/// An RTS Profile costs little, and is read again as the same from what is written.
pub fn system(bytes: &[u8]) {
    let Some(read) = judged(bounded(bytes, |bytes| rts_profile::read("f", bytes)), |read| &read.findings) else {
        return;
    };
    let text = rts_profile::format(&read.shape, &read.around, read.format);
    let again = rts_profile::read("f", text.as_bytes()).expect("what is written is right");
    assert!(same(again.shape.form(), read.shape.form()), "{text}");
    for format in [Format::Xml, Format::Yaml] {
        let _ = rts_profile::format(&read.shape, &read.around, format);
    }
    untouched(bytes);
}

/// The same of an RTC Profile.
pub fn component(bytes: &[u8]) {
    let Some(read) = judged(bounded(bytes, |bytes| rtc_profile::read("f", bytes)), |read| &read.findings) else {
        return;
    };
    let text = rtc_profile::format(&read.profile, &read.around, read.format);
    let again = rtc_profile::read("f", text.as_bytes()).expect("what is written is right");
    assert!(same(&again.profile, &read.profile), "{text}");
    for format in [Format::Xml, Format::Yaml] {
        let _ = rtc_profile::format(&read.profile, &read.around, format);
    }
    untouched(bytes);
}

/// What was read, unless it could not be, or was not to its end; its findings can be shown.
fn judged<T>(read: Result<T, Report>, findings: impl Fn(&T) -> &Report) -> Option<T> {
    match read {
        Ok(read) => {
            let report = findings(&read);
            assert!(report.findings.iter().all(|f| !render(f).contains('\u{1b}')));
            let whole = report.findings.iter().all(|f| f.code != "too-dense");
            whole.then_some(read)
        }
        Err(report) => {
            assert!(report.has_errors());
            None
        }
    }
}

/// A file that nobody edited is the very same.
fn untouched(bytes: &[u8]) {
    if let Ok(document) = bounded(bytes, |bytes| Document::open("f", bytes)) {
        assert_eq!(document.bytes().expect("nothing was edited"), bytes);
    }
}
