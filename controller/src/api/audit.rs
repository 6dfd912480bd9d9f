//! One log line for each request that changes something: who, what.

use rts_http::server::Principal;

/// Writes the line of something that has ended, with how it ended.
pub fn ended(principal: &Principal, verb: &str, object: &str, outcome: &str) {
    tracing::info!(
        target: "audit",
        uid = principal.uid,
        pid = principal.pid,
        verb,
        object,
        outcome,
    );
}

/// Writes the line.
pub fn audit(principal: &Principal, verb: &str, object: &str) {
    tracing::info!(
        target: "audit",
        uid = principal.uid,
        pid = principal.pid,
        verb,
        object,
    );
}
