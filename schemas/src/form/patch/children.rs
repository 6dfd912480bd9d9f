//! Child elements: which ones stay, which go, and where new ones stand.

use std::collections::HashMap;

use super::super::order::{node_order, staying};
use super::super::place::declaration;
use super::super::{Form, Held, Value, element_of};
use super::{Patch, is_element};
use crate::span::{Span, Text};
use crate::xml::document::{EditError, Part};
use crate::xml::{Element, Node, escape_text, print_element};

/// The child elements of a document's element, by the field that each was read into.
struct Old<'a> {
    /// Field (`None`: without one) and element, in the order of the document.
    places: Vec<(Option<usize>, &'a Part)>,
    /// Which of them stay.
    kept: Vec<bool>,
    /// The first that stays.
    first: Option<usize>,
    /// The first with a field that stays.
    first_known: Option<usize>,
}

/// One child of a field in the new form: the old one that it is, or `None` for a new one.
type Match = Option<usize>;

/// The children of one field in the new form.
struct Matches {
    /// Its index.
    field: usize,
    /// Those that stay where they are.
    stay: Vec<Match>,
    /// Those that stood elsewhere among the others.
    moved: Vec<Match>,
}

impl Patch<'_> {
    pub(super) fn children(
        &mut self,
        part: &Part,
        old: &dyn Form,
        new: &dyn Form,
    ) -> Result<(), EditError> {
        let beside = old.extra().get();
        let order = node_order(old, &beside.node_order, beside.strays.len());
        let mut strays = beside.strays.iter();
        let order = order.iter().filter(|place| is_element(place, &mut strays));
        let fields: Vec<Option<usize>> = order.map(|place| place.field()).collect();
        if fields.len() != part.children.len() {
            return Err(self.stranger(part));
        }
        let mut state = Old {
            first: None,
            first_known: None,
            kept: vec![true; fields.len()],
            places: fields.into_iter().zip(&part.children).collect(),
        };
        let count = old.form_type().fields.len();
        let elements = (0..count).filter(|at| !old.form_type().fields[*at].kind.is_attribute());
        let matches: Vec<Matches> = elements
            .map(|at| Matches::of(at, &old.value(at), &new.value(at)))
            .collect();
        for matches in &matches {
            self.changed(matches, old, new, &mut state)?;
        }
        state.first = state.kept.iter().position(|kept| *kept);
        let mut known = state.kept.iter().zip(&state.places);
        state.first_known = known.position(|(kept, (field, _))| *kept && field.is_some());
        let mut inside = String::new();
        for matches in &matches {
            self.added(part, matches, (old, new), &state, &mut inside);
        }
        if !inside.is_empty() {
            self.insert_inside(part, &inside);
        }
        Ok(())
    }

    /// Changes those that stay, and removes those that go.
    fn changed(
        &mut self,
        matches: &Matches,
        old: &dyn Form,
        new: &dyn Form,
        state: &mut Old<'_>,
    ) -> Result<(), EditError> {
        let at = matches.field;
        let own: Vec<usize> = state.own(at).collect();
        let mut indices = vec![None; own.len()];
        for (index, number) in matches.stay.iter().enumerate() {
            if let Some(slot) = number.and_then(|number| indices.get_mut(number)) {
                *slot = Some(index);
            }
        }
        for (number, (place, index)) in own.into_iter().zip(indices).enumerate() {
            let part = state.places[place].1;
            let Some(index) = index else {
                state.kept[place] = false;
                self.replace(self.document.with_lines(part.whole.clone()), String::new());
                continue;
            };
            match (old.value(at), new.value(at)) {
                (Value::Forms(was), Value::Forms(is)) => {
                    if let (Some(was), Some(is)) = (was.form(number), is.form(index)) {
                        self.element(part, was, is)?;
                    }
                }
                (Value::Text(Some(was)), Value::Text(Some(is))) if was.value != is.value => {
                    self.set_text(part, is);
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn set_text(&mut self, part: &Part, text: &Text) {
        let mut escaped = String::new();
        escape_text(&text.value, &mut escaped);
        match &part.content {
            Some(content) => self.replace(content.clone(), escaped),
            None => {
                let name = self.document.text()[part.name.clone()].to_owned();
                let end = part.whole.end;
                self.replace(end - 2..end, format!(">{escaped}</{name}>"));
            }
        }
    }

    /// Writes new ones after the one before them, or before the one after them, or where the schema has them.
    fn added(
        &mut self,
        part: &Part,
        matches: &Matches,
        (old, new): (&dyn Form, &dyn Form),
        state: &Old<'_>,
        inside: &mut String,
    ) {
        let at = matches.field;
        let stay = &matches.stay;
        let own: Vec<usize> = state.own(at).collect();
        let stays = |m: &Match| m.and_then(|number| own.get(number).copied());
        let mut following: Vec<Option<usize>> = vec![None; stay.len()];
        let mut next = None;
        for (index, m) in stay.iter().enumerate().rev() {
            next = stays(m).or(next);
            following[index] = next;
        }
        let mut kept = (0..state.places.len()).rev().filter(|p| state.kept[*p]);
        let earlier = kept.find(|p| state.places[*p].0.is_some_and(|field| field <= at));
        let mut before = None;
        for (index, m) in stay.iter().enumerate() {
            if m.is_some() {
                before = stays(m).or(before);
                continue;
            }
            let after = following[index];
            let moved = matches.moved[index]
                .filter(|number| same_child(&old.value(at), *number, &new.value(at), index))
                .and_then(|number| own.get(number).copied());
            let text = match moved {
                Some(place) => self.document.text()[state.places[place].1.whole.clone()].to_owned(),
                None => self.new_element(part, at, index, new, state),
            };
            if let Some(place) = before.or(if after.is_none() { earlier } else { None }) {
                let anchor = state.places[place].1.whole.clone();
                let text = match self.document.indent(anchor.start) {
                    Some(indent) => format!("{}{indent}{text}", self.document.line_end()),
                    None => text,
                };
                self.replace(anchor.end..anchor.end, text);
            } else if let Some(place) = after.or(state.first_known) {
                let anchor = state.places[place].1.whole.clone();
                let text = match self.document.indent(anchor.start) {
                    Some(indent) => format!("{text}{}{indent}", self.document.line_end()),
                    None => text,
                };
                self.replace(anchor.start..anchor.start, text);
            } else {
                if let Some(indent) = self.inner_indent(part) {
                    inside.push_str(self.document.line_end());
                    inside.push_str(&indent);
                }
                inside.push_str(&text);
            }
        }
    }

    /// Indentation of a child where there is none yet.
    fn inner_indent(&self, part: &Part) -> Option<String> {
        let outer = self.document.indent(part.whole.start)?;
        Some(format!("{outer}{}", self.document.indent_step()))
    }

    fn insert_inside(&mut self, part: &Part, inside: &str) {
        let closing = match self.document.indent(part.whole.start) {
            Some(outer) => format!("{}{outer}", self.document.line_end()),
            None => String::new(),
        };
        match &part.content {
            // Blanks that are there already lead to the end tag.
            Some(content) => {
                let text = &self.document.text()[content.clone()];
                let closing = if text.is_empty() {
                    closing.as_str()
                } else {
                    ""
                };
                let text = format!("{inside}{closing}");
                self.replace(content.start..content.start, text);
            }
            None => {
                let name = self.document.text()[part.name.clone()].to_owned();
                let end = part.whole.end;
                self.replace(end - 2..end, format!(">{inside}{closing}</{name}>"));
            }
        }
    }

    fn new_element(
        &mut self,
        part: &Part,
        at: usize,
        index: usize,
        new: &dyn Form,
        state: &Old<'_>,
    ) -> String {
        let field = &new.form_type().fields[at];
        let name = self.name(field, false);
        if let Some(prefix) = &name.new_prefix {
            self.scope.declare(prefix, &name.namespace);
            let made = declaration(prefix, &name.namespace);
            let last = part.attributes.last();
            let at = last.map_or(part.name.end, |attribute| attribute.whole.end);
            self.replace(at..at, format!(" {}=\"{}\"", made.qname, made.value));
        }
        let full = (name.namespace.as_str(), name.qname.as_str());
        let element = match new.value(at) {
            Value::Text(text) => text.map(|text| text_element(full, text)),
            Value::Texts(texts) => texts.get(index).map(|text| text_element(full, text)),
            Value::Forms(forms) => forms
                .form(index)
                .map(|form| element_of(form, full, &mut self.scope, self.words)),
        };
        let Some(element) = element else {
            return String::new();
        };
        let indent = match state.first.map(|first| &state.places[first]) {
            Some((_, part)) => self.document.indent(part.whole.start).map(str::to_owned),
            None => self.inner_indent(part),
        };
        let text = print_element(&element, indent.as_deref().unwrap_or_default());
        self.lines(text)
    }
}

impl Old<'_> {
    fn own(&self, at: usize) -> impl Iterator<Item = usize> {
        let places = self.places.iter().enumerate();
        places
            .filter(move |(_, (field, _))| *field == Some(at))
            .map(|(index, _)| index)
    }
}

impl Matches {
    /// Forms are told by the place where they were read, texts also by what they say.
    fn of(field: usize, old: &Value<'_>, new: &Value<'_>) -> Self {
        let known = match (old, new) {
            (Value::Text(old), Value::Text(Some(_))) => vec![old.map(|_| 0)],
            (Value::Texts(old), Value::Texts(new)) => {
                let old = old.iter().map(|text| (text.span, text.value.as_str()));
                let new = new.iter().map(|text| (text.span, text.value.as_str()));
                known(old, new, |(span, _)| span.is_unknown())
            }
            (Value::Forms(old), Value::Forms(new)) => {
                known(spans(*old), spans(*new), |span| span.is_unknown())
            }
            _ => Vec::new(),
        };
        let stay = staying(&known);
        let moved = known.iter().zip(&stay);
        let moved = moved.map(|(known, stay)| known.filter(|_| stay.is_none()));
        Self {
            field,
            moved: moved.collect(),
            stay,
        }
    }
}

fn spans(forms: &dyn Held) -> impl Iterator<Item = Span> {
    (0..forms.count()).map(|index| forms.form(index).map(Form::span).unwrap_or_default())
}

/// For each new value the old one that has the same key; what stands twice is the old one once.
fn known<K: Eq + std::hash::Hash>(
    old: impl Iterator<Item = K>,
    new: impl Iterator<Item = K>,
    is_new: impl Fn(&K) -> bool,
) -> Vec<Match> {
    let mut numbers: HashMap<K, usize> = old.zip(0..).collect();
    new.map(|key| numbers.remove(&key).filter(|_| !is_new(&key)))
        .collect()
}

/// True when a child says what it said.
fn same_child(old: &Value<'_>, number: usize, new: &Value<'_>, index: usize) -> bool {
    match (old, new) {
        (Value::Forms(old), Value::Forms(new)) => match (old.form(number), new.form(index)) {
            (Some(old), Some(new)) => super::super::same(old, new),
            _ => false,
        },
        _ => true,
    }
}

fn text_element((namespace, qname): (&str, &str), text: &Text) -> Element {
    let children = match text.value.as_str() {
        "" => Vec::new(),
        text => vec![Node::Text(text.into())],
    };
    Element {
        namespace: namespace.into(),
        qname: qname.into(),
        attributes: Vec::new(),
        children,
        span: Span::default(),
    }
}
