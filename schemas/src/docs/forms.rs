//! The documentation of profiles, from their forms.

use super::facts::parted;
use super::{Docs, Field, Inner, Root};
use crate::form::{FieldKind, FieldType, FormType, Scalar, Vocabulary};
use crate::rtc_profile::{self, forms::RtcProfile};
use crate::rts_profile::{self, forms::Profile, forms::v01};

pub(super) const ROOTS: &[Root] = &[
    Root {
        name: "system",
        others: &["RtsProfile", "rts:RtsProfile", "RTSystemProfile"],
        title: "RTS Profile 0.2",
        written: "<rts:RtsProfile>, in YAML rtsProfile:",
        version: Some("0.2"),
        docs: || of(Profile::form_type(), &rts_profile::forms::WORDS),
    },
    Root {
        name: "system",
        others: &["RtsProfile", "rts:RtsProfile", "RTSystemProfile"],
        title: "RTS Profile 0.1",
        written: "<rts:RtsProfile>, in YAML rtsProfile:",
        version: Some("0.1"),
        docs: || of(v01::Profile::form_type(), &rts_profile::forms::WORDS),
    },
    Root {
        name: "component",
        others: &["RtcProfile", "rtc:RtcProfile"],
        title: "RTC Profile",
        written: "<rtc:RtcProfile>, in YAML rtcProfile:",
        version: None,
        docs: || of(RtcProfile::form_type(), &rtc_profile::forms::WORDS),
    },
    Root {
        name: "overlay",
        others: &["Deployment"],
        title: "Deployment overlay",
        written: "apiVersion: rtsctl.dev/v1, kind: Deployment, in YAML",
        version: None,
        docs: super::overlay::deployment,
    },
];

/// What is said of a form.
fn of(form: &'static FormType, words: &'static Vocabulary) -> Docs {
    let fields = form.fields.iter();
    Docs {
        name: form.name.to_owned(),
        text: parted(form.doc).0,
        fields: fields.map(|field| field_of(field, form, words)).collect(),
    }
}

fn field_of(
    field: &'static FieldType,
    form: &'static FormType,
    words: &'static Vocabulary,
) -> Field {
    let (text, facts) = parted(field.doc);
    let key = field.key();
    let short = short(key);
    let is_mine = form
        .fields
        .iter()
        .filter(|other| self::short(other.key()) == short)
        .count()
        == 1;
    let name = if is_mine { short } else { key };
    let prefix = words.prefix(field.namespace);
    let others = field
        .keys
        .split('|')
        .flat_map(|key| [key, self::short(key)]);
    let others = others
        .chain([field.local, field.name])
        .filter(|other| *other != name);
    Field {
        name: name.to_owned(),
        others: others.map(str::to_owned).collect(),
        xml: Some(match field.kind {
            FieldKind::Attribute(_) => format!("{prefix}:{}", field.local),
            _ => format!("<{prefix}:{}>", field.local),
        }),
        yaml: (key != name).then(|| key.replace('/', ": ")),
        kind: kind(field.kind),
        text,
        facts,
        inner: field
            .kind
            .form_type()
            .map(|form| Inner::new(move || of(form, words))),
    }
}

/// The last part of a key: `location` of `rtsExt::location`, `waitTime` of `condition/waitTime`.
fn short(key: &str) -> &str {
    let key = key.rsplit('/').next().unwrap_or(key);
    key.rsplit("::").next().unwrap_or(key)
}

fn kind(kind: FieldKind) -> String {
    match kind {
        FieldKind::Attribute(Scalar::Text) | FieldKind::Text => "string".to_owned(),
        FieldKind::Attribute(Scalar::Number) => "number".to_owned(),
        FieldKind::Attribute(Scalar::Boolean) => "boolean".to_owned(),
        FieldKind::Attribute(Scalar::Date) => "date".to_owned(),
        FieldKind::Texts => "[]string".to_owned(),
        FieldKind::One(of) => of().name.to_owned(),
        FieldKind::Some(of) | FieldKind::Many(of) => format!("[]{}", of().name),
    }
}
