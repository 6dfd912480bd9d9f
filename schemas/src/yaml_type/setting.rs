//! What a key says: nothing, a value, or that what others said is taken back.

use serde_json::Value;

use super::{Faults, Leaf, YamlType};
use crate::span::{Span, Text};
use crate::yaml::{self, Node};

/// What a key says. Of nothing the value below stays; `null` takes it back.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Setting<T> {
    /// The key is not there.
    #[default]
    Silent,
    /// The key is `null`.
    Removed(Span),
    /// The key has a value.
    Said(T, Span),
}

impl<T> Setting<T> {
    /// A value that no file says.
    pub fn said(value: impl Into<T>) -> Self {
        Self::Said(value.into(), Span::default())
    }

    /// A value that no file says, if there is one.
    pub fn some(value: Option<impl Into<T>>) -> Self {
        value.map_or(Self::Silent, Self::said)
    }

    /// The value, when it has one.
    pub fn get(&self) -> Option<&T> {
        match self {
            Self::Said(value, _) => Some(value),
            Self::Silent | Self::Removed(_) => None,
        }
    }

    /// True when the key is not there.
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::Silent)
    }

    /// Where it stands; unknown when the key is not there.
    pub fn span(&self) -> Span {
        match self {
            Self::Silent => Span::default(),
            Self::Removed(span) | Self::Said(_, span) => *span,
        }
    }

    /// Lays it over a value that has a default.
    pub fn lay(&self, onto: &mut T)
    where
        T: Clone + Default,
    {
        match self {
            Self::Silent => {}
            Self::Removed(_) => *onto = T::default(),
            Self::Said(value, _) => onto.clone_from(value),
        }
    }

    /// Lays it over a value that may be missing.
    pub fn lay_some<U>(&self, onto: &mut Option<U>)
    where
        T: Clone + Into<U>,
    {
        match self {
            Self::Silent => {}
            Self::Removed(_) => *onto = None,
            Self::Said(value, _) => *onto = Some(value.clone().into()),
        }
    }
}

impl<T: YamlType> Setting<T> {
    /// Reads the value of a key.
    pub fn read(key: &Text, node: &Node, faults: &mut Faults) -> Self {
        if node.value == yaml::Value::Null {
            return Self::Removed(key.span);
        }
        let plain = matches!(node.value, yaml::Value::Scalar(_));
        let span = if plain { node.span } else { key.span };
        match T::read(node, &key.value, faults) {
            Some(value) => Self::Said(value, span),
            None => Self::Silent,
        }
    }

    /// As YAML has it; nothing when it says nothing.
    pub fn write(&self) -> Option<Value> {
        match self {
            Self::Silent => None,
            Self::Removed(_) => Some(Value::Null),
            Self::Said(value, _) => Some(value.write()),
        }
    }

    /// Adds the plain values that are said under a key.
    pub fn leaves(&self, path: &[&str], key: &str, leaves: &mut Vec<Leaf>) {
        let path = [path, &[key]].concat();
        match self {
            Self::Silent => {}
            Self::Removed(span) => leaves.push(Leaf {
                path: path.into_iter().map(str::to_owned).collect(),
                span: *span,
                value: Value::Null,
            }),
            Self::Said(value, span) => value.leaves(&path, *span, leaves),
        }
    }
}
