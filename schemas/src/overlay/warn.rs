//! What is understood, but not carried out.

use super::{DeploymentSpec, select};
use crate::placement;
use crate::yaml_type::Faults;

/// Says once for each line what this version only keeps.
pub(super) fn not_carried_out(said: &DeploymentSpec, faults: &mut Faults) {
    for settings in select::all_settings(said) {
        for (finding, span) in placement::later(settings) {
            faults.push(finding, span);
        }
    }
}
