//! XML text → element tree with byte places, and back. The one module that names quick-xml.
//!
//! Namespaces are resolved, comments and order are kept. A DTD is refused (no entity can grow), depth and size are
//! bounded, so that a hostile file costs no more than its size.

mod decode;
pub mod document;
mod element;
mod print;
mod write;

pub use decode::{Decoded, SIZE_LIMIT, decode};
pub use document::Document;
pub use element::{Attribute, Element, Node, Tree};
pub use print::{escape_attribute, escape_text, print, print_element};
pub use write::{Tag, write};

use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::Arc;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::name::ResolveResult;
use quick_xml::reader::NsReader;

use crate::diagnostic::{Finding, Source};
use crate::span::Span;

/// Deepest nesting of elements that is read.
pub const DEPTH_LIMIT: usize = 128;

/// Most attributes of one element that are read.
pub const ATTRIBUTE_LIMIT: usize = 512;

/// Longest namespace name that is read, in bytes: every element of the namespace is compared with it.
pub const NAMESPACE_LIMIT: usize = 1024;

/// What stops a file from being XML.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct XmlError {
    /// Stable code of the finding.
    pub code: &'static str,
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    pub help: Option<String>,
    /// Where, in bytes of the decoded text.
    pub span: Span,
}

impl XmlError {
    fn malformed(message: impl Into<String>, span: Span) -> Self {
        Self {
            code: "malformed-xml",
            message: message.into(),
            help: None,
            span,
        }
    }

    /// The same as a finding.
    pub fn finding(&self, source: &Source) -> Finding {
        let finding = Finding::error(self.code, self.message.clone())
            .at(Some(source.place(self.span.start, self.span.end)));
        let help = self.help.as_deref();
        finding.help(help.unwrap_or("look for quotes and tags that are not closed, and for `<` and `&` in texts, which are written `&lt;` and `&amp;`"))
    }
}

/// Reads the root element of a decoded text.
///
/// # Errors
/// As [`parse_tree`].
pub fn parse(text: &str) -> Result<Element, XmlError> {
    parse_tree(text).map(|tree| tree.root)
}

/// Reads a decoded text: the root element, and what stands before and after it.
///
/// # Errors
/// The first thing that is not well-formed, with its place: after it nothing in the text can be trusted.
pub fn parse_tree(text: &str) -> Result<Tree, XmlError> {
    let mut reader = NsReader::from_str(text);
    reader.config_mut().check_end_names = true;
    let mut tree = Builder::default();
    loop {
        let at = offset(reader.buffer_position(), text);
        let event = match reader.read_event() {
            Ok(event) => event,
            Err(error) => return Err(tree.broken(&reader, &error, text)),
        };
        let end = offset(reader.buffer_position(), text);
        let span = Span::new(at, end);
        match event {
            Event::Start(start) => {
                let element = element(text, &reader, &start, span, &mut tree.names)?;
                tree.open(element)?;
            }
            Event::Empty(start) => {
                let element = element(text, &reader, &start, span, &mut tree.names)?;
                tree.open(element)?;
                tree.close();
            }
            Event::End(_) => tree.close(),
            Event::Text(piece) => tree.text(&piece.xml10_content(), span)?,
            Event::CData(piece) => tree.text(&piece.xml10_content(), span)?,
            Event::GeneralRef(name) => tree.text(&resolve(&name, span)?, span)?,
            Event::Comment(comment) => {
                tree.push(Node::Comment(comment.xml10_content().into()));
            }
            Event::DocType(_) => return Err(dtd_refused(span)),
            Event::PI(pi) => tree.push(Node::Instruction(line_ends(&pi))),
            Event::Decl(_) => {}
            Event::Eof => break,
        }
    }
    tree.finish(text)
}

/// Elements that are still open, and the root once it is closed.
#[derive(Default)]
struct Builder {
    open: Vec<Element>,
    /// Text that may go on.
    pending: String,
    root: Option<Element>,
    before: Vec<Node>,
    after: Vec<Node>,
    names: HashSet<Arc<str>>,
}

