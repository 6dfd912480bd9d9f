//! Text that crosses the C ABI.

#![allow(unsafe_code)]

use rts_runtime::abi::Text;
use rts_schemas::names::is_hidden;

/// What is wrong with a text of a module.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextError {
    /// No address.
    #[error("its text is a null pointer")]
    Null,
    /// Longer than allowed there.
    #[error("its text of {0} bytes is longer than the limit of {1}")]
    TooLong(usize, usize),
    /// Not UTF-8.
    #[error("its text is not UTF-8")]
    NotUtf8,
}

/// Copies a text of at most `limit` bytes.
///
/// # Safety
/// When `text.data` is not null, `text.len` bytes must be readable there.
pub unsafe fn read(text: Text, limit: usize) -> Result<String, TextError> {
    if text.len > limit {
        return Err(TextError::TooLong(text.len, limit));
    }
    // SAFETY: the caller vouches for the address.
    let bytes = unsafe { bytes(text, limit) }.ok_or(TextError::Null)?;
    std::str::from_utf8(bytes)
        .map(str::to_owned)
        .map_err(|_| TextError::NotUtf8)
}

/// Copies the first `limit` bytes of a text and mends what is not UTF-8.
///
/// # Safety
/// As [`read`].
pub unsafe fn read_lossy(text: Text, limit: usize) -> String {
    let cut = Text {
        len: text.len.min(limit),
        ..text
    };
    // SAFETY: not longer than what the caller vouches for.
    let bytes = unsafe { bytes(cut, limit) }.unwrap_or_default();
    String::from_utf8_lossy(bytes).into_owned()
}

/// The bytes; none when there are more than `limit`, or when some are claimed at a null address.
///
/// # Safety
/// As [`read`]; they must stay readable for `'a`.
pub unsafe fn bytes<'a>(text: Text, limit: usize) -> Option<&'a [u8]> {
    if text.len == 0 {
        Some(&[])
    } else if text.data.is_null() || text.len > limit {
        None
    } else {
        // SAFETY: not null, bounded, and readable by the caller's word.
        Some(unsafe { std::slice::from_raw_parts(text.data, text.len) })
    }
}

/// A text of a component as one line that a terminal shows and does not obey: line ends and tabs are blanks, other hidden
/// characters are escaped.
pub fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for c in text.trim().chars() {
        match c {
            '\n' | '\r' | '\t' if line.ends_with(' ') => {}
            '\n' | '\r' | '\t' => line.push(' '),
            c if is_hidden(c) => line.extend(c.escape_unicode()),
            c => line.push(c),
        }
    }
    line
}

/// Lends a text to a module.
pub fn lend(text: &str) -> Text {
    Text {
        data: text.as_ptr(),
        len: text.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_of_a_component_is_one_line_without_commands_to_a_terminal() {
        let told = "RED\r\nFilter0 Active fake\r\u{1b}[31m a\t b \u{202e}c\n";
        let line = r"RED Filter0 Active fake \u{1b}[31m a  b \u{202e}c";
        assert_eq!(one_line(told), line);
        assert_eq!(one_line("モータが 熱い — 80 °C"), "モータが 熱い — 80 °C");
    }

    #[test]
    fn bad_texts_are_refused() {
        let null = Text {
            data: std::ptr::null(),
            len: 3,
        };
        let latin1 = Text {
            data: [0xe9].as_ptr(),
            len: 1,
        };
        // SAFETY: null is checked for; the others point to constants.
        unsafe {
            assert_eq!(read(lend("hello"), 5).unwrap(), "hello");
            assert_eq!(read(lend("hello"), 4), Err(TextError::TooLong(5, 4)));
            assert_eq!(read(null, 9), Err(TextError::Null));
            assert_eq!(read(latin1, 9), Err(TextError::NotUtf8));
            assert_eq!(read_lossy(latin1, 9), "\u{fffd}");
            assert_eq!(read_lossy(null, 9), "");
        }
    }
}
