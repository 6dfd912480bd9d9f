//! How many stand-ins a system may have.

use rts_controller_api::{Problem, ProblemError};

use super::check;
use crate::store::SystemRecord;

/// Refuses a system with more stand-ins than are allowed, and names them all.
pub fn within(record: &SystemRecord, most: Option<u32>) -> Result<(), Problem> {
    let stand_ins = &record.stand_ins;
    let allowed = most.and_then(|most| usize::try_from(most).ok());
    if allowed.is_none_or(|allowed| stand_ins.len() <= allowed) {
        return Ok(());
    }
    let errors: Vec<_> = stand_ins
        .keys()
        .map(|instance| ProblemError {
            pointer: check::pointer(&record.spec, instance),
            code: "too-many-stand-ins".to_owned(),
            detail: format!("{instance} would be a stand-in"),
            help: None,
        })
        .take(check::MAX_FAULTS)
        .collect();
    let detail = format!(
        "{} of {} components of system {} would be stand-ins, and at most {} may be",
        stand_ins.len(),
        record.spec.components.len(),
        record.name(),
        allowed.unwrap_or_default()
    );
    Err(Problem::invalid("too-many-stand-ins", detail).with_errors(errors))
}
