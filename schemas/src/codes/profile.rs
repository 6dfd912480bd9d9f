//! Codes of RTS Profiles.

use super::Code;

pub(super) const CODES: &[Code] = &[];
