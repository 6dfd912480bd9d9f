//! Bytes → text. Comments may be in Japanese, in any of its encodings.

use super::limits;
use crate::diagnostic::{Finding, Source};
use crate::rtc_conf::text;

/// The text of a file.
pub(super) fn decode(name: &str, bytes: &[u8]) -> Result<String, Box<Finding>> {
    if bytes.len() > limits::FILE {
        let message = format!(
            "{name} has {} bytes; at most {} are read",
            bytes.len(),
            limits::FILE
        );
        return Err(Box::new(
            Finding::error("too-large", message).help("is this the right file?"),
        ));
    }
    let decoded = text(bytes).map(|(text, _)| match text.contains('\n') {
        true => text,
        // Lines as old Macintoshes end them.
        false => text.replace('\r', "\n"),
    });
    decoded.ok_or_else(|| {
        let valid = String::from_utf8_lossy(bytes);
        let at = valid.find([char::REPLACEMENT_CHARACTER, '\0']).unwrap_or(0);
        let place = Source::new(name, valid.as_ref()).place(at, at + 1);
        let message = format!("{name} is no text, so it is no IDL file");
        let help = "it must be text in UTF-8, Shift_JIS or EUC-JP";
        Box::new(
            Finding::error("idl-not-text", message)
                .at(Some(place))
                .help(help),
        )
    })
}
