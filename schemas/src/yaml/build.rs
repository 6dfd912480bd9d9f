//! Events → tree: nesting, keys, aliases, and how much all of it may cost.

use std::collections::HashMap;

use super::{DEPTH_LIMIT, Node, Value};
use crate::diagnostic::{Finding, Source};
use crate::span::{Span, Text};

/// Bytes of tree for a byte of text, and those that every file may have.
const TIMES: usize = 20;
const AT_LEAST: usize = 256 << 10;

/// Mappings with more keys are searched for duplicates by sorting.
const FEW: usize = 16;

/// What stops a text from being a tree.
#[derive(Debug)]
pub(super) struct Fault {
    code: &'static str,
    message: String,
    help: &'static str,
    span: Span,
}

const RIGHT_FILE: &str = "is this the right file?";

impl Fault {
    pub(super) fn malformed(message: impl Into<String>, help: &'static str, span: Span) -> Self {
        Self {
            code: "malformed-yaml",
            message: message.into(),
            help,
            span,
        }
    }

    pub(super) fn finding(self, source: &Source) -> Box<Finding> {
        let place = source.place(self.span.start, self.span.end);
        Box::new(
            Finding::error(self.code, self.message)
                .at(Some(place))
                .help(self.help),
        )
    }
}

/// The lists and mappings that are still open, and the root once it is closed.
pub(super) struct Builder {
    open: Vec<Open>,
    root: Option<Node>,
    /// Values with an anchor, when the text may have an alias.
    anchors: Option<HashMap<usize, Node>>,
    left: usize,
}

struct Open {
    values: Values,
    anchor: usize,
    span: Span,
}

enum Values {
    Sequence(Vec<Node>),
    Mapping(Vec<(Text, Node)>, Option<Text>),
}

impl Builder {
    pub(super) fn new(text: &str) -> Self {
        Self {
            open: Vec::new(),
            root: None,
            anchors: text.contains('*').then(HashMap::new),
            left: text.len().saturating_mul(TIMES).saturating_add(AT_LEAST),
        }
    }

    /// True when the next scalar is a key.
    pub(super) fn wants_key(&self) -> bool {
        let last = self.open.last().map(|open| &open.values);
        matches!(last, Some(Values::Mapping(_, None)))
    }

    pub(super) fn open(&mut self, mapping: bool, anchor: usize, span: Span) -> Result<(), Fault> {
        if self.open.len() >= DEPTH_LIMIT {
            return Err(Fault {
                code: "too-deep",
                message: format!("lists and mappings are nested deeper than {DEPTH_LIMIT}"),
                help: RIGHT_FILE,
                span,
            });
        }
        let values = match mapping {
            true => Values::Mapping(Vec::new(), None),
            false => Values::Sequence(Vec::new()),
        };
        self.open.push(Open {
            values,
            anchor,
            span,
        });
        Ok(())
    }

    pub(super) fn close(&mut self) -> Result<(), Fault> {
        let Some(open) = self.open.pop() else {
            return Ok(());
        };
        let value = match open.values {
            Values::Sequence(items) => Value::Sequence(items.into()),
            Values::Mapping(entries, _) => {
                unique(&entries)?;
                Value::Mapping(entries.into())
            }
        };
        let span = open.span;
        self.value(Node { value, span }, open.anchor)
    }

    pub(super) fn value(&mut self, node: Node, anchor: usize) -> Result<(), Fault> {
        if anchor > 0 && self.anchors.is_some() {
            self.pay(weight(&node), node.span)?;
            if let Some(anchors) = &mut self.anchors {
                anchors.insert(anchor, node.clone());
            }
        }
        let in_mapping = matches!(
            self.open.last().map(|open| &open.values),
            Some(Values::Mapping(..))
        );
        self.pay(if in_mapping { 48 } else { 40 }, node.span)?;
        match self.open.last_mut().map(|open| &mut open.values) {
            None => self.root = Some(node),
            Some(Values::Sequence(items)) => items.push(node),
            Some(Values::Mapping(entries, key)) => match (key.take(), node.value) {
                (Some(key), value) => {
                    let span = node.span;
                    entries.push((key, Node { value, span }));
                }
                (None, Value::Scalar(text)) => *key = Some(Text::new(text, node.span)),
                (None, _) => {
                    let help =
                        "write `key: value`, and put a text that begins with a bracket in quotes";
                    return Err(Fault::malformed(
                        "a key must be a plain text",
                        help,
                        node.span,
                    ));
                }
            },
        }
        Ok(())
    }

    /// A copy of the value with an anchor.
    pub(super) fn alias(&mut self, anchor: usize, span: Span) -> Result<(), Fault> {
        let known = self.anchors.as_ref().and_then(|all| all.get(&anchor));
        let Some(node) = known else {
            let message = "an alias stands within what it stands for";
            let help = "give the alias the name of another anchor";
            return Err(Fault::malformed(message, help, span));
        };
        let weight = weight(node);
        let mut node = node.clone();
        node.span = span;
        self.pay(weight, span)?;
        self.value(node, 0)
    }

    fn pay(&mut self, cost: usize, span: Span) -> Result<(), Fault> {
        match self.left.checked_sub(cost) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(Fault {
                code: "too-dense",
                message: "up to here the file has more values than a file of its size can have"
                    .to_owned(),
                help: RIGHT_FILE,
                span,
            }),
        }
    }

    pub(super) fn finish(self) -> Node {
        self.root.unwrap_or(Node {
            value: Value::Null,
            span: Span::default(),
        })
    }
}

/// Bytes that a copy of a node takes.
fn weight(node: &Node) -> usize {
    let inner = match &node.value {
        Value::Null => 0,
        Value::Scalar(text) => text.len(),
        Value::Sequence(items) => items.iter().map(weight).sum(),
        Value::Mapping(entries) => {
            let entry =
                |(key, node): &(Text, Node)| size_of::<Text>() + key.value.len() + weight(node);
            entries.iter().map(entry).sum()
        }
    };
    size_of::<Node>() + inner
}

/// An error for the second place of a key.
fn unique(entries: &[(Text, Node)]) -> Result<(), Fault> {
    let key = |at: usize| entries[at].0.value.as_str();
    let second = if entries.len() <= FEW {
        (1..entries.len()).find(|at| (0..*at).any(|before| key(before) == key(*at)))
    } else {
        let mut order: Vec<usize> = (0..entries.len()).collect();
        order.sort_by_key(|at| (key(*at), *at));
        let pairs = order.windows(2).filter(|pair| key(pair[0]) == key(pair[1]));
        pairs.map(|pair| pair[1]).min()
    };
    match second {
        None => Ok(()),
        Some(at) => {
            let text = &entries[at].0;
            let message = format!("duplicate entry with key \"{}\"", text.value);
            let help = "write the key once, with the value that is meant";
            Err(Fault::malformed(message, help, text.span))
        }
    }
}
