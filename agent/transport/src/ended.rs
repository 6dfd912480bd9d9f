//! How a connection ends, and why a sample is not taken.

use std::fmt;

use crate::{MAX_SAMPLE, Sample};

/// How a connection ends at this side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parting {
    /// By an order: the other end is told, and what was pushed before still arrives.
    GoodBye,
    /// By itself: to the other end it is a loss.
    Loss,
}

/// Why a connection came to its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// This side closed it.
    Here,
    /// The other side said good-bye.
    GoodBye,
    /// The other side is lost: what was seen of it.
    Lost(String),
}

impl Ended {
    /// How this side closes it for that.
    pub fn parting(&self) -> Parting {
        match self {
            Self::Here | Self::GoodBye => Parting::GoodBye,
            Self::Lost(_) => Parting::Loss,
        }
    }

    pub(crate) fn lost(reason: impl fmt::Display) -> Self {
        Self::Lost(reason.to_string())
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Here => f.write_str("it was closed here"),
            Self::GoodBye => f.write_str("the other end said good-bye"),
            Self::Lost(reason) => write!(f, "the other end is lost: {reason}"),
        }
    }
}

/// Why a sample was not taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refused {
    /// There is no room for it now.
    Full(Sample),
    /// No transport takes a payload of so many bytes.
    TooLarge(usize),
    /// The connection has ended.
    Ended(Ended),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full(_) => f.write_str("there is no room for the sample now"),
            Self::TooLarge(size) => {
                write!(
                    f,
                    "a sample of {size} bytes is too large: at most {MAX_SAMPLE} are sent"
                )
            }
            Self::Ended(ended) => write!(f, "the connection has ended: {ended}"),
        }
    }
}

impl std::error::Error for Refused {}
