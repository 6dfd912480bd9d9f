//! Goes through a form and all in it: to change texts wherever they stand, and to take fields away.

use super::{FieldType, Form, FormType, Slot, Stray, Value};
use crate::span::{Span, Text};

/// A value that was taken away.
#[derive(Debug, Clone, Copy)]
pub struct Taken {
    /// Where it stood.
    pub span: Span,
    /// The type that had it.
    pub of: &'static FormType,
    /// The field that held it.
    pub field: &'static FieldType,
}

/// Shows every text of attributes and elements, which may be changed.
pub fn each_text(
    form: &mut dyn Form,
    edit: &mut dyn FnMut(&'static FormType, &'static FieldType, &mut Text),
) {
    let of = form.form_type();
    for (at, field) in of.fields.iter().enumerate() {
        match form.slot(at) {
            Some(Slot::Text(text)) => text.iter_mut().for_each(|text| edit(of, field, text)),
            Some(Slot::Texts(texts)) => texts.iter_mut().for_each(|text| edit(of, field, text)),
            Some(Slot::Forms(forms)) => {
                for index in 0..forms.count() {
                    if let Some(form) = forms.form_mut(index) {
                        each_text(form, edit);
                    }
                }
            }
            None => {}
        }
    }
}

/// How many comments and processing instructions stand in a form, which YAML has no place for.
pub fn comments(form: &dyn Form) -> usize {
    let strays = form.extra().get().strays.iter();
    let own = strays.filter(|stray| matches!(stray, Stray::Comment(_) | Stray::Instruction(_)));
    let inner = (0..form.form_type().fields.len()).map(|at| match form.value(at) {
        Value::Forms(forms) => (0..forms.count())
            .filter_map(|index| forms.form(index))
            .map(comments)
            .sum(),
        Value::Text(_) | Value::Texts(_) => 0,
    });
    own.count() + inner.sum::<usize>()
}

/// Takes the values of these fields (name of the type, name of the field) away.
pub fn take_fields(form: &mut dyn Form, fields: &[(&str, &str)], taken: &mut Vec<Taken>) {
    let of = form.form_type();
    for (at, field) in of.fields.iter().enumerate() {
        let wanted = fields.contains(&(of.name, field.name));
        let span = first_span(form, at);
        match form.slot(at) {
            Some(slot) if wanted => {
                if let Some(span) = span {
                    taken.push(Taken { span, of, field });
                    clear(slot);
                }
            }
            Some(Slot::Forms(forms)) => {
                for index in 0..forms.count() {
                    if let Some(form) = forms.form_mut(index) {
                        take_fields(form, fields, taken);
                    }
                }
            }
            _ => {}
        }
    }
}

fn clear(slot: Slot<'_>) {
    match slot {
        Slot::Text(text) => *text = None,
        Slot::Texts(texts) => texts.clear(),
        Slot::Forms(forms) => {
            for index in (0..forms.count()).rev() {
                forms.remove(index);
            }
        }
    }
}

/// Where the first value of a field stands; `None` if it has none.
fn first_span(form: &dyn Form, at: usize) -> Option<Span> {
    match form.value(at) {
        Value::Text(text) => text.map(|text| text.span),
        Value::Texts(texts) => texts.first().map(|text| text.span),
        Value::Forms(forms) => forms.form(0).map(Form::span),
    }
}
