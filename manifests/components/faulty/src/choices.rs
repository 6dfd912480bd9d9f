//! Parameters that are one of several words: examples of parameters with types of their own.

use rts_runtime::ParameterValue;

/// An enum of which each variant is written as a word; the first one is the word when nothing is said.
macro_rules! choices {
    ($(#[$about:meta])* $name:ident { $($(#[$what:meta])* $variant:ident = $word:literal,)* }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $($(#[$what])* $variant,)*
        }

        impl ParameterValue for $name {
            fn expected() -> String {
                format!("one of {}", [$($word),*].join(", "))
            }

            fn parse(text: &str) -> Option<Self> {
                match text.trim() {
                    $($word => Some(Self::$variant),)*
                    _ => None,
                }
            }

            fn text(&self) -> String {
                match self {
                    $(Self::$variant => $word.into(),)*
                }
            }
        }
    };
}

choices! {
    /// How to misbehave.
    Mode {
        /// Not at all.
        None = "none",
        /// `on_initialize` returns an error.
        FailInitialize = "fail_initialize",
        /// `on_activated` returns an error.
        FailActivate = "fail_activate",
        /// `on_execute` returns an error.
        ErrorAfter = "error_after",
        /// `on_execute` panics.
        PanicAfter = "panic_after",
        /// `on_execute` aborts the process.
        CrashAfter = "crash_after",
        /// `on_execute` ends the process with `exit_code`.
        ExitAfter = "exit_after",
        /// `on_activated` does not return.
        HangActivate = "hang_activate",
        /// `on_execute` does not return.
        HangExecute = "hang_execute",
    }
}

choices! {
    /// A callback that does not return, besides any mode.
    Hang {
        /// All return.
        Nowhere = "none",
        /// `on_initialize`.
        Initialize = "on_initialize",
        /// `on_activated`.
        Activated = "on_activated",
        /// `on_execute`, when it is time for it.
        Execute = "on_execute",
        /// `on_deactivated`.
        Deactivated = "on_deactivated",
        /// `on_error`.
        Error = "on_error",
        /// `on_reset`.
        Reset = "on_reset",
        /// `on_finalize`.
        Finalize = "on_finalize",
    }
}

choices! {
    /// A process that is started at the first activation, and lives for ten minutes when nobody ends it.
    Child {
        /// There is none.
        None = "none",
        /// It ignores SIGTERM.
        IgnoresTerm = "ignores_term",
        /// It ignores SIGTERM, in a session and so in a process group of its own.
        OwnSession = "own_session",
    }
}
