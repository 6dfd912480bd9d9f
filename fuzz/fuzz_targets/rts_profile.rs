//! Any bytes as a profile: read, check, lower, render, and write again.
#![no_main]

#[path = "../laws.rs"]
mod laws;

use libfuzzer_sys::fuzz_target;
use rts_schemas::diagnostic::{Report, render};
use rts_schemas::rts_profile::{LowerOptions, WriteOptions, load, lower, read, sayable, write};
use rts_schemas::system::SystemSpec;

fuzz_target!(|bytes: &[u8]| {
    laws::system(bytes);
    let judged = load("system.xml", bytes, Some("name"), &[]);
    match &judged {
        Ok((spec, _)) => {
            // What the checks let pass is a sound system, and travels over the API unchanged.
            assert_eq!(rts_schemas::check::spec(spec), Report::default());
            let json = serde_json::to_string(spec).expect("a system is plain data");
            let back: SystemSpec = serde_json::from_str(&json).expect("its own JSON is read");
            assert_eq!(&back, spec);
            written(spec);
        }
        Err(report) => assert!(report.has_errors()),
    }
    let (Ok((_, report)) | Err(report)) = judged;
    for finding in &report.findings {
        assert!(!render(finding).contains('\u{1b}'));
    }
    if let Ok(profile) = read("system.xml", bytes)
        && let (Some(spec), _) = lower(&profile, &LowerOptions::default())
    {
        let _ = write(&spec, &OPTIONS);
    }
});

const OPTIONS: WriteOptions<'_> =
    WriteOptions { created: "2026-01-15T10:00:00", updated: "2026-01-15T10:00:00", abstract_text: "" };

/// What was read is written as the same system, which may be deployed as well.
fn written(spec: &SystemSpec) {
    let text = write(spec, &OPTIONS);
    let (again, _) = load("written.xml", text.as_bytes(), None, &[]).expect("what is written is right");
    assert_eq!(again, sayable(spec));
}
