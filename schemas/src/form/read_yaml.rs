//! YAML tree → form, by the keys that the reference library `rtsprofile` and RTC Builder write.

use super::allowance::{Allowance, FINDING_LIMIT, too_dense};
use super::{Beside, FieldKind, FieldType, Form, Scalar, Slot, Stray, date};
use crate::diagnostic::{Finding, Report, Source};
use crate::span::{Span, Text};
use crate::suggest;
use crate::xml::{self, Attribute};
use crate::yaml::{Node, Value};

/// Key under which elements and attributes stand that no type knows.
pub(super) const X_XML: &str = "x-xml";

/// Fills a form from a mapping; what has no field is kept beside and reported.
pub fn read_node(node: Node, form: &mut dyn Form, source: &Source, report: &mut Report) {
    let mut reader = Reader {
        allowance: Allowance::of(source.text().len()),
        source,
        report,
    };
    reader.form(node, form);
    if reader.allowance.is_spent() {
        report.push(too_dense());
    }
}

struct Reader<'a> {
    source: &'a Source,
    report: &'a mut Report,
    allowance: Allowance,
}

impl Reader<'_> {
    fn form(&mut self, node: Node, form: &mut dyn Form) {
        form.stand(node.span);
        let fields = form.form_type().fields;
        let span = node.span;
        match node.value {
            Value::Mapping(entries) => {
                if let Some(at) = skipped_level(fields, &entries) {
                    let inner = Node {
                        value: Value::Mapping(entries),
                        span,
                    };
                    if let Some(Slot::Forms(forms)) = form.slot(at) {
                        self.one(inner, fields[at].kind, forms);
                    }
                } else {
                    for (key, value) in entries {
                        if self.allowance.is_spent() {
                            return;
                        }
                        self.entry(key, value, form);
                    }
                }
            }
            Value::Null => {}
            // `waitTime: 300` for `waitTime: {waitTime: 300}`, `or: [...]` for `or: {constraint: [...]}`.
            value => {
                let only = fields.iter().filter(|f| f.local != "type").count() == 1;
                let at = fields.iter().position(|f| only && f.local != "type");
                let node = Node { value, span };
                match at {
                    Some(at) => self.value(Text::new(fields[at].key(), span), node, at, form),
                    None => self.wrong_shape(form.form_type().name, "a mapping", &node),
                }
            }
        }
        form.extra_mut().tidy();
        if !form.extra().is_empty() {
            self.allowance.take(1, size_of::<Beside>());
        }
    }

    fn entry(&mut self, key: Text, value: Node, form: &mut dyn Form) {
        if key.value == X_XML {
            self.unknown_xml(&value, form);
            return;
        }
        let fields = form.form_type().fields;
        if let Some(at) = find(fields, &key.value) {
            self.value(key, value, at, form);
            return;
        }
        // `condition: {waitTime: …}` holds fields of this form.
        let below = |f: &FieldType| f.keys.split_once('/').is_some_and(|(k, _)| k == key.value);
        if fields.iter().any(below)
            && let Value::Mapping(entries) = value.value
        {
            for (inner, value) in entries {
                let path = format!("{}/{}", key.value, inner.value);
                match find(fields, &path) {
                    Some(at) => self.value(inner, value, at, form),
                    None => self.unknown(inner, value, form),
                }
            }
            return;
        }
        self.unknown(key, value, form);
    }

    fn value(&mut self, key: Text, node: Node, at: usize, form: &mut dyn Form) {
        let field = &form.form_type().fields[at];
        if matches!(node.value, Value::Null) {
            return;
        }
        let kind = field.kind;
        match form.slot(at) {
            Some(Slot::Text(slot @ None)) => {
                let text = match kind {
                    FieldKind::Attribute(Scalar::Date) => date(&node),
                    _ => node.text(),
                };
                match text {
                    Some(text) => *slot = Some(text),
                    None if !is_nothing(&node) => self.unknown(key, node, form),
                    None => {}
                }
            }
            Some(Slot::Texts(slot)) => match node.value {
                Value::Sequence(items) => {
                    for item in items {
                        match item.text() {
                            Some(text) => slot.push(text),
                            None if is_nothing(&item) => {}
                            None => self.wrong_shape(&key.value, "a list of texts", &item),
                        }
                    }
                }
                Value::Scalar(text) => slot.push(Text::new(text, node.span)),
                _ => self.wrong_shape(&key.value, "a list", &node),
            },
            Some(Slot::Forms(forms)) => match (kind, node.value) {
                (FieldKind::Some(_) | FieldKind::Many(_), Value::Sequence(items)) => {
                    let size = kind.form_type().map_or(0, |of| of.size);
                    if !self.allowance.take(items.len(), size) {
                        return;
                    }
                    forms.reserve(items.len());
                    for item in items {
                        self.filled(item, forms);
                    }
                }
                (FieldKind::Many(_), value) => {
                    let node = Node {
                        value,
                        span: node.span,
                    };
                    self.wrong_shape(&key.value, "a list", &node);
                }
                (_, value) => {
                    let node = Node {
                        value,
                        span: node.span,
                    };
                    match forms.count() {
                        0 => self.one(node, kind, forms),
                        _ => self.unknown(key, node, form),
                    }
                }
            },
            _ => self.unknown(key, node, form),
        }
    }

    fn one(&mut self, node: Node, kind: FieldKind, forms: &mut dyn super::Filling) {
        let size = kind.form_type().map_or(0, |of| of.size);
        if self.allowance.take(1, size) {
            self.filled(node, forms);
        }
    }

    fn filled(&mut self, node: Node, forms: &mut dyn super::Filling) {
        if self.allowance.is_spent() {
            return;
        }
        if let Some(child) = forms.add(usize::MAX) {
            self.form(node, child);
        }
    }

    fn place(&self, span: Span) -> Option<crate::diagnostic::Place> {
        (!span.is_unknown()).then(|| self.source.place(span.start, span.end))
    }

    fn wrong_shape(&mut self, key: &str, shape: &str, node: &Node) {
        if self.report.findings.len() >= FINDING_LIMIT {
            return self.wrong_again();
        }
        let message = format!("`{key}` must be {shape}, this is {}", node.kind());
        let help = match shape {
            "a list" => "write each item on a line that starts with `- `",
            "a list of texts" => "write one text in each item, in quotes if it holds `: `",
            _ => "write each key on a line of its own, followed by `: ` and its value",
        };
        let finding = Finding::error("wrong-shape", message).at(self.place(node.span));
        self.report.push(finding.help(help));
    }

    /// An error must not be lost among warnings.
    fn wrong_again(&mut self) {
        if !self.report.has_errors() {
            let message = "more is wrong than is listed here";
            let help = "mend what is listed first";
            self.report
                .push(Finding::error("wrong-shape", message).help(help));
        }
    }

    /// Kept as it is. Keys that start with `x-` are for others.
    fn unknown(&mut self, key: Text, value: Node, form: &mut dyn Form) {
        if !key.value.starts_with("x-") && self.report.findings.len() < FINDING_LIMIT {
            let fields = form.form_type().fields.iter();
            let fields = fields.filter(|f| f.local != "type" || !f.keys.contains("::"));
            let known: Vec<&str> = fields.map(|f| bare(f.key())).collect();
            let message = format!("`{}` is not known here and was not read", key.value);
            let finding = Finding::warning("unknown-element", message)
                .at(self.place(key.span))
                .help(suggest::advice(bare(&key.value), "keys", &known));
            self.report.push(finding);
        }
        form.extra_mut().edit().keys.push((key, value));
    }

    /// `x-xml: {attributes: [{name, namespace, value}], elements: ['<…/>'], texts: [...]}`.
    fn unknown_xml(&mut self, node: &Node, form: &mut dyn Form) {
        let list = |key: &str| node.get(key).map_or(&[][..], Node::items);
        for item in list("attributes") {
            let said = |key: &str| item.get(key).and_then(Node::text);
            let (Some(name), Some(value)) = (said("name"), said("value")) else {
                self.wrong_shape(
                    "attributes",
                    "a list of `name`, `namespace` and `value`",
                    item,
                );
                continue;
            };
            form.extra_mut().edit().attributes.push(Attribute {
                namespace: said("namespace").map_or("".into(), |text| text.value.into()),
                qname: name.value.into(),
                value: value.value.into(),
                span: value.span,
            });
        }
        for item in list("elements") {
            let read = item.text().map(|text| xml::parse(&text.value));
            match read {
                Some(Ok(mut element)) => {
                    crate::form::same::forget(&mut element, item.span);
                    let stray = Stray::Element(Box::new(element));
                    form.extra_mut().edit().strays.push(stray);
                }
                Some(Err(_)) if self.report.findings.len() >= FINDING_LIMIT => self.wrong_again(),
                Some(Err(error)) => {
                    let message = format!("`{X_XML}` holds no XML element: {error}");
                    let finding = Finding::error("malformed-xml", message);
                    let place = self.place(item.span);
                    self.report.push(
                        finding
                            .at(place)
                            .help("write one whole element in each item"),
                    );
                }
                None => self.wrong_shape("elements", "a list of texts", item),
            }
        }
        for text in list("texts").iter().filter_map(Node::text) {
            form.extra_mut()
                .edit()
                .strays
                .push(Stray::Text(text.value.into()));
        }
    }
}

