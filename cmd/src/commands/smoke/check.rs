//! The checks by name.

/// A check, in the order in which they are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Check {
    /// The stack comes up.
    Start,
    /// Every required component becomes Active.
    Apply,
    /// Every data connector carries samples.
    Samples,
    /// A second apply changes nothing.
    Again,
    /// What is exported is what runs.
    Export,
    /// For some time nothing dies.
    Steady,
    /// A manager that was killed comes back.
    Heal,
    /// The system goes.
    Teardown,
    /// Nothing is left.
    Clean,
    /// All of it; only of interest with a budget.
    Total,
}

impl Check {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Start,
        Self::Apply,
        Self::Samples,
        Self::Again,
        Self::Export,
        Self::Steady,
        Self::Heal,
        Self::Teardown,
        Self::Clean,
        Self::Total,
    ];

    /// As people write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Apply => "apply",
            Self::Samples => "samples",
            Self::Again => "again",
            Self::Export => "export",
            Self::Steady => "steady",
            Self::Heal => "heal",
            Self::Teardown => "teardown",
            Self::Clean => "clean",
            Self::Total => "total",
        }
    }
}
