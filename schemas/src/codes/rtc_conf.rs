//! Codes of `rtc.conf` files.

use super::Code;

pub(super) const CODES: &[Code] = &[];
