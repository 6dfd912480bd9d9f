//! What the codes of findings mean: one line each, and an explanation with an example and a way to mend it.

mod canonical;
mod connectors;
mod idl;
mod overlay;
mod parameters;
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
const AREAS: [&[Code]; 10] = [
    reading::CODES,
    profile::CODES,
    connectors::CODES,
    parameters::CODES,
    overlay::CODES,
    rtc_profile::CODES,
    rtc_conf::CODES,
    plan::CODES,
    canonical::CODES,
    idl::CODES,
];

/// Every code, area by area.
pub fn all() -> impl Iterator<Item = &'static Code> {
    AREAS.into_iter().flatten()
}

/// The code of this name.
pub fn find(code: &str) -> Option<&'static Code> {
    all().find(|known| known.code == code)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    #[test]
    fn every_code_is_explained_once() {
        let mut seen = HashSet::new();
        for code in super::all() {
            assert!(seen.insert(code.code), "{} stands twice", code.code);
            assert!(!code.title.ends_with('.') && !code.title.is_empty());
            assert!(code.explain.len() > 100, "{}", code.code);
            let kebab = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            assert!(code.code.chars().all(kebab), "{}", code.code);
            let long = code.explain.lines().find(|line| line.chars().count() > 124);
            assert_eq!(long, None, "{}", code.code);
        }
    }
}
