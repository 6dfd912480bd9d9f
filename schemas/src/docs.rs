//! The documentation of every field, from the doc comments of the types.
//!
//! A doc comment is a text, then facts: lines of `- Values: …`, `- Default: …`, `- Required: …`, `- Versions: …` and
//! `- Unit: …`.

mod facts;
mod forms;
mod overlay;

use std::sync::Arc;

pub use facts::Facts;

use crate::suggest;

/// What a doc comment says, without its facts.
pub(crate) fn text(doc: &str) -> String {
    facts::parted(doc).0
}

/// What is said of a type.
#[derive(Debug, Clone)]
pub struct Docs {
    /// Name of the type.
    pub name: String,
    /// What it is.
    pub text: String,
    /// Its fields, in their order.
    pub fields: Vec<Field>,
}

/// What is said of a field.
#[derive(Debug, Clone)]
pub struct Field {
    /// Its name in a path: its key in YAML.
    pub name: String,
    /// Names that are understood as well.
    pub others: Vec<String>,
    /// How it is written in XML: `rts:id` for an attribute, `<rts:Components>` for an element.
    pub xml: Option<String>,
    /// How it is written in YAML, when that is not its name.
    pub yaml: Option<String>,
    /// Its type: `string`, `[]Component`.
    pub kind: String,
    /// What it means.
    pub text: String,
    /// What more there is to know.
    pub facts: Facts,
    /// The type of what it holds.
    pub inner: Option<Inner>,
}

/// A type that is only described when it is asked for: some hold themselves.
#[derive(Clone)]
pub struct Inner(Arc<dyn Fn() -> Docs + Send + Sync>);

impl Inner {
    /// Of a type.
    pub fn new(docs: impl Fn() -> Docs + Send + Sync + 'static) -> Self {
        Self(Arc::new(docs))
    }

    /// What is said of it.
    pub fn docs(&self) -> Docs {
        (self.0)()
    }
}

impl std::fmt::Debug for Inner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Inner")
    }
}

/// Where a path starts.
#[derive(Debug, Clone)]
pub struct Root {
    /// First word of the path: `system`.
    pub name: &'static str,
    /// Other words that mean it: the root keys and elements of the document.
    pub others: &'static [&'static str],
    /// What it is a document of: `RTS Profile 0.2`.
    pub title: &'static str,
    /// How the document is written in XML and YAML.
    pub written: &'static str,
    /// Version of the document, where paths of several start with the same word.
    pub version: Option<&'static str>,
    /// The type of the document.
    pub docs: fn() -> Docs,
}

/// All roots; the usual version of a name stands first.
pub const ROOTS: &[Root] = forms::ROOTS;

/// Why a path leads nowhere.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct NoField {
    /// What is not there.
    pub message: String,
    /// What may have been meant.
    pub help: String,
}

/// What a path leads to.
#[derive(Debug, Clone)]
pub struct Found {
    /// Where it starts.
    pub root: Root,
    /// The path in full, as it is usually spelled.
    pub path: String,
    /// The field; nothing for the root itself.
    pub field: Option<Field>,
    /// The type of what it holds; nothing for a plain value.
    pub docs: Option<Docs>,
}

/// True when a path starts with the name of a root.
pub fn is_path(path: &str) -> bool {
    let first = path.split('.').next().unwrap_or_default();
    ROOTS.iter().any(|root| root.is_called(first))
}

impl Root {
    /// True for its name, or another word that means it.
    fn is_called(&self, word: &str) -> bool {
        self.name == word
            || self
                .others
                .iter()
                .any(|other| other.eq_ignore_ascii_case(word))
    }
}

impl Field {
    /// The same for what stands under one name of a mapping; nothing when this is no mapping of free names.
    fn under(&self, name: &str) -> Option<Self> {
        let kind = self.kind.strip_prefix(MAP)?;
        Some(Self {
            name: name.to_owned(),
            kind: kind.to_owned(),
            ..self.clone()
        })
    }
}

/// How the type of a mapping starts whose keys are free.
const MAP: &str = "map[string]";

/// Follows a path as `system.components.dataPorts`; keys of YAML and names of XML are understood, whatever their case.
///
/// # Errors
/// The first word that leads nowhere, and the nearest one that would.
pub fn find(path: &str, version: Option<&str>) -> Result<Found, NoField> {
    let mut words = path.split('.');
    let first = words.next().unwrap_or_default();
    let root = root(first, version)?;
    let mut found = Found {
        root: root.clone(),
        path: root.name.to_owned(),
        field: None,
        docs: Some((root.docs)()),
    };
    for word in words {
        let named = found.docs.as_ref().and_then(|docs| docs.field(word));
        let free = found.field.as_ref().and_then(|field| field.under(word));
        if let (None, Some(free)) = (named, free) {
            found.path = format!("{}.{word}", found.path);
            found.field = Some(free);
            continue;
        }
        let Some(docs) = &found.docs else {
            let message = format!("`{}` is a plain value: it has no `{word}`", found.path);
            let help = format!("see `rtsctl explain {}`", found.path);
            return Err(NoField { message, help });
        };
        let Some(field) = docs.field(word) else {
            // `condition:` of YAML is no level of XML.
            let level = format!("{word}/");
            let is_level = |field: &Field| field.others.iter().any(|o| o.starts_with(&level));
            if docs.fields.iter().any(is_level) {
                continue;
            }
            let known: Vec<&str> = docs.fields.iter().map(|f| f.name.as_str()).collect();
            return Err(NoField {
                message: format!("`{}` has no field `{word}`", found.path),
                help: suggest::advice(word, "fields", &known),
            });
        };
        found.path = format!("{}.{}", found.path, field.name);
        let docs = field.inner.as_ref().map(Inner::docs);
        found.field = Some(field.clone());
        found.docs = docs;
    }
    Ok(found)
}

fn root(name: &str, version: Option<&str>) -> Result<&'static Root, NoField> {
    let mut named = ROOTS.iter().filter(|root| root.is_called(name)).peekable();
    if named.peek().is_none() {
        let mut known: Vec<&str> = ROOTS.iter().map(|root| root.name).collect();
        known.dedup();
        return Err(NoField {
            message: format!("nothing is called `{name}`"),
            help: suggest::advice(name, "names", &known),
        });
    }
    let fits =
        |root: &&Root| version.is_none() || root.version.is_none() || root.version == version;
    named.clone().find(fits).ok_or_else(|| {
        let known: Vec<&str> = named.filter_map(|root| root.version).collect();
        NoField {
            message: format!(
                "there is no version {} of `{name}`",
                version.unwrap_or_default()
            ),
            help: format!("known versions: {}", known.join(", ")),
        }
    })
}

impl Docs {
    /// The field with a name.
    pub fn field(&self, name: &str) -> Option<&Field> {
        let same = |field: &&Field, same: fn(&str, &str) -> bool| {
            same(&field.name, name) || field.others.iter().any(|other| same(other, name))
        };
        let mut fields = self.fields.iter();
        fields
            .clone()
            .find(|field| field.name == name)
            .or_else(|| fields.clone().find(|field| same(field, |a, b| a == b)))
            .or_else(|| fields.find(|field| same(field, |a, b| a.eq_ignore_ascii_case(b))))
    }
}

#[cfg(test)]
mod tests;
