//! An XML file as it is, byte for byte, with the places of its elements and attributes, and edits in it.
//!
//! What no edit touches stays as it was: declaration, comments, blanks, quotes, entities, line ends, encoding.

mod encode;
mod scan;

pub use scan::{Part, PartAttribute};

use std::ops::Range;

use crate::diagnostic::{Finding, Source};
use crate::xml;
use encode::Bytes;

/// An XML file and where everything in it stands.
#[derive(Debug, Clone)]
pub struct Document {
    text: String,
    root: Part,
    bytes: Bytes,
    line_end: &'static str,
}

/// What an edit puts in the place of a range of the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edit {
    /// What is replaced; an empty range is a place to insert at.
    pub range: Range<usize>,
    /// What stands there then.
    pub text: String,
}

/// Why a document cannot be edited.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// Two edits touch the same text.
    #[error("two edits touch the same text at byte {0}")]
    Overlap(usize),
    /// The edited text is no XML.
    #[error("the edited text is not well-formed: {0}")]
    Malformed(String),
    /// Some bytes mean the same text as others, so what no edit touches would change.
    #[error("the file cannot be written in {0} without changing what was not edited")]
    Encoding(&'static str),
    /// The form was not read from this document.
    #[error("the form was not read from this document: {0}")]
    Stranger(String),
    /// Reading the edited text does not give the form.
    #[error("the form cannot be written into this document")]
    Unfaithful,
}

impl Document {
    /// Opens a file.
    ///
    /// # Errors
    /// What stops it from being read as XML.
    pub fn open(file_name: &str, bytes: &[u8]) -> Result<Self, Box<Finding>> {
        let decoded = xml::decode(file_name, bytes)?;
        let source = Source::new(file_name, decoded.text);
        let broken = |error: xml::XmlError| Box::new(error.finding(&source));
        xml::parse_tree(source.text()).map_err(broken)?;
        let text = source.text().to_owned();
        let Some(root) = scan::root(&text) else {
            let message = format!("the elements of {file_name} cannot be told apart");
            let help = "save it anew with its editor";
            return Err(Box::new(
                Finding::error("malformed-xml", message).help(help),
            ));
        };
        Ok(Self {
            bytes: Bytes::of(bytes, decoded.encoding),
            line_end: line_end(&text),
            text,
            root,
        })
    }

    /// The decoded text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The root element.
    pub fn root(&self) -> &Part {
        &self.root
    }

    /// The file: the very bytes it was read from, unless it was edited.
    ///
    /// # Errors
    /// [`EditError::Encoding`] after an edit, when the rest would not come out as it was.
    pub fn bytes(&self) -> Result<Vec<u8>, EditError> {
        self.bytes.of_text(&self.text)
    }

    /// The document after edits, in any order.
    ///
    /// # Errors
    /// When edits touch the same text, or their result is no XML.
    pub fn edited(&self, mut edits: Vec<Edit>) -> Result<Self, EditError> {
        edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
        let mut text = String::with_capacity(self.text.len());
        let mut at = 0;
        for edit in &edits {
            let kept = self.text.get(at..edit.range.start);
            text.push_str(kept.ok_or(EditError::Overlap(edit.range.start))?);
            text.push_str(&edit.text);
            at = edit.range.end;
        }
        text.push_str(self.text.get(at..).ok_or(EditError::Overlap(at))?);
        xml::parse_tree(&text).map_err(|error| EditError::Malformed(error.to_string()))?;
        let root = scan::root(&text).ok_or_else(|| EditError::Malformed(String::new()))?;
        Ok(Self {
            text,
            root,
            bytes: self.bytes.clone(),
            line_end: self.line_end,
        })
    }

    /// The line end of this file.
    pub fn line_end(&self) -> &'static str {
        self.line_end
    }

    /// The blanks before a place in its line, when there is nothing else before it.
    pub fn indent(&self, at: usize) -> Option<&str> {
        let before = &self.text[..at];
        let rest = before.trim_end_matches([' ', '\t']);
        (rest.is_empty() || rest.ends_with('\n')).then(|| &before[rest.len()..])
    }

    /// How much deeper a child stands than its parent: as the first child of the root, else four blanks.
    pub fn indent_step(&self) -> &str {
        let first = self.root.children.first();
        let step = first.and_then(|child| {
            let outer = self.indent(self.root.whole.start)?;
            self.indent(child.whole.start)?.strip_prefix(outer)
        });
        step.filter(|step| !step.is_empty()).unwrap_or("    ")
    }

    /// A range with its whole lines, when there is nothing else in them.
    pub fn with_lines(&self, range: Range<usize>) -> Range<usize> {
        let Some(indent) = self.indent(range.start) else {
            return range;
        };
        let rest = &self.text[range.end..];
        let blanks = rest.len() - rest.trim_start_matches([' ', '\t', '\r']).len();
        if rest[blanks..].starts_with('\n') {
            range.start - indent.len()..range.end + blanks + 1
        } else {
            range
        }
    }
}

