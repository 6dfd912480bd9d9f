//! Any bytes as an RTC Profile: read, render, write in both formats, and read again.
#![no_main]

#[path = "../laws.rs"]
mod laws;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| laws::component(bytes));
