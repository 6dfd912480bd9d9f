//! What managers answer, in the words of the agent's API.

use rts_agent_api::messages::Factory;
use rts_http::problem::Problem;
use rts_manager_api::control::{Failure, FailureCode, ModuleInfo};

use crate::execute::StepError;
use crate::manager_link::LinkError;
use crate::modules::ModuleError;

pub(super) fn factory(module: ModuleInfo) -> Factory {
    Factory {
        type_name: module.type_name,
        vendor: module.vendor,
        category: module.category,
        version: module.version,
        description: module.description,
        path: module.path,
        ports: module
            .ports
            .into_iter()
            .map(|p| format!("{}:{}:{}", p.name, p.direction, p.data_type))
            .collect(),
        parameters: module.parameters,
    }
}

pub(super) fn module(error: ModuleError) -> Problem {
    match error {
        ModuleError::NotFound { .. } => Problem::new(
            404,
            "module-not-found",
            "module not found",
            error.to_string(),
        ),
        _ => Problem::internal(error.to_string()),
    }
}

pub(super) fn link(error: LinkError) -> Problem {
    step(StepError::from(error))
}

pub(crate) fn step(error: StepError) -> Problem {
    let detail = error.to_string();
    if matches!(error, StepError::Peer { .. }) {
        return Problem::new(502, "peer-failed", "bad gateway", detail);
    }
    match error.failure() {
        None => Problem::unavailable("manager-silent", detail),
        Some(failure) => of(failure.code, detail),
    }
}

/// What a manager refused.
pub(crate) fn refused(failure: Failure) -> Problem {
    of(failure.code, failure.message)
}

fn of(code: FailureCode, detail: String) -> Problem {
    match code {
        FailureCode::NotFound => Problem::not_found(detail),
        FailureCode::Conflict => Problem::conflict("manager-conflict", detail),
        FailureCode::Invalid => Problem::invalid("manager-invalid", detail),
        FailureCode::LoadFailed => Problem::invalid("load-failed", detail),
        FailureCode::ComponentFailed => Problem::invalid("component-failed", detail),
        FailureCode::PeerFailed => Problem::new(502, "peer-failed", "bad gateway", detail),
        FailureCode::Deadline => Problem::new(504, "deadline", "too late", detail),
        FailureCode::Internal => Problem::internal(detail),
    }
}