impl Builder {
    /// What the parser says, and which element was open there.
    fn broken(&self, reader: &NsReader<&[u8]>, error: &quick_xml::Error, text: &str) -> XmlError {
        let from = offset(reader.error_position(), text);
        let to = offset(reader.buffer_position(), text).max(from + 1);
        let span = Span::new(from, first_line(text, from, to));
        let mut broken = XmlError::malformed(error.to_string(), span);
        broken.help = self.open.last().map(|open| {
            let line = text[..open.span.range().start].matches('\n').count() + 1;
            format!(
                "the innermost open element is `<{}>` of line {line}",
                open.qname
            )
        });
        broken
    }

    fn open(&mut self, element: Element) -> Result<(), XmlError> {
        if self.open.is_empty() && self.root.is_some() {
            let message = format!(
                "`<{}>` stands after the end of the root element",
                element.qname
            );
            return Err(XmlError::malformed(message, element.span));
        }
        if self.open.len() >= DEPTH_LIMIT {
            return Err(XmlError {
                code: "too-deep",
                message: format!("elements are nested deeper than {DEPTH_LIMIT}"),
                help: Some(
                    "a profile needs fewer than ten levels: is this the right file?".to_owned(),
                ),
                span: element.span,
            });
        }
        self.flush();
        self.open.push(element);
        Ok(())
    }

    fn close(&mut self) {
        self.flush();
        if let Some(mut element) = self.open.pop() {
            element.children.shrink_to_fit();
            match self.open.last_mut() {
                Some(parent) => parent.children.push(Node::Element(Box::new(element))),
                None => self.root = Some(element),
            }
        }
    }

    fn flush(&mut self) {
        if let Some(parent) = self.open.last_mut()
            && !self.pending.is_empty()
        {
            parent
                .children
                .push(Node::Text(self.pending.as_str().into()));
            self.pending.clear();
        }
    }

    fn push(&mut self, node: Node) {
        self.flush();
        match self.open.last_mut() {
            Some(parent) => parent.children.push(node),
            None if self.root.is_none() => self.before.push(node),
            None => self.after.push(node),
        }
    }

    fn text(&mut self, piece: &str, span: Span) -> Result<(), XmlError> {
        if self.open.is_empty() {
            let blank = piece.trim().trim_matches(['\0', '\u{feff}']).is_empty();
            return if blank {
                Ok(())
            } else {
                Err(XmlError::malformed(
                    "there is text outside the root element",
                    span,
                ))
            };
        }
        self.pending.push_str(piece);
        Ok(())
    }

    fn finish(self, text: &str) -> Result<Tree, XmlError> {
        if let Some(open) = self.open.last() {
            let message = format!("`<{}>` is never closed", open.qname);
            let mut error = XmlError::malformed(message, open.span);
            error.help = Some("the file ends too early: was it cut off?".to_owned());
            return Err(error);
        }
        let root = self.root.ok_or_else(|| {
            XmlError::malformed("there is no element", Span::new(0, text.len().min(1)))
        })?;
        Ok(Tree {
            before: self.before,
            root,
            after: self.after,
        })
    }
}

fn element(
    text: &str,
    reader: &NsReader<&[u8]>,
    start: &BytesStart<'_>,
    span: Span,
    names: &mut HashSet<Arc<str>>,
) -> Result<Element, XmlError> {
    let (namespace, _) = reader.resolver().resolve_element(start.name());
    let std::ops::Range {
        start: start_at,
        end,
    } = span.range();
    let mut element = Element {
        namespace: bound(namespace, span, names)?,
        qname: start.name().into_inner().into(),
        attributes: Vec::new(),
        children: Vec::new(),
        span: Span::new(start_at, first_line(text, start_at, end)),
    };
    for attribute in start.attributes() {
        if element.attributes.len() >= ATTRIBUTE_LIMIT {
            return Err(XmlError {
                code: "too-many-attributes",
                message: format!("an element has more than {ATTRIBUTE_LIMIT} attributes"),
                help: Some("is this the right file?".to_owned()),
                span: element.span,
            });
        }
        let attribute =
            attribute.map_err(|error| XmlError::malformed(error.to_string(), element.span))?;
        let place = inside(text, &attribute.value).unwrap_or(element.span);
        let value = attribute
            .normalized_value(XmlVersion::Implicit1_0)
            .map_err(|error| XmlError::malformed(error.to_string(), place))?;
        let (namespace, _) = reader.resolver().resolve_attribute(attribute.key);
        element.attributes.push(Attribute {
            namespace: bound(namespace, place, names)?,
            qname: attribute.key.into_inner().into(),
            value: value.into(),
            span: place,
        });
    }
    element.attributes.shrink_to_fit();
    Ok(element)
}

