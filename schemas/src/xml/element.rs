//! The tree that the reader makes.

use std::sync::Arc;

use crate::span::{Span, Text};

/// A document: its root element, and the comments and instructions around it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tree {
    /// Before the root.
    pub before: Vec<Node>,
    /// The root element.
    pub root: Element,
    /// After the root.
    pub after: Vec<Node>,
}

/// An element with everything in it, in the order of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// Namespace URI; empty when there is none.
    pub namespace: Arc<str>,
    /// Name as written.
    pub qname: Box<str>,
    /// Attributes, namespace declarations included.
    pub attributes: Vec<Attribute>,
    /// Elements, texts and comments.
    pub children: Vec<Node>,
    /// The start tag (its first line).
    pub span: Span,
}

/// An attribute.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attribute {
    /// Namespace URI; empty when there is none.
    pub namespace: Arc<str>,
    /// Name as written.
    pub qname: Box<str>,
    /// Value, unescaped.
    pub value: Box<str>,
    /// The value between its quotes; the element's start tag when it is empty.
    pub span: Span,
}

/// What an element contains.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Node {
    /// An element.
    Element(Box<Element>),
    /// Text, references resolved.
    Text(Box<str>),
    /// A comment.
    Comment(Box<str>),
    /// A processing instruction, without its `<?` and `?>`.
    Instruction(Box<str>),
}

/// The part of a name after the colon.
fn local(qname: &str) -> &str {
    qname.split_once(':').map_or(qname, |(_, local)| local)
}

impl Attribute {
    /// Name without prefix.
    pub fn local(&self) -> &str {
        local(&self.qname)
    }
}

impl Element {
    /// Name without prefix.
    pub fn local(&self) -> &str {
        local(&self.qname)
    }

    /// Whether blanks between its children count (`xml:space`); nothing when it does not say.
    pub fn preserves_blanks(&self) -> Option<bool> {
        let said = self.attributes.iter().find(|a| &*a.qname == "xml:space");
        said.map(|attribute| &*attribute.value == "preserve")
    }

    /// The child elements.
    pub fn elements(&self) -> impl Iterator<Item = &Element> {
        self.children.iter().filter_map(|node| match node {
            Node::Element(element) => Some(&**element),
            Node::Text(_) | Node::Comment(_) | Node::Instruction(_) => None,
        })
    }

    /// The value of the attribute with this local name in one of the namespaces.
    pub fn attribute(&self, namespaces: &[&str], local: &str) -> Option<Text> {
        self.attributes
            .iter()
            .find(|a| a.local() == local && namespaces.contains(&&*a.namespace))
            .map(|a| Text::new(&*a.value, a.span))
    }
}
