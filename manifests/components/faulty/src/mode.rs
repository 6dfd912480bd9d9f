//! The parameter `mode`: an example of a parameter with a type of its own.

use rts_runtime::ParameterValue;

/// How to misbehave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Not at all.
    None,
    /// `on_initialize` returns an error.
    FailInitialize,
    /// `on_activated` returns an error.
    FailActivate,
    /// `on_execute` returns an error.
    ErrorAfter,
    /// `on_execute` panics.
    PanicAfter,
    /// `on_execute` aborts the process.
    CrashAfter,
    /// `on_activated` does not return.
    HangActivate,
    /// `on_execute` does not return.
    HangExecute,
}

const NAMES: [(&str, Mode); 8] = [
    ("none", Mode::None),
    ("fail_initialize", Mode::FailInitialize),
    ("fail_activate", Mode::FailActivate),
    ("error_after", Mode::ErrorAfter),
    ("panic_after", Mode::PanicAfter),
    ("crash_after", Mode::CrashAfter),
    ("hang_activate", Mode::HangActivate),
    ("hang_execute", Mode::HangExecute),
];

impl ParameterValue for Mode {
    fn expected() -> String {
        format!("one of {}", NAMES.map(|(name, _)| name).join(", "))
    }

    fn parse(text: &str) -> Option<Self> {
        let found = NAMES.iter().find(|(name, _)| *name == text.trim())?;
        Some(found.1)
    }

    fn text(&self) -> String {
        let found = NAMES.iter().find(|(_, mode)| mode == self);
        found.map_or("none", |(name, _)| name).into()
    }
}
