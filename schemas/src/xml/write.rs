//! Element tree → XML text, one element a line, so that two texts can be compared line by line.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};

/// An element to write: qualified names and attributes in the order in which they will stand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tag {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Tag>,
}

impl Tag {
    /// An element with nothing in it. `name` has its prefix (`rts:Components`).
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            attributes: Vec::new(),
            children: Vec::new(),
        }
    }

    /// With one attribute more. The value is escaped when it is written; line ends and tabs in it survive.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.attributes.push((name, value.into()));
        self
    }

    /// With one attribute more, if there is a value.
    #[must_use]
    pub fn with_some(self, name: &'static str, value: Option<impl Into<String>>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    /// With more elements at its end.
    #[must_use]
    pub fn holding(mut self, children: impl IntoIterator<Item = Tag>) -> Self {
        self.children.extend(children);
        self
    }
}

/// A whole document in UTF-8, indented by four blanks, with a line end at its end.
pub fn write(root: &Tag) -> String {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 4);
    let declaration = Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), Some("yes")));
    // Only the receiver of the bytes can fail, and a vector does not.
    let written = writer.write_event(declaration);
    let written = written.and_then(|()| element(&mut writer, root));
    debug_assert!(written.is_ok());
    let mut bytes = writer.into_inner();
    bytes.push(b'\n');
    String::from_utf8(bytes)
        .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned())
}

fn element(writer: &mut Writer<Vec<u8>>, tag: &Tag) -> std::io::Result<()> {
    let mut start = BytesStart::new(tag.name);
    for (name, value) in &tag.attributes {
        start.push_attribute((*name, value.as_str()));
    }
    if tag.children.is_empty() {
        return writer.write_event(Event::Empty(start));
    }
    writer.write_event(Event::Start(start))?;
    for child in &tag.children {
        element(writer, child)?;
    }
    writer.write_event(Event::End(BytesEnd::new(tag.name)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xml::parse;

    #[test]
    fn one_element_a_line() {
        let tag = Tag::new("a").with("k", "1").holding([
            Tag::new("b").with_some("x", Some("2")),
            Tag::new("b").with_some("x", None::<&str>),
        ]);
        let expected = "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n<a k=\"1\">\n    <b x=\"2\"/>\n    <b/>\n</a>\n";
        assert_eq!(write(&tag), expected);
    }

    #[test]
    fn every_value_is_read_as_it_was() {
        for value in [
            "",
            " ",
            "  a  b ",
            "<&>\"'",
            "a\nb\r\nc\td\r",
            "日本語 ①",
            "&amp;",
            "\u{85}\u{2028}\u{1f600}",
            // XML itself has no place for these: other programs refuse them, this one keeps them.
            "\u{0}\u{1}\u{3}\u{1b}\u{7f}\u{ffff}",
        ] {
            let text = write(&Tag::new("a").with("k", value));
            let root = parse(&text).unwrap();
            assert_eq!(root.attribute(&[""], "k").unwrap().value, value, "{text}");
        }
    }
}
