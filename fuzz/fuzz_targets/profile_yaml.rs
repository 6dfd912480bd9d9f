//! Any text under the root keys of RTS and RTC Profiles in YAML: most bytes reach no reader without them.
#![no_main]

#[path = "../laws.rs"]
mod laws;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let body: String = text.lines().map(|line| format!("  {line}\n")).collect();
    laws::system(format!("rtsProfile:\n{body}").as_bytes());
    laws::component(format!("rtcProfile:\n{body}").as_bytes());
});
