//! Codes of reading any file: encoding, XML, YAML.

use super::Code;

pub(super) const CODES: &[Code] = &[];
