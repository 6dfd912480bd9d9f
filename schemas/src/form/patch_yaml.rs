//! Two forms → the YAML text that the first was read from, with the values that differ: comments, order and layout stay.

use super::write_yaml::scalar;
use super::{
    FieldKind, Form, Scalar, Value, Vocabulary, open, print_yaml, same, same::same_beside,
};
use crate::diagnostic::{Report, Source};
use crate::span::Text;
use crate::xml::document::{Edit, EditError};

/// The text with every value that differs between two forms.
///
/// `old` is what was read from the text, `new` a copy of it with other values.
///
/// # Errors
/// [`EditError::Unfaithful`] when more than values differ, such as elements that were added or removed, or a value has no
/// place of its own: then the profile has to be written as a whole.
pub fn patch_yaml<F: Form + Default>(
    source: &Source,
    old: &F,
    new: &F,
    words: &Vocabulary,
) -> Result<String, EditError> {
    let mut edits = Vec::new();
    if !collect(source.text(), old, new, &mut edits) {
        return Err(EditError::Unfaithful);
    }
    let text = edited(source.text(), edits)?;
    let opened = open(source.name(), text.as_bytes(), words).map_err(|_| EditError::Unfaithful)?;
    let mut read = F::default();
    let mut report = Report::default();
    opened
        .tree
        .fill(&mut read, words, &opened.source, &mut report);
    match same(&read, new) {
        true => Ok(text),
        false => Err(EditError::Unfaithful),
    }
}

fn edited(text: &str, mut edits: Vec<Edit>) -> Result<String, EditError> {
    edits.sort_by_key(|edit| edit.range.start);
    let mut result = String::with_capacity(text.len());
    let mut at = 0;
    for edit in &edits {
        let kept = text.get(at..edit.range.start);
        result.push_str(kept.ok_or(EditError::Overlap(edit.range.start))?);
        result.push_str(&edit.text);
        at = edit.range.end;
    }
    result.push_str(text.get(at..).ok_or(EditError::Overlap(at))?);
    Ok(result)
}

/// False when more than values differ.
fn collect(text: &str, old: &dyn Form, new: &dyn Form, edits: &mut Vec<Edit>) -> bool {
    if !same_beside(old.extra().get(), new.extra().get()) {
        return false;
    }
    let fields = old.form_type().fields.iter().enumerate();
    let mut pairs = fields.map(|(at, field)| (field.kind, old.value(at), new.value(at)));
    pairs.all(|(kind, old, new)| match (old, new) {
        (Value::Text(None), Value::Text(None)) => true,
        (Value::Text(Some(old)), Value::Text(Some(new))) => value(text, kind, old, new, edits),
        (Value::Texts(old), Value::Texts(new)) => {
            let mut both = old.iter().zip(new);
            old.len() == new.len() && both.all(|(old, new)| value(text, kind, old, new, edits))
        }
        (Value::Forms(old), Value::Forms(new)) => {
            old.count() == new.count()
                && (0..old.count()).all(|at| match (old.form(at), new.form(at)) {
                    (Some(old), Some(new)) => collect(text, old, new, edits),
                    _ => false,
                })
        }
        _ => false,
    })
}

fn value(text: &str, kind: FieldKind, old: &Text, new: &Text, edits: &mut Vec<Edit>) -> bool {
    if old.value == new.value {
        return true;
    }
    if old.span.is_unknown() {
        return false;
    }
    let mut range = old.span.range();
    let quote = |at: Option<usize>| at.and_then(|at| text.as_bytes().get(at)).copied();
    if let Some(mark @ (b'"' | b'\'')) = quote(range.start.checked_sub(1))
        && quote(Some(range.end)) == Some(mark)
    {
        range = range.start - 1..range.end + 1;
    }
    // A date that was one text stays one.
    let kind = match kind {
        FieldKind::Attribute(Scalar::Date) => FieldKind::Text,
        kind => kind,
    };
    edits.push(Edit {
        range,
        text: print_yaml::flow(&scalar(kind, new)),
    });
    true
}

#[cfg(test)]
mod tests {
    use crate::rts_profile::forms::{Profile, Shape};
    use crate::rts_profile::{patch_yaml, read};
    use crate::span::{Span, Text};

    const PROFILE: &str = "# The arm.\nrtsProfile:\n  id: 'RTSystem:a:b:1' # ours\n  mine: [1]\n  version: 0.2\n  components:\n  - {instanceName: A0, isRequired: true, \"pathUri\": \"x\"} # first\n";

    fn edited(edit: impl Fn(&mut Profile)) -> Option<String> {
        let read = read("f.yaml", PROFILE.as_bytes()).unwrap();
        let mut new = read.shape.clone();
        let Shape::V02(profile) = &mut new else {
            panic!("version 0.1")
        };
        edit(profile);
        patch_yaml(&read.source, &read.shape, &new).ok()
    }

    #[test]
    fn only_the_values_change() {
        let text = |text: &str| Some(Text::new(text, Span::default()));
        let new = edited(|profile| {
            profile.id = text("RTSystem:a:c:1");
            profile.components[0].is_required = text("false");
            profile.components[0].path_uri = text("a, b");
        });
        let expected = PROFILE
            .replace("'RTSystem:a:b:1'", "\"RTSystem:a:c:1\"")
            .replace("isRequired: true", "isRequired: false")
            .replace("\"x\"", "\"a, b\"");
        assert_eq!(new.unwrap(), expected);
        assert_eq!(edited(|_| {}).unwrap(), PROFILE);
    }

    #[test]
    fn what_has_no_place_is_not_written() {
        assert_eq!(edited(|profile| profile.components.clear()), None);
        assert_eq!(edited(|profile| profile.version = None), None);
    }
}