fn bound(
    result: ResolveResult<'_>,
    span: Span,
    names: &mut HashSet<Arc<str>>,
) -> Result<Arc<str>, XmlError> {
    let name = match &result {
        ResolveResult::Bound(namespace) => unescaped(namespace.0, span)?,
        _ => Cow::Borrowed(""),
    };
    let name = &*name;
    match result {
        _ if name.len() > NAMESPACE_LIMIT => Err(XmlError {
            code: "too-long",
            message: format!("the name of a namespace has more than {NAMESPACE_LIMIT} bytes"),
            help: Some("is this the right file?".to_owned()),
            span,
        }),
        // Thousands of elements share one name.
        ResolveResult::Bound(_) | ResolveResult::Unbound => {
            Ok(names.get(name).cloned().unwrap_or_else(|| {
                let name: Arc<str> = name.into();
                names.insert(Arc::clone(&name));
                name
            }))
        }
        ResolveResult::Unknown(prefix) => {
            let message = format!("the prefix `{prefix}:` is not declared");
            let mut error = XmlError::malformed(message, span);
            error.help =
                Some("declare it on the root element with `xmlns:PREFIX=\"…\"`".to_owned());
            Err(error)
        }
    }
}

/// Line ends as XML has them, whatever the file has.
fn line_ends(text: &str) -> Box<str> {
    match text.contains('\r') {
        true => text.replace("\r\n", "\n").replace('\r', "\n").into(),
        false => text.into(),
    }
}

/// True for a text of nothing but what XML calls blanks: others, as the wide one of Japanese, are letters to it.
pub fn is_blank(text: &str) -> bool {
    text.bytes()
        .all(|byte| matches!(byte, b' ' | b'\t' | b'\r' | b'\n'))
}

/// The name of a namespace is the value of an attribute, but comes as it is written.
fn unescaped(raw: &str, span: Span) -> Result<Cow<'_, str>, XmlError> {
    // Each element and attribute comes here: bytes are looked through faster than characters.
    let changes = |byte| matches!(byte, b'&' | b'\t' | b'\r' | b'\n');
    if !raw.bytes().any(changes) {
        return Ok(Cow::Borrowed(raw));
    }
    let line = raw.replace("\r\n", " ").replace(['\t', '\r', '\n'], " ");
    quick_xml::escape::unescape(&line)
        .map(|text| Cow::Owned(text.into_owned()))
        .map_err(|error| XmlError::malformed(error.to_string(), span))
}

/// The text of `&name;`: the five of XML, and characters by number.
fn resolve(name: &str, span: Span) -> Result<String, XmlError> {
    quick_xml::escape::unescape(&format!("&{name};"))
        .map(|text| text.into_owned())
        .map_err(|error| XmlError::malformed(error.to_string(), span))
}

fn dtd_refused(span: Span) -> XmlError {
    XmlError {
        code: "dtd-refused",
        message: "a document type declaration is not read".to_owned(),
        help: Some("remove `<!DOCTYPE …>`; profiles have no use for it".to_owned()),
        span,
    }
}

/// The range of `part` in `text`, when it borrows from it.
fn inside(text: &str, part: &str) -> Option<Span> {
    let start = part.as_ptr().addr().checked_sub(text.as_ptr().addr())?;
    let end = start.checked_add(part.len())?;
    (end <= text.len() && !part.is_empty()).then(|| Span::new(start, end))
}

fn offset(position: u64, text: &str) -> usize {
    usize::try_from(position).map_or(text.len(), |at| at.min(text.len()))
}

/// Cuts a range at the end of its first line, where a finding can still underline it.
fn first_line(text: &str, start: usize, end: usize) -> usize {
    let (start, end) = (
        text.floor_char_boundary(start),
        text.floor_char_boundary(end.min(text.len())),
    );
    let ends = |byte| matches!(byte, b'\r' | b'\n');
    let piece = text.get(start..end);
    match piece.and_then(|piece| piece.bytes().position(ends)) {
        Some(length) if length > 0 => start + length,
        _ => end,
    }
}

#[cfg(test)]
mod tests;
