//! What a profile says that its type has no field for, or says otherwise than its schema has it: a misspelt element or
//! attribute would silently lose what it says.

use super::allowance::FINDING_LIMIT;
use super::place::{Scope, XML_NAMESPACE, declared_prefix, prefix_of};
use super::read_xml::is_single;
use super::{Form, FormType, Stray, Value, Vocabulary};
use crate::diagnostic::{Finding, Report, Source};
use crate::span::Span;
use crate::suggest;
use crate::xml::{Attribute, Element};

/// Warns of everything in a form that was not read, or that is not spelled as the schema has it.
pub fn report_unknown(form: &dyn Form, words: &Vocabulary, source: &Source, report: &mut Report) {
    let mut unknown = Unknown {
        words,
        source,
        report,
        scope: Scope::default(),
    };
    unknown.form(form);
}

struct Unknown<'a> {
    words: &'a Vocabulary,
    source: &'a Source,
    report: &'a mut Report,
    /// Which prefix stands for which namespace here.
    scope: Scope,
}

impl Unknown<'_> {
    fn form(&mut self, form: &dyn Form) {
        let depth = self.scope.depth();
        self.scope.enter(&form.extra().get().attributes);
        self.unprefixed(form);
        for attribute in &form.extra().get().attributes {
            if self.is_meant_for_us(attribute) {
                self.say(attribute.span, || unknown_attribute(attribute, form));
            }
        }
        for stray in &form.extra().get().strays {
            match stray {
                Stray::Element(element) if self.words.knows(&element.namespace) => {
                    self.say(element.span, || unknown_element(element, form.form_type()));
                }
                Stray::Text(text) => self.text(text, form),
                Stray::Element(_) | Stray::Comment(_) | Stray::Instruction(_) => {}
            }
        }
        for at in 0..form.form_type().fields.len() {
            if let Value::Forms(forms) = form.value(at) {
                for child in (0..forms.count()).filter_map(|index| forms.form(index)) {
                    self.form(child);
                }
            }
        }
        self.scope.leave(depth);
    }

    fn say(&mut self, span: Span, finding: impl FnOnce() -> Finding) {
        if self.report.findings.len() < FINDING_LIMIT {
            let place = (!span.is_unknown()).then(|| self.source.place(span.start, span.end));
            self.report.push(finding().at(place));
        }
    }

    /// Declarations, what every XML document may have, and what is in a namespace of its own mean nothing here.
    fn is_meant_for_us(&self, attribute: &Attribute) -> bool {
        let namespace = &*attribute.namespace;
        let general = declared_prefix(&attribute.qname).is_some()
            || namespace == XML_NAMESPACE
            || is_of_schemas(namespace);
        !general && (namespace.is_empty() || self.words.knows(namespace))
    }

    /// Attributes that were read though they stand in no namespace, or in a related one: once for an element.
    fn unprefixed(&mut self, form: &dyn Form) {
        let beside = form.extra().get();
        let fields = form.form_type().fields;
        let mut spelled = Vec::new();
        for place in &beside.attribute_order {
            let (Some(name), Some(at)) = (beside.spelling(*place), place.field()) else {
                continue;
            };
            let Some(field) = fields.get(at) else {
                continue;
            };
            let prefix = prefix_of(name);
            let foreign =
                prefix.is_empty() || self.scope.namespace(prefix) != Some(field.namespace);
            if let Value::Text(Some(text)) = form.value(at)
                && foreign
            {
                let usual = format!("{}:{}", self.words.prefix(field.namespace), field.local);
                spelled.push((name, usual, text.span));
            }
        }
        let Some((name, usual, span)) = spelled.first() else {
            return;
        };
        let names: Vec<String> = spelled
            .iter()
            .map(|(name, ..)| format!("`{name}`"))
            .collect();
        let names = suggest::listed(names.iter().map(String::as_str));
        let message = match spelled.len() {
            1 => format!("{names} does not have the prefix of the schema; it is read as `{usual}`"),
            _ => format!(
                "{names} do not have the prefixes of the schema; they are read all the same"
            ),
        };
        let help = format!("write `{usual}` for `{name}`: other tools may pass over it");
        self.say(*span, || {
            Finding::warning("unprefixed-attribute", message).help(help)
        });
    }

    fn text(&mut self, text: &str, form: &dyn Form) {
        let Some(line) = text.lines().map(str::trim).find(|line| !line.is_empty()) else {
            return;
        };
        let span = self.find(line, form.span());
        let told: String = line.chars().take(40).collect();
        let dots = if told.len() < line.len() { "…" } else { "" };
        self.say(span, || {
            let message =
                format!("the text `{told}{dots}` stands between elements and was not read");
            Finding::warning("stray-text", message)
                .help("remove it, or write it as a comment: `<!-- … -->`")
        });
    }

    /// Where a text stands in an element; the element's start when it is not there as it was read.
    fn find(&self, line: &str, element: Span) -> Span {
        // Text that was written with references is not found, and is not looked for in all of a large file.
        const WINDOW: usize = 1 << 20;
        let text = self.source.text();
        let Ok(start) = usize::try_from(element.start) else {
            return element;
        };
        let end = text.floor_char_boundary(start.saturating_add(WINDOW).min(text.len()));
        let found = text.get(start..end).and_then(|inside| {
            let after = inside.find('>')?;
            let at = inside.get(after..)?.find(line)?;
            Some(start + after + at)
        });
        found.map_or(element, |at| Span::new(at, at + line.len()))
    }
}

/// `xsi:schemaLocation` and the like.
fn is_of_schemas(namespace: &str) -> bool {
    namespace == "http://www.w3.org/2001/XMLSchema-instance"
}

fn unknown_attribute(attribute: &Attribute, form: &dyn Form) -> Finding {
    let fields = form.form_type().fields.iter();
    let mut fields = fields.filter(|f| f.kind.is_attribute());
    let message = format!(
        "the attribute `{}` is not known here and was not read",
        attribute.qname
    );
    let finding = Finding::warning("unknown-attribute", message);
    if fields.clone().any(|f| f.local == attribute.local()) {
        return finding.help("another attribute says the same, and counts; remove one of them");
    }
    match suggest::nearest(attribute.local(), fields.by_ref().map(|f| f.local)) {
        Some(near) => finding.help(format!("did you mean `{near}`?")),
        None => finding.help("remove it if it means nothing"),
    }
}

fn unknown_element(element: &Element, kind: &FormType) -> Finding {
    let fields = kind.fields.iter().filter(|f| !f.kind.is_attribute());
    let known = fields
        .clone()
        .find(|f| f.local == element.local() && *f.namespace == *element.namespace);
    match known {
        Some(field) if is_single(field.kind) => Finding::warning(
            "repeated-element",
            format!(
                "`<{}>` stands here more than once; the first one counts",
                element.qname
            ),
        )
        .help("remove the others"),
        Some(_) => Finding::warning(
            "unknown-element",
            format!(
                "`<{}>` holds more than text and was not read",
                element.qname
            ),
        )
        .help("write nothing but text in it"),
        None => {
            let finding = Finding::warning(
                "unknown-element",
                format!("`<{}>` is not known here and was not read", element.qname),
            );
            match suggest::nearest(element.local(), fields.map(|f| f.local)) {
                Some(near) => finding.help(format!("did you mean `{near}`?")),
                None => finding.help("remove it if it means nothing"),
            }
        }
    }
}
