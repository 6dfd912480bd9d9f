//! A plan as the document that scripts may rely on.

use rts_controller_api::requests::PlanResult;
use rts_plan::render::{Counts, details};
use serde_json::{Value, json};

/// What is said of the system beyond the plan's own notes.
pub(super) fn remarks(result: &PlanResult) -> impl Iterator<Item = &String> {
    let own = &result.plan.notes;
    result.notes.iter().filter(move |note| !own.contains(note))
}

/// `changes`, `steps`, `restarts`, `waitingOn`, `drift`, `notes`, `criticalPath`: the plan's, with the fields of what is
/// added, and the remarks about the system among the notes. `index` and `digest` name it; `summary` counts its changes.
pub(super) fn of(result: &PlanResult) -> Value {
    let mut plan = result.plan.clone();
    plan.changes = details(&plan);
    plan.notes.splice(0..0, remarks(result).cloned());
    let counts = Counts::of(&plan);
    let mut document = json!(plan);
    document["index"] = json!(result.index);
    document["digest"] = json!(result.digest);
    document["summary"] = json!(counts);
    document
}
