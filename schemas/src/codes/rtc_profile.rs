//! Codes of RTC Profiles, and of an RTS Profile held against them.

use super::Code;

pub(super) const CODES: &[Code] = &[];
