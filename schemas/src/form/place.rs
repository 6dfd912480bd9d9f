//! Which prefix stands for which namespace, where an element is written.

use std::sync::Arc;

use crate::span::Span;
use crate::xml::{Attribute, Element, Node};

/// Namespace of `xml:lang` and the like.
pub const XML_NAMESPACE: &str = "http://www.w3.org/XML/1998/namespace";
const XMLNS: &str = "http://www.w3.org/2000/xmlns/";

/// The declarations in force, the innermost last.
#[derive(Debug, Clone, Default)]
pub struct Scope {
    bound: Vec<(String, Arc<str>)>,
}

impl Scope {
    /// How many declarations there are, to go back to by [`Scope::leave`].
    pub fn depth(&self) -> usize {
        self.bound.len()
    }

    /// Forgets the declarations after the first `depth`.
    pub fn leave(&mut self, depth: usize) {
        self.bound.truncate(depth);
    }

    /// Notes the declarations among attributes.
    pub fn enter<'a>(&mut self, attributes: impl IntoIterator<Item = &'a Attribute>) {
        for attribute in attributes {
            if let Some(prefix) = declared_prefix(&attribute.qname) {
                self.declare(prefix, &attribute.value);
            }
        }
    }

    /// Notes a declaration.
    pub fn declare(&mut self, prefix: &str, namespace: &str) {
        self.bound.push((prefix.to_owned(), namespace.into()));
    }

    /// The namespace of a prefix; the empty prefix is that of elements without one.
    pub fn namespace(&self, prefix: &str) -> Option<&str> {
        let bound = self.bound.iter().rev().find(|(p, _)| p == prefix);
        match bound {
            Some((_, namespace)) => Some(namespace),
            None if prefix == "xml" => Some(XML_NAMESPACE),
            None if prefix.is_empty() => Some(""),
            None => None,
        }
    }

    /// A prefix of a namespace: the usual one if it is bound to it.
    pub fn prefix(&self, namespace: &str, usual: &str, attribute: bool) -> Option<&str> {
        if let Some((prefix, _)) = self.bound.iter().find(|(p, _)| p == usual)
            && self.namespace(usual) == Some(namespace)
        {
            return Some(prefix);
        }
        let mut bound = self.bound.iter().rev();
        bound
            .find(|(prefix, uri)| {
                **uri == *namespace
                    && !(attribute && prefix.is_empty())
                    && self.namespace(prefix) == Some(namespace)
            })
            .map(|(prefix, _)| prefix.as_str())
    }

    /// A prefix that is not bound here: the usual one, or one like it.
    pub fn free(&self, usual: &str) -> String {
        let taken = |prefix: &str| prefix.is_empty() || self.namespace(prefix).is_some();
        let mut prefix = usual.to_owned();
        let mut number = 1;
        while taken(&prefix) {
            prefix = format!("{}{number}", if usual.is_empty() { "ns" } else { usual });
            number += 1;
        }
        prefix
    }

    /// Declares on an element what its own name and attributes need, and so for all in it.
    pub fn complete(&mut self, element: &mut Element) {
        let depth = self.depth();
        self.enter(&element.attributes);
        let own = (
            prefix_of(&element.qname).to_owned(),
            Arc::clone(&element.namespace),
        );
        let others = element.attributes.iter().filter_map(|a| {
            let prefix = prefix_of(&a.qname);
            (!prefix.is_empty() && prefix != "xmlns")
                .then(|| (prefix.to_owned(), Arc::clone(&a.namespace)))
        });
        let needed: Vec<_> = std::iter::once(own).chain(others).collect();
        for (prefix, namespace) in needed {
            if self.namespace(&prefix) != Some(&namespace) {
                self.declare(&prefix, &namespace);
                element.attributes.push(declaration(&prefix, &namespace));
            }
        }
        for node in &mut element.children {
            if let Node::Element(child) = node {
                self.complete(child);
            }
        }
        self.leave(depth);
    }
}

/// `xmlns:prefix="namespace"`.
pub(super) fn declaration(prefix: &str, namespace: &str) -> Attribute {
    let qname = match prefix {
        "" => "xmlns".into(),
        prefix => format!("xmlns:{prefix}").into(),
    };
    Attribute {
        namespace: if prefix.is_empty() { "" } else { XMLNS }.into(),
        qname,
        value: namespace.into(),
        span: Span::default(),
    }
}

/// The prefix that an attribute declares.
pub(super) fn declared_prefix(qname: &str) -> Option<&str> {
    match qname.strip_prefix("xmlns")? {
        "" => Some(""),
        rest => rest.strip_prefix(':'),
    }
}

/// The part before the colon.
pub(super) fn prefix_of(qname: &str) -> &str {
    qname.split_once(':').map_or("", |(prefix, _)| prefix)
}
