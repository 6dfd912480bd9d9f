//! Codes that the planner finds.

use super::Code;

pub(super) const CODES: &[Code] = &[];