/// The first line end of a text; `\n` where there is none.
fn line_end(text: &str) -> &'static str {
    match text.find('\n') {
        Some(at) if at > 0 && text.as_bytes()[at - 1] == b'\r' => "\r\n",
        _ => "\n",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(text: &str) -> Document {
        Document::open("t.xml", text.as_bytes()).unwrap()
    }

    #[test]
    fn everything_has_its_place() {
        let text = "<?xml version='1.0'?>\n<!-- <x> -->\n<a k = 'v>' j=\"\">\r\n  <![CDATA[<z>]]><b/>t</a >\n";
        let document = open(text);
        let root = document.root();
        let at = |range: &Range<usize>| &text[range.clone()];
        assert_eq!(
            at(&root.whole),
            "<a k = 'v>' j=\"\">\r\n  <![CDATA[<z>]]><b/>t</a >"
        );
        assert_eq!(at(&root.name), "a");
        let attributes: Vec<_> = root.attributes.iter().map(|a| at(&a.whole)).collect();
        assert_eq!(attributes, ["k = 'v>'", "j=\"\""]);
        assert_eq!(at(&root.attributes[0].value), "v>");
        assert_eq!(at(&root.children[0].whole), "<b/>");
        assert_eq!(root.children[0].content, None);
        assert_eq!(document.bytes().unwrap(), text.as_bytes());
        assert_eq!(document.line_end(), "\n");
    }

    #[test]
    fn edits_touch_nothing_else() {
        let document = open("<a>\n  <b/>\n  <c/>\n</a>\n");
        let b = document.root().children[0].whole.clone();
        let gone = Edit {
            range: document.with_lines(b.clone()),
            text: String::new(),
        };
        let edited = document.edited(vec![gone.clone()]).unwrap();
        assert_eq!(edited.text(), "<a>\n  <c/>\n</a>\n");
        let again = Edit {
            range: b,
            text: "<d/>".to_owned(),
        };
        let error = document.edited(vec![gone, again]).unwrap_err();
        assert!(matches!(error, EditError::Overlap(_)), "{error}");
        let broken = Edit {
            range: 0..1,
            text: String::new(),
        };
        let error = document.edited(vec![broken]).unwrap_err();
        assert!(matches!(error, EditError::Malformed(_)), "{error}");
    }

    #[test]
    fn every_encoding_comes_out_again() {
        let text = "<a k=\"日本\">\r\n</a>";
        let edit = |document: &Document| {
            let value = document.root().attributes[0].value.clone();
            let edit = Edit {
                range: value,
                text: "語€".to_owned(),
            };
            document.edited(vec![edit]).unwrap().bytes().unwrap()
        };
        let utf16 = |text: &str| -> Vec<u8> {
            let units = std::iter::once(0xfeff).chain(text.encode_utf16());
            units.flat_map(u16::to_be_bytes).collect()
        };
        let document = Document::open("t.xml", &utf16(text)).unwrap();
        assert_eq!(document.bytes().unwrap(), utf16(text));
        assert_eq!(edit(&document), utf16("<a k=\"語€\">\r\n</a>"));
        let declared = format!("<?xml version=\"1.0\" encoding=\"Shift_JIS\"?>{text}");
        let bytes = encoding_rs::SHIFT_JIS.encode(&declared).0.into_owned();
        let document = Document::open("t.xml", &bytes).unwrap();
        assert_eq!(document.bytes().unwrap(), bytes);
        // What the encoding has no letter for is written by its number.
        let edited = edit(&document);
        let (text, ..) = encoding_rs::SHIFT_JIS.decode(&edited);
        assert!(text.contains("<a k=\"語&#8364;\">"), "{text}");
    }
}
