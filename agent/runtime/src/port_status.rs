//! What became of a sample.

use crate::abi::port_status as code;
use crate::{ReturnCode, RtcError, RtcResult};

/// What became of a sample: what a component may care about, and nothing that it did wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PortStatus {
    /// Done.
    Ok,
    /// The buffer of a connector was full, and its policy kept the sample out.
    BufferFull,
    /// There was no sample.
    BufferEmpty,
    /// The time to wait for a buffer, or for the other end, was over.
    Timeout,
    /// The other end of a connector is lost.
    ConnectionLost,
}

impl PortStatus {
    /// Reads a code of the ABI; one that says that `what` was asked for wrongly is an error.
    pub(crate) fn of(what: &str, number: i32) -> RtcResult<Self> {
        match number {
            code::PORT_OK => Ok(Self::Ok),
            code::PORT_BUFFER_FULL | code::PORT_SEND_FULL => Ok(Self::BufferFull),
            code::PORT_BUFFER_EMPTY | code::PORT_RECV_EMPTY => Ok(Self::BufferEmpty),
            code::PORT_BUFFER_TIMEOUT | code::PORT_SEND_TIMEOUT | code::PORT_RECV_TIMEOUT => {
                Ok(Self::Timeout)
            }
            code::PORT_CONNECTION_LOST => Ok(Self::ConnectionLost),
            number => Err(refused(what, number)),
        }
    }
}

/// The error of a request that the manager refused.
pub(crate) fn refused(what: &str, number: i32) -> RtcError {
    let (code, name) = match number {
        code::PORT_BUFFER_ERROR => (ReturnCode::Error, "BUFFER_ERROR"),
        code::PORT_BUFFER_FULL => (ReturnCode::OutOfResources, "BUFFER_FULL"),
        code::PORT_INVALID_ARGS => (ReturnCode::BadParameter, "INVALID_ARGS"),
        code::PORT_PRECONDITION_NOT_MET => (ReturnCode::PreconditionNotMet, "PRECONDITION_NOT_MET"),
        code::PORT_UNKNOWN_ERROR => (ReturnCode::Error, "UNKNOWN_ERROR"),
        _ => (ReturnCode::Error, "PORT_ERROR"),
    };
    RtcError::new(code, format_args!("the manager refused to {what}: {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_component_did_wrong_is_an_error_and_the_rest_a_status() {
        let told: Vec<String> = (0..=14)
            .map(|number| match PortStatus::of("write", number) {
                Ok(status) => format!("{status:?}"),
                Err(error) => format!("{}: {error}", error.code()),
            })
            .collect();
        let refused =
            |code: &str, name: &str| format!("{code}: the manager refused to write: {name}");
        assert_eq!(
            told,
            [
                "Ok".to_owned(),
                refused("RTC_ERROR", "PORT_ERROR"),
                refused("RTC_ERROR", "BUFFER_ERROR"),
                "BufferFull".to_owned(),
                "BufferEmpty".to_owned(),
                "Timeout".to_owned(),
                "BufferFull".to_owned(),
                "Timeout".to_owned(),
                "BufferEmpty".to_owned(),
                "Timeout".to_owned(),
                refused("BAD_PARAMETER", "INVALID_ARGS"),
                refused("PRECONDITION_NOT_MET", "PRECONDITION_NOT_MET"),
                "ConnectionLost".to_owned(),
                refused("RTC_ERROR", "UNKNOWN_ERROR"),
                refused("RTC_ERROR", "PORT_ERROR"),
            ]
        );
    }
}
