//! Text across the C ABI.

#![allow(unsafe_code)]

use crate::abi::Text;

/// Lends a text to the other side.
pub(crate) fn lend(text: &str) -> Text {
    Text {
        data: text.as_ptr(),
        len: text.len(),
    }
}

/// Reads a text of the other side; bytes that are not UTF-8 are replaced, as it may be written in another language.
///
/// # Safety
/// `text` must be as [`Text`] says for the time of the call.
pub(crate) unsafe fn read(text: Text) -> String {
    // SAFETY: the caller vouches for the text.
    String::from_utf8_lossy(unsafe { bytes(text) }).into_owned()
}

/// The bytes of a text of the other side.
///
/// # Safety
/// `text` must be as [`Text`] says for the time that the result is used.
pub(crate) unsafe fn bytes<'a>(text: Text) -> &'a [u8] {
    if text.len == 0 || text.data.is_null() {
        return &[];
    }
    // SAFETY: not null and not empty, and the caller vouches for the rest.
    unsafe { std::slice::from_raw_parts(text.data, text.len) }
}
