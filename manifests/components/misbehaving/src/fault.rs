//! What can be wrong with a component, and the words for it.

/// A callback, as the words name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Callback {
    Initialize,
    Finalize,
    Startup,
    Shutdown,
    Activate,
    Deactivate,
    Abort,
    Error,
    Reset,
    Execute,
    StateUpdate,
    RateChanged,
}

impl Callback {
    /// Its method.
    pub fn method(self) -> &'static str {
        match self {
            Self::Initialize => "on_initialize",
            Self::Finalize => "on_finalize",
            Self::Startup => "on_startup",
            Self::Shutdown => "on_shutdown",
            Self::Activate => "on_activated",
            Self::Deactivate => "on_deactivated",
            Self::Abort => "on_aborting",
            Self::Error => "on_error",
            Self::Reset => "on_reset",
            Self::Execute => "on_execute",
            Self::StateUpdate => "on_state_update",
            Self::RateChanged => "on_rate_changed",
        }
    }

    /// True for what is called only after an error.
    pub fn is_after_an_error(self) -> bool {
        matches!(self, Self::Abort | Self::Error | Self::Reset)
    }
}

/// What is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    None,
    /// `on_initialize` aborts the process.
    CrashAtOnce,
    /// `on_execute` aborts the process.
    CrashLater,
    /// `on_execute` ends the process as if that were in order.
    Exit,
    /// `on_execute` panics.
    Panic,
    /// A callback does not return.
    Hang(Callback),
    /// A callback returns ERROR.
    Fail(Callback),
    /// `on_activated` takes long.
    SlowActivate,
    /// `on_execute` sends as fast as it can.
    Flood,
    /// `on_execute` takes memory and never gives it back.
    Leak,
    /// It starts processes and leaves them behind.
    Grandchildren,
}

/// The words for all faults.
pub const WORDS: &[(&str, Fault)] = &[
    ("none", Fault::None),
    ("crash-at-once", Fault::CrashAtOnce),
    ("crash-later", Fault::CrashLater),
    ("exit", Fault::Exit),
    ("panic", Fault::Panic),
    ("hang-initialize", Fault::Hang(Callback::Initialize)),
    ("hang-startup", Fault::Hang(Callback::Startup)),
    ("hang-activate", Fault::Hang(Callback::Activate)),
    ("hang-execute", Fault::Hang(Callback::Execute)),
    ("hang-state-update", Fault::Hang(Callback::StateUpdate)),
    ("hang-rate-changed", Fault::Hang(Callback::RateChanged)),
    ("hang-deactivate", Fault::Hang(Callback::Deactivate)),
    ("hang-abort", Fault::Hang(Callback::Abort)),
    ("hang-error", Fault::Hang(Callback::Error)),
    ("hang-reset", Fault::Hang(Callback::Reset)),
    ("hang-shutdown", Fault::Hang(Callback::Shutdown)),
    ("hang-finalize", Fault::Hang(Callback::Finalize)),
    ("error-initialize", Fault::Fail(Callback::Initialize)),
    ("error-startup", Fault::Fail(Callback::Startup)),
    ("error-activate", Fault::Fail(Callback::Activate)),
    ("error-execute", Fault::Fail(Callback::Execute)),
    ("error-state-update", Fault::Fail(Callback::StateUpdate)),
    ("error-rate-changed", Fault::Fail(Callback::RateChanged)),
    ("ignore-deactivate", Fault::Fail(Callback::Deactivate)),
    ("error-abort", Fault::Fail(Callback::Abort)),
    ("error-error", Fault::Fail(Callback::Error)),
    ("error-reset", Fault::Fail(Callback::Reset)),
    ("error-shutdown", Fault::Fail(Callback::Shutdown)),
    ("error-finalize", Fault::Fail(Callback::Finalize)),
    ("slow-activate", Fault::SlowActivate),
    ("flood", Fault::Flood),
    ("leak", Fault::Leak),
    ("grandchildren", Fault::Grandchildren),
];

/// Reads a word.
pub fn read(word: &str) -> Result<Fault, String> {
    let found = WORDS.iter().find(|(known, _)| *known == word.trim());
    found.map(|(_, fault)| *fault).ok_or_else(|| {
        let known: Vec<&str> = WORDS.iter().map(|(known, _)| *known).collect();
        format!("there is no fault `{word}`; there are {}", known.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_word_means_something_else() {
        for (word, fault) in WORDS {
            assert_eq!(read(word), Ok(*fault));
            let same = WORDS.iter().filter(|(_, other)| other == fault);
            assert_eq!(same.count(), 1, "{word}");
        }
        let words: BTreeSet<_> = WORDS.iter().map(|(word, _)| word).collect();
        assert_eq!(words.len(), WORDS.len());
    }

    /// `CrashAtOnce` as `crash-at-once`.
    fn kebab(variant: &str) -> String {
        let mut word = String::new();
        for letter in variant.chars() {
            if letter.is_uppercase() && !word.is_empty() {
                word.push('-');
            }
            word.extend(letter.to_lowercase());
        }
        word
    }

    /// The simulation's components misbehave by the same words.
    #[test]
    fn the_words_of_the_simulation_are_known() {
        let source = include_str!("../../../../simulation/src/faults.rs");
        let variants = source.split_once("pub enum Misbehaviour {").unwrap().1;
        let variants = variants.split_once("\n}").unwrap().0;
        let variants = variants.lines().filter_map(|l| l.trim().strip_suffix(','));
        let words: Vec<String> = variants.map(kebab).collect();
        assert!(words.len() >= 13, "{words:?}");
        for word in words {
            assert!(read(&word).is_ok(), "{word}");
        }
    }
}