/// A field by its key: as it is written, under another known key, or without the part before `::`.
pub(super) fn find(fields: &[FieldType], key: &str) -> Option<usize> {
    let by = |same: &dyn Fn(&str) -> bool| fields.iter().position(|f| f.keys.split('|').any(same));
    let last = |known: &str| known.rsplit('/').next().unwrap_or_default().to_owned();
    by(&|known| known == key)
        .or_else(|| by(&|known| bare(known) == bare(key)))
        .or_else(|| by(&|known| known.contains('/') && last(known) == key))
}

/// The part after `rtsExt::`.
fn bare(key: &str) -> &str {
    key.rsplit("::").next().unwrap_or(key)
}

/// Where old files leave a level away: no key is known here, and all are known to the only type that lies below.
fn skipped_level(fields: &[FieldType], entries: &[(Text, Node)]) -> Option<usize> {
    if entries.is_empty()
        || entries
            .iter()
            .any(|(key, _)| find(fields, &key.value).is_some())
    {
        return None;
    }
    let below = |f: &FieldType| match f.kind {
        FieldKind::One(of) => entries.iter().all(|(key, _)| {
            !key.value.starts_with("x-") && find(of().fields, &key.value).is_some()
        }),
        _ => false,
    };
    let mut fitting = (0..fields.len()).filter(|at| below(&fields[*at]));
    // Where several would do, nobody knows which was left away.
    fitting.next().filter(|_| fitting.next().is_none())
}

fn is_nothing(node: &Node) -> bool {
    match &node.value {
        Value::Null => true,
        Value::Mapping(entries) => entries.iter().all(|(_, node)| is_nothing(node)),
        _ => false,
    }
}

/// A date is a text or a mapping of its parts; it is only shown, so it need not be valid.
fn date(node: &Node) -> Option<Text> {
    if let Some(text) = node.text() {
        return Some(text);
    }
    let known = |(key, value): &(Text, Node)| {
        date::PARTS.contains(&key.value.as_str())
            && matches!(value.value, Value::Scalar(_) | Value::Null)
    };
    if is_nothing(node) || !node.entries().iter().all(known) {
        return None;
    }
    let part = |name: &str| node.get(name).and_then(Node::text).map(|text| text.value);
    Some(Text::new(date::text(part), node.span))
}
