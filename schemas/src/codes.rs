//! What the codes of findings mean: one line each, and an explanation with an example and a way to mend it.

mod canonical;
mod overlay;
mod plan;
mod profile;
mod reading;
mod rtc_conf;
mod rtc_profile;

/// A code, explained.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// As findings have it, in kebab case.
    pub code: &'static str,
    /// What it says, in one line.
    pub title: &'static str,
    /// What it means, why it matters and how to mend it; plain text of several lines.
    pub explain: &'static str,
}

/// Areas of codes.
const AREAS: [&[Code]; 7] = [
    reading::CODES,
    profile::CODES,
    overlay::CODES,
    rtc_profile::CODES,
    rtc_conf::CODES,
    plan::CODES,
    canonical::CODES,
];

/// Every code, area by area.
pub fn all() -> impl Iterator<Item = &'static Code> {
    AREAS.into_iter().flatten()
}

/// The code of this name.
pub fn find(code: &str) -> Option<&'static Code> {
    all().find(|known| known.code == code)
}
