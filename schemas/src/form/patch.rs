//! Two forms → edits of the document that the first was read from: only what differs is touched.

mod children;

use super::order::attribute_order;
use super::place::declaration;
use super::same::same_beside;
use super::write_xml::Name;
use super::{FieldType, Form, Place, Scope, Stray, Value, Vocabulary, element_of, read_element};
use crate::xml::document::{Document, Edit, EditError, Part};
use crate::xml::{self, escape_attribute, print_element};

/// The document with everything that differs between two forms: attributes are changed, added and removed in place,
/// elements are added with the indentation of their neighbours and removed with their lines.
///
/// `old` is what was read from the document, `new` an edited copy of it.
///
/// # Errors
/// When `old` was not read from the document, or `new` cannot be written into it so that it is read again.
pub fn patch<F: Form + Default>(
    document: &Document,
    old: &F,
    new: &F,
    words: &Vocabulary,
) -> Result<Document, EditError> {
    let mut patch = Patch {
        document,
        words,
        scope: Scope::default(),
        edits: Vec::new(),
    };
    patch.element(document.root(), old, new)?;
    let edited = document.edited(patch.edits)?;
    let root = xml::parse(edited.text()).map_err(|e| EditError::Malformed(e.to_string()))?;
    let mut read = F::default();
    read_element(root, &mut read, words);
    if super::same(&read, new) {
        Ok(edited)
    } else {
        Err(EditError::Unfaithful)
    }
}

struct Patch<'a> {
    document: &'a Document,
    words: &'a Vocabulary,
    scope: Scope,
    edits: Vec<Edit>,
}

impl Patch<'_> {
    fn element(&mut self, part: &Part, old: &dyn Form, new: &dyn Form) -> Result<(), EditError> {
        let depth = self.scope.depth();
        if !same_beside(old.extra().get(), new.extra().get()) {
            // What has no field is rarely edited: then the element is written anew.
            let name = self.document.text()[part.name.clone()].to_owned();
            let text = self.printed(new, part, &name)?;
            self.replace(part.whole.clone(), text);
            return Ok(());
        }
        self.scope.enter(&old.extra().get().attributes);
        self.attributes(part, old, new)?;
        self.children(part, old, new)?;
        self.scope.leave(depth);
        Ok(())
    }

    fn replace(&mut self, range: std::ops::Range<usize>, text: String) {
        self.edits.push(Edit { range, text });
    }

    fn printed(&mut self, form: &dyn Form, part: &Part, qname: &str) -> Result<String, EditError> {
        let prefix = super::place::prefix_of(qname);
        let mut scope = self.scope.clone();
        scope.enter(&form.extra().get().attributes);
        let namespace = scope.namespace(prefix).unwrap_or_default().to_owned();
        let element = element_of(form, (&namespace, qname), &mut self.scope, self.words);
        let indent = self.document.indent(part.whole.start).unwrap_or_default();
        Ok(self.lines(print_element(&element, indent)))
    }

    /// With the line ends of the file.
    fn lines(&self, text: String) -> String {
        match self.document.line_end() {
            "\n" => text,
            end => text.replace('\n', end),
        }
    }

    fn attributes(&mut self, part: &Part, old: &dyn Form, new: &dyn Form) -> Result<(), EditError> {
        let beside = old.extra().get();
        let order = attribute_order(old, &beside.attribute_order, beside.attributes.len());
        if order.len() != part.attributes.len() {
            return Err(self.stranger(part));
        }
        let text = self.document.text();
        for (place, attribute) in order.iter().zip(&part.attributes) {
            let Some(at) = place.field() else { continue };
            let (Value::Text(was), Value::Text(is)) = (old.value(at), new.value(at)) else {
                continue;
            };
            match is {
                Some(is) if was.is_none_or(|was| was.value != is.value) => {
                    let mut value = String::new();
                    escape_attribute(&is.value, attribute.quote, &mut value);
                    self.replace(attribute.value.clone(), value);
                }
                Some(_) => {}
                None => {
                    let before = text[..attribute.whole.start].trim_end().len();
                    self.replace(before..attribute.whole.end, String::new());
                }
            }
        }
        let added: String = self.added_attributes(old, new);
        if !added.is_empty() {
            let last = part.attributes.last();
            let at = last.map_or(part.name.end, |attribute| attribute.whole.end);
            self.replace(at..at, added);
        }
        Ok(())
    }

    fn added_attributes(&mut self, old: &dyn Form, new: &dyn Form) -> String {
        let mut added = String::new();
        let mut add = |qname: &str, value: &str| {
            added.push_str(&format!(" {qname}=\""));
            escape_attribute(value, '"', &mut added);
            added.push('"');
        };
        for (at, field) in old.form_type().fields.iter().enumerate() {
            let (Value::Text(None), Value::Text(Some(text))) = (old.value(at), new.value(at))
            else {
                continue;
            };
            if !field.kind.is_attribute() {
                continue;
            }
            let name = self.name(field, true);
            if let Some(prefix) = &name.new_prefix {
                self.scope.declare(prefix, &name.namespace);
                let declaration = declaration(prefix, &name.namespace);
                add(&declaration.qname, &declaration.value);
            }
            add(&name.qname, &text.value);
        }
        added
    }

    fn name(&self, field: &FieldType, attribute: bool) -> Name {
        Name::of(field, None, attribute, &self.scope, self.words)
    }

    fn stranger(&self, part: &Part) -> EditError {
        let name = &self.document.text()[part.name.clone()];
        EditError::Stranger(format!("`<{name}>` at byte {}", part.whole.start))
    }
}

/// True for a place that is an element in the document.
fn is_element(place: &Place, strays: &mut std::slice::Iter<'_, Stray>) -> bool {
    match place {
        Place::Other => matches!(strays.next(), Some(Stray::Element(_))),
        Place::Field(..) | Place::Spelled(..) => true,
    }
}
