//! What `rtsctl export` writes is the system that runs.

use jiff::Timestamp;
use rts_controller_api::requests::ApplyRequest;
use rts_schemas::diagnostic;
use rts_schemas::rts_profile;

use super::context::Context;
use super::failure::{Failure, Verdict};
use crate::commands::export::profile;
use crate::error::CliError;
use crate::show::plan::{View, text};

/// Name of the file that is not written.
const FILE: &str = "export.xml";

/// Exports, reads it again, and plans it.
pub async fn check(context: &mut Context<'_>) -> Verdict {
    let controller = context.controller()?;
    let name = context.name();
    let exported = controller.export(name).await;
    let exported = exported.map_err(CliError::request(format!("export system/{name}")))?;
    let written = profile(&exported.spec, Timestamp::now(), Timestamp::now());
    let read = rts_profile::load(FILE, written.as_bytes(), Some(name), &[]);
    let (spec, _) = read.map_err(|report| {
        let mut failure = Failure::new("what is exported cannot be read");
        failure.details = report.findings.iter().map(diagnostic::render).collect();
        failure
    })?;
    let planned = controller.plan(&ApplyRequest::of(spec)).await;
    let planned = planned.map_err(CliError::request("plan what was exported"))?;
    if planned.plan.is_empty() {
        return Ok("what is exported is what runs".to_owned());
    }
    let mut failure = Failure::new("what is exported would change what runs");
    let plan = text(&planned.plan, View::Lines, false);
    failure.details.extend(plan.lines().map(str::to_owned));
    Err(failure)
}
