//! Errors of an API as RFC 9457 `application/problem+json`.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Media type of a problem document.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// A problem document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Problem {
    /// Stable code of the kind of problem in kebab case (`invalid-system`), as a relative URI reference.
    #[serde(rename = "type")]
    pub code: String,
    /// The kind in words.
    pub title: String,
    /// HTTP status.
    pub status: u16,
    /// This occurrence: what, why, how to mend it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub detail: String,
    /// Single faults, when there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<ProblemError>,
    /// The same request may succeed later.
    #[serde(default)]
    pub retryable: bool,
    /// The node that is the cause, where one is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>)]
    pub node: Option<Box<str>>,
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProblemError {
    /// JSON pointer into the request body, or empty.
    #[serde(default)]
    pub pointer: String,
    /// Stable code in kebab case.
    pub code: String,
    /// What is wrong.
    pub detail: String,
    /// How to mend it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl Problem {
    /// A problem with a status, a code, and what happened.
    pub fn new(status: u16, code: &str, title: &str, detail: impl Into<String>) -> Self {
        Self {
            code: code.to_owned(),
            title: title.to_owned(),
            status,
            detail: detail.into(),
            errors: Vec::new(),
            retryable: matches!(status, 408 | 429 | 502 | 503 | 504),
            node: None,
        }
    }

    /// 400: the request cannot be understood.
    pub fn bad_request(detail: impl Into<String>) -> Self {
        Self::new(
            400,
            "bad-request",
            "the request cannot be understood",
            detail,
        )
    }

    /// 404: there is no such thing.
    pub fn not_found(detail: impl Into<String>) -> Self {
        Self::new(404, "not-found", "not found", detail)
    }

    /// 409: the present state does not allow it.
    pub fn conflict(code: &str, detail: impl Into<String>) -> Self {
        Self::new(409, code, "conflict", detail)
    }

    /// 422: understood, but invalid.
    pub fn invalid(code: &str, detail: impl Into<String>) -> Self {
        Self::new(422, code, "invalid", detail)
    }

    /// 500: our own fault.
    pub fn internal(detail: impl Into<String>) -> Self {
        Self::new(500, "internal", "internal error", detail)
    }

    /// 503: something that is needed is not there now.
    pub fn unavailable(code: &str, detail: impl Into<String>) -> Self {
        Self::new(503, code, "unavailable", detail)
    }

    /// The same problem with single faults.
    #[must_use]
    pub fn with_errors(mut self, errors: Vec<ProblemError>) -> Self {
        self.errors = errors;
        self
    }

    /// The same problem with the node that is its cause.
    #[must_use]
    pub fn of_node(mut self, node: &str) -> Self {
        self.node = Some(node.into());
        self
    }
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.detail.is_empty() {
            f.write_str(&self.title)
        } else {
            f.write_str(&self.detail)
        }
    }
}

impl std::error::Error for Problem {}
