//! What a request wants: all of its spec, or what its targets take of it.

use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::{Problem, ProblemError};
use rts_schemas::system::SystemSpec;
use rts_schemas::target;

use crate::store::SystemRecord;

/// The whole system as it is to be stored.
pub fn narrow(
    stored: Option<&SystemRecord>,
    request: &ApplyRequest,
) -> Result<SystemSpec, Problem> {
    if request.targets.is_empty() {
        return Ok(request.spec.clone());
    }
    let stored = stored.map(|record| record.spec.as_ref());
    target::narrow(stored, &request.spec, &request.targets).map_err(|unknown| {
        let target = request.targets.iter().position(|t| *t == unknown.target);
        let error = ProblemError {
            pointer: target.map_or_else(String::new, |i| format!("/targets/{i}")),
            code: "unknown-target".to_owned(),
            detail: unknown.to_string(),
            help: Some(unknown.help),
        };
        Problem::invalid("unknown-target", error.detail.clone()).with_errors(vec![error])
    })
}
