//! Finds comments, which the parser drops.

use super::{Node, parse_quietly};
use crate::diagnostic::{Place, Source};

/// Most comments that are tried one by one, each by reading the document again.
const TRIES: usize = 16;

/// The first comment of a document; nothing when it has none.
pub fn first_comment(source: &Source) -> Option<Place> {
    let text = source.text();
    let marks = marks(text);
    let first = *marks.first()?;
    let value = value(text)?;
    let place = |mark: usize| source.place(mark, line_end(text, mark));
    // What can be left out without a change of any value is a comment; in a text of several lines it is not.
    if self::value(&without(text, &marks)).as_ref() == Some(&value) || marks.len() > TRIES {
        return Some(place(first));
    }
    let is_comment =
        |mark: &&usize| self::value(&without(text, &[**mark])).as_ref() == Some(&value);
    marks.iter().find(is_comment).map(|mark| place(*mark))
}

/// What the text says, wherever it says it.
fn value(text: &str) -> Option<Node> {
    parse_quietly(text).map(Node::without_places)
}

fn without(text: &str, marks: &[usize]) -> String {
    let mut rest = String::with_capacity(text.len());
    let mut at = 0;
    for mark in marks {
        rest.push_str(&text[at..*mark]);
        at = line_end(text, *mark);
    }
    rest.push_str(&text[at..]);
    rest
}

fn line_end(text: &str, from: usize) -> usize {
    let rest = &text[from..];
    from + rest.find(['\r', '\n']).unwrap_or(rest.len())
}

/// Each `#` after a blank or at the start of a line that does not stand in a quoted text.
fn marks(text: &str) -> Vec<usize> {
    let bytes = text.as_bytes();
    let mut marks = Vec::new();
    // The quote that is open, and the last byte that is no blank.
    let (mut quote, mut last) = (None, b'\n');
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let before = at.checked_sub(1).map_or(b'\n', |before| bytes[before]);
        match (quote, byte) {
            (Some(b'"'), b'\\') => at += 1,
            (Some(open), _) if byte == open => quote = None,
            (Some(_), _) => {}
            (None, b'#') if matches!(before, b' ' | b'\t' | b'\r' | b'\n') => {
                marks.push(at);
                at = line_end(text, at);
                last = b'\n';
                continue;
            }
            (None, b'"' | b'\'')
                if matches!(last, b'\n' | b':' | b'-' | b',' | b'[' | b'{' | b'?') =>
            {
                quote = Some(byte);
            }
            _ => {}
        }
        if !matches!(byte, b' ' | b'\t') {
            last = if byte == b'\r' { b'\n' } else { byte };
        }
        at += 1;
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(text: &str) -> Option<(usize, usize)> {
        let place = first_comment(&Source::new("t.yaml", text))?;
        Some((place.line, place.column))
    }

    #[test]
    fn comments_are_told_from_texts() {
        assert_eq!(first("a: 1\n# x\nb: 2\n"), Some((2, 1)));
        assert_eq!(first("a: 1 # x\n"), Some((1, 6)));
        assert_eq!(first("a: 'it''s' # x\n"), Some((1, 12)));
        assert_eq!(first("a: it's # x\n"), Some((1, 9)));
        assert_eq!(first("a: |\n  # text\n  b\nc: 1 # x\n"), Some((4, 6)));
        for none in [
            "a: x#y\n",
            "a: \"x # y\"\n",
            "a: 'x # y'\nb: \"\\\" # \\\\\"\n",
            "a: |\n  # text\n  # more\n",
            "a: \"one\n  # two\"\n",
            "",
        ] {
            assert_eq!(first(none), None, "{none}");
        }
    }
}
