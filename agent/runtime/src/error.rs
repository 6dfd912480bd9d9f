//! How a callback fails: a return code and a reason for people.

use std::fmt::{self, Display};

use crate::abi::return_code;

/// Result of a callback, and of what a callback does.
pub type RtcResult<T = ()> = Result<T, RtcError>;

/// `ReturnCode_t` of OMG RTC 1.0 (5.2.2.1), without OK.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReturnCode {
    /// RTC_ERROR: anything else.
    Error,
    /// BAD_PARAMETER.
    BadParameter,
    /// UNSUPPORTED.
    Unsupported,
    /// OUT_OF_RESOURCES.
    OutOfResources,
    /// PRECONDITION_NOT_MET.
    PreconditionNotMet,
}

impl ReturnCode {
    /// Its number in the ABI.
    pub fn number(self) -> i32 {
        match self {
            Self::Error => return_code::ERROR,
            Self::BadParameter => return_code::BAD_PARAMETER,
            Self::Unsupported => return_code::UNSUPPORTED,
            Self::OutOfResources => return_code::OUT_OF_RESOURCES,
            Self::PreconditionNotMet => return_code::PRECONDITION_NOT_MET,
        }
    }

    /// From its number in the ABI; an unknown one is [`ReturnCode::Error`].
    pub fn from_number(number: i32) -> Self {
        match number {
            return_code::BAD_PARAMETER => Self::BadParameter,
            return_code::UNSUPPORTED => Self::Unsupported,
            return_code::OUT_OF_RESOURCES => Self::OutOfResources,
            return_code::PRECONDITION_NOT_MET => Self::PreconditionNotMet,
            _ => Self::Error,
        }
    }
}

impl Display for ReturnCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Error => "RTC_ERROR",
            Self::BadParameter => "BAD_PARAMETER",
            Self::Unsupported => "UNSUPPORTED",
            Self::OutOfResources => "OUT_OF_RESOURCES",
            Self::PreconditionNotMet => "PRECONDITION_NOT_MET",
        })
    }
}

/// Why a callback failed.
///
/// Every [`std::error::Error`] converts into it with its whole chain of causes, so `?` works on I/O and the like. For
/// that reason it is no `std::error::Error` itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RtcError {
    code: ReturnCode,
    reason: String,
}

impl RtcError {
    /// Fails with a code and a reason.
    pub fn new(code: ReturnCode, reason: impl Display) -> Self {
        Self {
            code,
            reason: reason.to_string(),
        }
    }

    /// Fails with RTC_ERROR.
    pub fn error(reason: impl Display) -> Self {
        Self::new(ReturnCode::Error, reason)
    }

    /// Fails with BAD_PARAMETER.
    pub fn bad_parameter(reason: impl Display) -> Self {
        Self::new(ReturnCode::BadParameter, reason)
    }

    /// Fails with PRECONDITION_NOT_MET.
    pub fn precondition(reason: impl Display) -> Self {
        Self::new(ReturnCode::PreconditionNotMet, reason)
    }

    /// Puts what was being tried before the reason: `open /dev/ttyS0: permission denied`.
    #[must_use]
    pub fn context(mut self, tried: impl Display) -> Self {
        self.reason = format!("{tried}: {}", self.reason);
        self
    }

    /// The code.
    pub fn code(&self) -> ReturnCode {
        self.code
    }

    /// The reason.
    pub fn reason(&self) -> &str {
        &self.reason
    }
}

impl Display for RtcError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl<E: std::error::Error> From<E> for RtcError {
    fn from(error: E) -> Self {
        let mut reason = error.to_string();
        let mut cause = error.source();
        while let Some(error) = cause {
            reason.push_str(": ");
            reason.push_str(&error.to_string());
            cause = error.source();
        }
        Self::error(reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("cannot read the encoder")]
    struct Encoder(#[source] std::num::ParseIntError);

    #[test]
    fn question_mark_keeps_the_whole_chain() {
        fn fails() -> RtcResult {
            "x".parse::<i32>().map_err(Encoder)?;
            Ok(())
        }
        let error = fails().unwrap_err();
        assert_eq!(error.code(), ReturnCode::Error);
        assert_eq!(
            error.context("axis 2").to_string(),
            "axis 2: cannot read the encoder: invalid digit found in string"
        );
    }

    #[test]
    fn codes_survive_the_abi() {
        for code in [
            ReturnCode::Error,
            ReturnCode::BadParameter,
            ReturnCode::Unsupported,
            ReturnCode::OutOfResources,
            ReturnCode::PreconditionNotMet,
        ] {
            assert_eq!(ReturnCode::from_number(code.number()), code);
        }
        assert_eq!(ReturnCode::from_number(77), ReturnCode::Error);
    }
}
