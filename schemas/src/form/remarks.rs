//! Comments of YAML, which the parser drops, as comments of XML: before the element that they stand before.

use super::{Around, Form, Format, Place, Slot, Stray, Value};
use crate::diagnostic::Source;
use crate::xml::Node;
use crate::yaml;

/// A comment of YAML: its text, and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Its `#`.
    pub start: u32,
    /// True when something stands before it in its line.
    pub trails: bool,
    /// What it says, without the `#`.
    pub text: String,
}

/// What stands in the file: a form, or one of its texts.
struct Token {
    start: u32,
    /// Field and index, from the root.
    path: Vec<(usize, usize)>,
    is_form: bool,
}

/// Keeps all comments of a YAML text in the form that was read from it, and around it.
pub fn keep_all_remarks(format: Format, source: &Source, root: &mut dyn Form, around: &mut Around) {
    if format == Format::Yaml {
        let before = keep_remarks(root, yaml::remarks(source));
        let node = |remark: Remark| Node::Comment(allowed(&remark.text).into());
        around.before.extend(before.into_iter().map(node));
    }
}

/// Puts comments into the forms that they stand in. Those before the root are given back.
fn keep_remarks(root: &mut dyn Form, remarks: Vec<Remark>) -> Vec<Remark> {
    let mut tokens = Vec::new();
    gather(root, &mut Vec::new(), &mut tokens);
    tokens.sort_by_key(|token| token.start);
    let (before, within): (Vec<_>, Vec<_>) = remarks
        .into_iter()
        .partition(|remark| remark.start < root.span().start);
    for remark in within {
        let next = tokens.partition_point(|token| token.start < remark.start);
        let at = match remark.trails {
            true => next.checked_sub(1),
            false => Some(next),
        };
        let token = at.and_then(|at| tokens.get(at));
        let path = token.map_or(&[][..], |token| &token.path);
        let path = match token {
            // Before an element, not in it.
            Some(token) if token.is_form && !remark.trails => &path[..path.len().saturating_sub(1)],
            _ => path,
        };
        if let Some(form) = follow(root, path) {
            insert(form, &remark);
        }
    }
    before
}

fn gather(form: &dyn Form, path: &mut Vec<(usize, usize)>, tokens: &mut Vec<Token>) {
    let mut token = |span: crate::span::Span, path: &[(usize, usize)], is_form| {
        if !span.is_unknown() {
            tokens.push(Token {
                start: span.start,
                path: path.to_vec(),
                is_form,
            });
        }
    };
    token(form.span(), path, true);
    for at in 0..form.form_type().fields.len() {
        match form.value(at) {
            Value::Text(text) => text.iter().for_each(|text| token(text.span, path, false)),
            Value::Texts(texts) => texts.iter().for_each(|text| token(text.span, path, false)),
            Value::Forms(_) => {}
        }
    }
    for at in 0..form.form_type().fields.len() {
        let Value::Forms(forms) = form.value(at) else {
            continue;
        };
        for index in 0..forms.count() {
            if let Some(child) = forms.form(index) {
                path.push((at, index));
                gather(child, path, tokens);
                path.pop();
            }
        }
    }
}

fn follow<'a>(form: &'a mut dyn Form, path: &[(usize, usize)]) -> Option<&'a mut dyn Form> {
    let Some(((at, index), rest)) = path.split_first() else {
        return Some(form);
    };
    match form.slot(*at)? {
        Slot::Forms(forms) => follow(forms.form_mut(*index)?, rest),
        Slot::Text(_) | Slot::Texts(_) => None,
    }
}

/// Before the first element that starts after the comment.
fn insert(form: &mut dyn Form, remark: &Remark) {
    let mut order = form.extra().get().node_order.clone();
    if !order.iter().any(|place| place.field().is_some()) {
        order.splice(0..0, places(form));
    }
    let behind = |place: &Place| place.start().is_some_and(|start| start > remark.start);
    let at = order.iter().position(behind).unwrap_or(order.len());
    let others = order[..at].iter().filter(|place| **place == Place::Other);
    let stray = others.count();
    order.insert(at, Place::Other);
    let beside = form.extra_mut().edit();
    let stray = stray.min(beside.strays.len());
    beside
        .strays
        .insert(stray, Stray::Comment(allowed(&remark.text).into()));
    beside.node_order = order;
}

/// All elements in the order of the schema.
fn places(form: &dyn Form) -> Vec<Place> {
    let mut all = Vec::new();
    let fields = form.form_type().fields.iter().enumerate();
    for (at, _) in fields.filter(|(_, field)| !field.kind.is_attribute()) {
        let mut push = |span: crate::span::Span| {
            all.push(match (u16::try_from(at), span.is_unknown()) {
                (Ok(at), false) => Place::Field(at, span.start),
                _ => Place::fresh(at),
            });
        };
        match form.value(at) {
            Value::Text(text) => text.iter().for_each(|text| push(text.span)),
            Value::Texts(texts) => texts.iter().for_each(|text| push(text.span)),
            Value::Forms(forms) => (0..forms.count())
                .filter_map(|index| forms.form(index))
                .for_each(|form| push(form.span())),
        }
    }
    all
}

/// XML ends a comment at two hyphens.
fn allowed(text: &str) -> String {
    let mut allowed = String::with_capacity(text.len() + 1);
    for c in text.chars() {
        if c == '-' && allowed.ends_with('-') {
            allowed.push(' ');
        }
        allowed.push(c);
    }
    if !allowed.ends_with(char::is_whitespace) {
        allowed.push(' ');
    }
    allowed
}

#[cfg(test)]
mod tests {
    use crate::form::{Format, same};
    use crate::rts_profile::{self, format};
    use crate::yaml;

    #[test]
    fn comments_of_yaml_become_comments_of_xml() {
        let text = "\
# first -- of all-
rtsProfile: # the root
  id: \"RTSystem:a:b:1\"
  # two of them
  components:
    - instanceName: A0 # the first
      # of A0
      activeConfigurationSet: default
      configurationSets:
        # the set
        - id: default
    # before B0
    - instanceName: B0
      comment: \"# no comment\"
      # at the end of B0
      isRequired: true
# the end
";
        let mut read = rts_profile::read("f.yaml", text.as_bytes()).unwrap();
        let original = read.shape.clone();
        read.keep_remarks();
        assert!(same(original.form(), read.shape.form()));
        let xml = format(&read.shape, &read.around, Format::Xml);
        insta::assert_snapshot!(xml);
        assert_eq!(
            xml.matches("<!--").count(),
            yaml::remarks(&read.source).len()
        );
        let again = rts_profile::read("f.xml", xml.as_bytes()).unwrap();
        assert_eq!(format(&again.shape, &again.around, Format::Xml), xml);
    }
}
