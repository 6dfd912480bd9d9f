//! Texts of the far side, made fit to be shown: nothing of them can move a cursor, and they are not long.

/// Most characters of a text that are shown.
const SHOWN: usize = 2000;

/// The text without control characters, its lines joined by `; `, at most [`SHOWN`] characters.
pub(crate) fn tame(text: &str) -> String {
    let lines = text.lines().map(|line| {
        let clean = line.chars().map(|c| if c == '\t' { ' ' } else { c });
        let clean: String = clean
            .filter(|c| !c.is_control() && !is_hidden(*c))
            .collect();
        clean.trim().to_owned()
    });
    let lines: Vec<_> = lines.filter(|line| !line.is_empty()).collect();
    let text = lines.join("; ");
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// Characters that turn the direction of what follows, or are not seen.
fn is_hidden(c: char) -> bool {
    matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// What follows the line that ends with the mark: what a shell's start-up files printed before is left out.
pub(crate) fn after_mark<'a>(text: &'a [u8], mark: &str) -> Option<&'a [u8]> {
    let mark = format!("{mark}\n");
    let at = text
        .windows(mark.len())
        .position(|part| part == mark.as_bytes())?;
    text.get(at + mark.len()..)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_the_far_side_moves_the_cursor() {
        assert_eq!(tame("a\u{1b}[2Jb\r\n\n c\td\u{202e}\n"), "a[2Jb; c d");
        let long = tame(&"x".repeat(3 * SHOWN));
        assert_eq!(long.chars().count(), SHOWN + 1);
    }

    #[test]
    fn what_is_printed_before_the_mark_is_left_out() {
        assert_eq!(after_mark(b"hello\nyou m1\nrest", "m1"), Some(&b"rest"[..]));
        assert_eq!(after_mark(b"m1\n", "m1"), Some(&b""[..]));
        assert_eq!(after_mark(b"m1", "m1"), None);
    }
}
