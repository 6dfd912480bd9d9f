//! Short ways to make a refusal.

use rts_manager_api::control::{Failure, FailureCode};

/// Makes a refusal.
pub fn failure(code: FailureCode, message: impl Into<String>) -> Failure {
    Failure {
        code,
        message: message.into(),
    }
}

/// No such instance, module or port.
pub fn not_found(message: impl Into<String>) -> Failure {
    failure(FailureCode::NotFound, message)
}

/// It is there already and differs, or is in use.
pub fn conflict(message: impl Into<String>) -> Failure {
    failure(FailureCode::Conflict, message)
}

/// The request makes no sense.
pub fn invalid(message: impl Into<String>) -> Failure {
    failure(FailureCode::Invalid, message)
}

/// The manager itself failed.
pub fn internal(message: impl Into<String>) -> Failure {
    failure(FailureCode::Internal, message)
}

/// Names in a list for people: `a, b, c`, or `none`.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.into_iter().collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
