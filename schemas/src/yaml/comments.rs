//! Finds comments, which the parser drops.

use super::{Node, parse_quietly};
use crate::diagnostic::{Place, Source};
use crate::form::Remark;

/// Most times that a document is read again to tell comments from texts.
const TRIES: usize = 64;

/// The comments of a document, in their order.
pub fn remarks(source: &Source) -> Vec<Remark> {
    let text = source.text();
    let marks = marks(text);
    let Some(value) = (!marks.is_empty()).then(|| value(text)).flatten() else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let mut left = TRIES;
    tell(text, &value, &marks, &mut left, &mut found);
    let remark = |at: usize| {
        let line = &text[..at];
        let line = &line[line.rfind(['\r', '\n']).map_or(0, |end| end + 1)..];
        Remark {
            start: u32::try_from(at).unwrap_or(u32::MAX),
            trails: !line.trim_start().is_empty(),
            text: text[at + 1..line_end(text, at)].to_owned(),
        }
    };
    found.into_iter().map(remark).collect()
}

/// The place of the first comment; nothing when there is none.
pub fn first_comment(source: &Source) -> Option<Place> {
    let start = usize::try_from(remarks(source).first()?.start).ok()?;
    Some(source.place(start, line_end(source.text(), start)))
}

/// What can be left out without a change of any value is a comment; in a text of several lines it is not. When it takes
/// too long to tell, everything is taken for a comment.
fn tell(text: &str, value: &Node, marks: &[usize], left: &mut usize, found: &mut Vec<usize>) {
    let spent = *left == 0;
    *left = left.saturating_sub(1);
    if spent || self::value(&without(text, marks)).as_ref() == Some(value) {
        found.extend(marks);
    } else if marks.len() > 1 {
        let (first, second) = marks.split_at(marks.len() / 2);
        tell(text, value, first, left, found);
        tell(text, value, second, left, found);
    }
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
