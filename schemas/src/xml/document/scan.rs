//! Finds the elements and attributes of a text that is known to be well-formed.

use std::ops::Range;

/// An element and where its pieces stand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// From `<` to the last `>`.
    pub whole: Range<usize>,
    /// The name in the start tag.
    pub name: Range<usize>,
    /// The attributes, namespace declarations included.
    pub attributes: Vec<PartAttribute>,
    /// What is between the tags; `None` for `<a/>`.
    pub content: Option<Range<usize>>,
    /// The child elements.
    pub children: Vec<Part>,
}

/// An attribute and where its pieces stand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartAttribute {
    /// From the name to the closing quote.
    pub whole: Range<usize>,
    /// Between the quotes.
    pub value: Range<usize>,
    /// The quote.
    pub quote: char,
}

/// The root element.
pub(super) fn root(text: &str) -> Option<Part> {
    let mut open: Vec<Part> = Vec::new();
    let mut at = 0;
    loop {
        at += text.get(at..)?.find('<')?;
        let rest = &text[at..];
        if let Some(length) = skipped(rest) {
            at += length?;
        } else if rest.starts_with("</") {
            let end = at + rest.find('>')? + 1;
            let mut part = open.pop()?;
            if let Some(content) = &mut part.content {
                content.end = at;
            }
            part.whole.end = end;
            at = end;
            match open.last_mut() {
                Some(parent) => parent.children.push(part),
                None => return Some(part),
            }
        } else {
            let part = start_tag(text, at)?;
            at = part.whole.end;
            if part.content.is_some() {
                open.push(part);
                continue;
            }
            match open.last_mut() {
                Some(parent) => parent.children.push(part),
                None => return Some(part),
            }
        }
    }
}

/// Length of a comment, instruction or CDATA section; `Some(None)` when it has no end.
fn skipped(rest: &str) -> Option<Option<usize>> {
    let kinds = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
    let (start, end) = kinds
        .into_iter()
        .find(|(start, _)| rest.starts_with(start))?;
    let found = rest[start.len()..].find(end);
    Some(found.map(|at| start.len() + at + end.len()))
}

fn start_tag(text: &str, start: usize) -> Option<Part> {
    let blank = |c: char| matches!(c, ' ' | '\t' | '\r' | '\n');
    let name_end = start + 1 + text[start + 1..].find(|c| blank(c) || matches!(c, '/' | '>'))?;
    let mut part = Part {
        whole: start..start,
        name: start + 1..name_end,
        attributes: Vec::new(),
        content: None,
        children: Vec::new(),
    };
    let mut at = name_end;
    loop {
        let rest = &text[at..];
        at += rest.len() - rest.trim_start_matches(blank).len();
        let rest = &text[at..];
        if rest.starts_with("/>") {
            part.whole.end = at + 2;
            return Some(part);
        }
        if rest.starts_with('>') {
            part.whole.end = at + 1;
            part.content = Some(at + 1..at + 1);
            return Some(part);
        }
        let equals = at + rest.find('=')?;
        let after = &text[equals + 1..];
        let quote_at = equals + 1 + (after.len() - after.trim_start_matches(blank).len());
        let quote = text[quote_at..]
            .chars()
            .next()
            .filter(|c| matches!(c, '"' | '\''))?;
        let value_end = quote_at + 1 + text[quote_at + 1..].find(quote)?;
        part.attributes.push(PartAttribute {
            whole: at..value_end + 1,
            value: quote_at + 1..value_end,
            quote,
        });
        at = value_end + 1;
    }
}
