//! Codes of deployment overlays.

use super::Code;

pub(super) const CODES: &[Code] = &[];
