//! What is wrong with bytes, a value or a JSON text, and where in the type.

use std::fmt;

use crate::idl::{Type, Unit};

/// A value that cannot be read or written.
#[derive(Debug, Clone, PartialEq)]
pub struct Error {
    /// Where in the type: `TimedPose2D.data.position.x`.
    pub place: String,
    /// Byte that it begins at, where bytes are read.
    pub at: Option<usize>,
    /// What is wrong.
    pub reason: Reason,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at {
            Some(at) => write!(f, "{} at byte {at}: {}", self.place, self.reason),
            None => write!(f, "{}: {}", self.place, self.reason),
        }
    }
}

impl std::error::Error for Error {}

impl From<Reason> for Error {
    fn from(reason: Reason) -> Self {
        Self {
            place: String::new(),
            at: None,
            reason,
        }
    }
}

impl Error {
    pub(super) fn at(reason: Reason, at: usize) -> Self {
        Self {
            at: Some(at),
            ..reason.into()
        }
    }

    pub(super) fn in_member(mut self, name: &str) -> Self {
        self.place.insert_str(0, name);
        self.place.insert(0, '.');
        self
    }

    pub(super) fn in_element(mut self, index: usize) -> Self {
        self.place.insert_str(0, &format!("[{index}]"));
        self
    }

    pub(super) fn in_type(mut self, unit: &Unit, r#type: &Type) -> Self {
        let name = match r#type {
            Type::Named(index) => unit.definitions.get(*index).and_then(|d| d.path.last()),
            _ => None,
        };
        self.place
            .insert_str(0, name.map_or("value", String::as_str));
        self
    }
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Reason {
    /// Bytes are missing.
    #[error("{needed} bytes are needed, {left} are left")]
    Ends {
        /// Bytes of the item.
        needed: usize,
        /// Bytes that are there.
        left: usize,
    },
    /// There is more than the value.
    #[error("{0} bytes are left over")]
    Leftover(usize),
    /// More elements than bytes.
    #[error("{count} elements are claimed, {left} bytes are left")]
    Claim {
        /// Elements.
        count: u32,
        /// Bytes that are there.
        left: usize,
    },
    /// More than the type permits.
    #[error("its length is {length}, the type permits {bound}")]
    Bound {
        /// Elements or characters.
        length: usize,
        /// Most.
        bound: u32,
    },
    /// An array of another length.
    #[error("it has {found} elements, the array has {length}")]
    Length {
        /// Elements that are there.
        found: usize,
        /// Elements of the array.
        length: u32,
    },
    /// A length that no u32 holds.
    #[error("its length is {0}, CDR counts to 4294967295")]
    TooLong(usize),
    /// A byte that is no truth value.
    #[error("{0} is neither 0 (FALSE) nor 1 (TRUE)")]
    Boolean(u8),
    /// A number that is no enumerator.
    #[error("{ordinal} is no enumerator, there are {count}")]
    Enumerator {
        /// Number.
        ordinal: u32,
        /// Enumerators of the type.
        count: usize,
    },
    /// A string that is none.
    #[error("{0}")]
    Text(&'static str),
    /// A union whose member does not belong to its discriminator.
    #[error("{0}")]
    Union(&'static str),
    /// A value of another type.
    #[error("it is {found}, {wanted} is needed")]
    Mismatch {
        /// What the type is.
        wanted: &'static str,
        /// What the value is.
        found: &'static str,
    },
    /// A struct with too few or too many members.
    #[error("it has {found} members, the struct has {count}")]
    Members {
        /// Members of the value.
        found: usize,
        /// Members of the struct.
        count: usize,
    },
    /// JSON that is no such value.
    #[error("{0}")]
    Json(String),
    /// A type that holds itself too often.
    #[error("its types are nested more than {} deep", super::DEEPEST)]
    Deep,
    /// An array that is too large to be made of nothing.
    #[error("it is too large to be left out")]
    Large,
    /// A type that no port carries.
    #[error("{0}")]
    Type(&'static str),
}
