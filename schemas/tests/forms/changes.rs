//! Every kind of edit, and which bytes of the file it may touch.

use rts_schemas::form::{Form, Slot, Value, strip_places};
use rts_schemas::span::{Span, Text};
use rts_schemas::xml::Document;
use rts_schemas::xml::document::{Part, PartAttribute};

use super::{Tape, fill};

/// What was changed: the element that it was changed in by its start in the file.
#[derive(Debug)]
pub enum Change {
    /// An attribute has another value, or is gone; its local name.
    Attribute(usize, &'static str, bool),
    /// An element has an attribute more.
    NewAttribute(usize),
    /// The text of an element is another one.
    Text(usize),
    /// An element holds one more.
    Added(usize),
    /// An element is gone.
    Removed(usize),
    /// The second element stands elsewhere in the first.
    Moved(usize, usize),
}

/// Makes one change, if there is anything to change where the tape leads.
pub fn change(form: &mut dyn Form, tape: &mut Tape<'_>) -> Option<Change> {
    let fields = form.form_type().fields;
    // What is empty is passed over at times, so that the way leads to where there is something.
    let filled: Vec<usize> = (0..fields.len())
        .filter(|at| form.value(*at).count() > 0)
        .collect();
    let at = match tape.choose(3) {
        0 => tape.choose(fields.len()),
        _ if filled.is_empty() => tape.choose(fields.len()),
        _ => filled[tape.choose(filled.len())],
    };
    let (here, field) = (form.span().range().start, &fields[at]);
    let attribute = field.kind.is_attribute();
    let change = match form.slot(at)? {
        Slot::Text(slot) => match slot {
            Some(_) if attribute && tape.choose(4) == 3 => {
                *slot = None;
                Change::Attribute(here, field.local, true)
            }
            Some(text) => {
                let start = text.span.range().start;
                text.value = other(&text.value, tape);
                match attribute {
                    true => Change::Attribute(here, field.local, false),
                    false => Change::Text(start),
                }
            }
            None => {
                *slot = Some(Text::new(tape.text(), Span::default()));
                match attribute {
                    true => Change::NewAttribute(here),
                    false => Change::Added(here),
                }
            }
        },
        Slot::Texts(texts) => match tape.choose(3) {
            0 if !texts.is_empty() => {
                let gone = texts.remove(tape.choose(texts.len()));
                Change::Removed(gone.span.range().start)
            }
            1 if texts.len() > 1 => {
                let text = texts.remove(0);
                let start = text.span.range().start;
                texts.push(text);
                Change::Moved(here, start)
            }
            _ => {
                let at = tape.choose(texts.len() + 1);
                texts.insert(at, Text::new(tape.text(), Span::default()));
                Change::Added(here)
            }
        },
        Slot::Forms(forms) => {
            let count = forms.count();
            let index = tape.choose(count.max(1));
            let deeper = tape.choose(4) > 0;
            if deeper && let Some(child) = forms.form_mut(index) {
                return change(child, tape);
            }
            match tape.choose(2) {
                0 if count > 0 => {
                    let start = forms.form(index)?.span().range().start;
                    forms.remove(index);
                    Change::Removed(start)
                }
                _ => {
                    let child = forms.add(tape.choose(count + 1))?;
                    fill(child, tape, 2);
                    strip_places(child);
                    Change::Added(here)
                }
            }
        }
    };
    Some(change)
}

fn other(value: &str, tape: &mut Tape<'_>) -> String {
    let text = tape.text();
    if text == value {
        format!("{text}x")
    } else {
        text
    }
}

/// Moves a component of a profile; generic forms cannot be moved.
pub fn moved<T: Form>(forms: &mut Vec<T>, here: usize, tape: &mut Tape<'_>) -> Option<Change> {
    if forms.len() < 2 {
        return None;
    }
    let from = tape.choose(forms.len());
    let form = forms.remove(from);
    let start = form.span().range().start;
    let mut to = tape.choose(forms.len() + 1);
    if to == from {
        to = if from == 0 { forms.len() } else { 0 };
    }
    forms.insert(to, form);
    Some(Change::Moved(here, start))
}

/// Gives every reference to an instance another name; says how many there are.
pub fn rename(form: &mut dyn Form, old: &str, new: &str) -> usize {
    let mut count = 0;
    for at in 0..form.form_type().fields.len() {
        let is_name = form.form_type().fields[at].local == "instanceName";
        match form.slot(at) {
            Some(Slot::Text(Some(text))) if is_name && text.value == old => {
                text.value = new.to_owned();
                count += 1;
            }
            Some(Slot::Forms(forms)) => {
                for index in 0..forms.count() {
                    if let Some(child) = forms.form_mut(index) {
                        count += rename(child, old, new);
                    }
                }
            }
            _ => {}
        }
    }
    count
}

/// All names of instances.
pub fn instances(form: &dyn Form, all: &mut Vec<String>) {
    for (at, field) in form.form_type().fields.iter().enumerate() {
        match form.value(at) {
            Value::Text(Some(text)) if field.local == "instanceName" => {
                all.push(text.value.clone());
            }
            Value::Forms(forms) => {
                (0..forms.count()).for_each(|index| instances(forms.form(index).unwrap(), all));
            }
            _ => {}
        }
    }
}

/// The element that starts at a place.
pub fn part(from: &Part, start: usize) -> Option<&Part> {
    if from.whole.start == start {
        return Some(from);
    }
    from.children.iter().find_map(|child| part(child, start))
}

/// Every byte that the change does not concern is as it was.
pub fn assert_untouched(document: &Document, new: &str, change: &Change) {
    let old = document.text();
    let find = |start: usize| part(document.root(), start).unwrap();
    let is = |range: std::ops::Range<usize>| {
        let (before, after) = (&old[..range.start], &old[range.end..]);
        new.len() >= before.len() + after.len() && new.starts_with(before) && new.ends_with(after)
    };
    let gone =
        |range: std::ops::Range<usize>| format!("{}{}", &old[..range.start], &old[range.end..]);
    let named = |a: &&PartAttribute, local: &str| {
        let name = old[a.whole.clone()]
            .split(['=', ' ', '\t', '\r', '\n'])
            .next()
            .unwrap();
        name.rsplit(':').next() == Some(local)
    };
    let good = match change {
        Change::Attribute(start, local, removed) => {
            let mut found = find(*start).attributes.iter().filter(|a| named(a, local));
            found.any(|a| match removed {
                true => {
                    let before = old[..a.whole.start].trim_end().len();
                    new == gone(before..a.whole.end)
                }
                false => is(a.value.clone()),
            })
        }
        Change::NewAttribute(start) => {
            let part = find(*start);
            let end = part
                .attributes
                .last()
                .map_or(part.name.end, |a| a.whole.end);
            is(end..end)
        }
        Change::Text(start) => is(find(*start).whole.clone()),
        Change::Removed(start) => new == gone(document.with_lines(find(*start).whole.clone())),
        Change::Added(start) => {
            let part = find(*start);
            match &part.content {
                None => is(part.whole.end - 2..part.whole.end),
                // Somewhere inside, and nothing but more. A prefix may be declared in the start tag.
                Some(content) => {
                    let declared = new.len() > old.len()
                        && new.matches("xmlns").count() > old.matches("xmlns").count();
                    declared
                        || (content.start..=content.end)
                            .any(|at| old.is_char_boundary(at) && is(at..at))
                }
            }
        }
        // One child was taken out and put in elsewhere to the letter, and nothing else. Of two that changed places,
        // either was moved.
        Change::Moved(parent, start) => {
            let parent = find(*parent);
            let outside = new.starts_with(&old[..parent.whole.start])
                && new.ends_with(&old[parent.whole.end..]);
            let moved = |child: &Part| {
                let rest = gone(document.with_lines(child.whole.clone()));
                let before = common(new.bytes(), rest.bytes());
                let after = common(new.bytes().rev(), rest.bytes().rev());
                new.contains(&old[child.whole.clone()]) && before + after >= rest.len()
            };
            find(*start);
            outside && parent.children.iter().any(moved)
        }
    };
    assert!(good, "{change:?}\n--- old\n{old}\n--- new\n{new}");
}

fn common(a: impl Iterator<Item = u8>, b: impl Iterator<Item = u8>) -> usize {
    a.zip(b).take_while(|(a, b)| a == b).count()
}

/// True when what was taken away stands there once more, under whatever prefix.
pub fn stands_twice(document: &Document, change: &Change) -> bool {
    fn parent(from: &Part, start: usize) -> Option<&Part> {
        if from.children.iter().any(|child| child.whole.start == start) {
            return Some(from);
        }
        from.children.iter().find_map(|child| parent(child, start))
    }
    let local = |range: &std::ops::Range<usize>| {
        let name = document.text()[range.clone()]
            .split(['=', ' ', '\t', '\r', '\n'])
            .next();
        name.and_then(|name| name.rsplit(':').next())
            .unwrap()
            .to_owned()
    };
    let count = match change {
        Change::Removed(start) => {
            let name = local(&part(document.root(), *start).unwrap().name);
            let siblings = parent(document.root(), *start).unwrap().children.iter();
            siblings.filter(|child| local(&child.name) == name).count()
        }
        Change::Attribute(start, name, true) => {
            let all = part(document.root(), *start).unwrap().attributes.iter();
            all.filter(|a| local(&a.whole) == *name).count()
        }
        _ => 0,
    };
    count > 1
}
