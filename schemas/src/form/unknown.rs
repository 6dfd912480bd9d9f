//! What a profile says that its type has no field for: a misspelt element would silently lose what is in it.

use super::allowance::FINDING_LIMIT;
use super::read_xml::is_single;
use super::{Form, FormType, Stray, Value, Vocabulary};
use crate::diagnostic::{Finding, Report, Source};
use crate::suggest;
use crate::xml::Element;

/// Warns of elements in a namespace of the profile that have no field where they stand.
pub fn report_unknown(form: &dyn Form, words: &Vocabulary, source: &Source, report: &mut Report) {
    let kind = form.form_type();
    for stray in &form.extra().get().strays {
        if let Stray::Element(element) = stray
            && words.knows(&element.namespace)
        {
            if report.findings.len() >= FINDING_LIMIT {
                return;
            }
            report.push(unknown_element(element, kind, source));
        }
    }
    for at in 0..kind.fields.len() {
        if let Value::Forms(forms) = form.value(at) {
            for child in (0..forms.count()).filter_map(|index| forms.form(index)) {
                report_unknown(child, words, source, report);
            }
        }
    }
}

fn unknown_element(element: &Element, kind: &FormType, source: &Source) -> Finding {
    let place = Some(source.place(element.span.start, element.span.end));
    let fields = kind.fields.iter().filter(|f| !f.kind.is_attribute());
    let known = fields
        .clone()
        .find(|f| f.local == element.local() && *f.namespace == *element.namespace);
    let finding = match known {
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
    };
    finding.at(place)
}
