//! Unions: an enum with a variant for each case.
//!
//! A variant with one label holds its member. One with several, or with `default`, holds the value that chose it too. Where
//! some values choose nothing, a variant `otherwise` holds such a value.

use std::fmt::Write as _;

use super::super::model::{Kind, Label, Primitive, Type, Union, UnionCase};
use super::{Writer, names};

/// Names of traits, short enough to read the code.
const USE: &str = "use ::rts_runtime::serde::";

impl Writer<'_> {
    pub(super) fn union(&self, index: usize, found: &Union) -> String {
        let name = self.names.own(index);
        let cases: Vec<Case<'_>> = found
            .cases
            .iter()
            .map(|case| self.case(index, case, found))
            .collect();
        let labels: Vec<&str> = cases
            .iter()
            .flat_map(|case| case.labels.iter().map(String::as_str))
            .collect();
        let has_default = cases.iter().any(|case| case.is_default);
        let others = (!has_default && labels.len() < self.values(found)).then(|| {
            let mut name = "otherwise".to_owned();
            while found.cases.iter().any(|case| case.name == name) {
                name.push('_');
            }
            name
        });
        let decides = self.r#type(&found.discriminator, index);
        let mut text = format!("#[derive(Debug, Clone, PartialEq)]\npub enum {name} {{\n");
        for case in &cases {
            let chosen = if case.holds_label() {
                format!("{decides}, ")
            } else {
                String::new()
            };
            let _ = writeln!(
                text,
                "    /// {}\n    {}({chosen}{}),",
                case.said(),
                case.name,
                case.r#type
            );
        }
        if let Some(others) = &others {
            let _ = writeln!(
                text,
                "    /// Any other value: nothing is with it.\n    {others}({decides}),"
            );
        }
        text.push_str("}\n");
        text += &self.default_case(&name, &cases, others.as_deref());
        text += &serialize(&name, &decides, &cases, &labels, others.as_deref());
        text += &deserialize(&name, &decides, &cases, others.as_deref());
        text + &self.data_type(index)
    }

    fn case<'a>(&self, index: usize, case: &'a UnionCase, union: &Union) -> Case<'a> {
        let labels = case.labels.iter().filter_map(|label| match label {
            Label::Value(value) => Some(self.value(value, &union.discriminator, index)),
            Label::Default => None,
        });
        let r#type = self.r#type(&case.r#type, index);
        Case {
            labels: labels.collect(),
            is_default: case.labels.contains(&Label::Default),
            is_nested: self.selection.reaches(&case.r#type, index),
            name: names::word(&case.name),
            r#type,
            case,
        }
    }

    /// How many values the type that decides has, if they may all have a label.
    fn values(&self, found: &Union) -> usize {
        match self.without_alias(&found.discriminator) {
            Type::Primitive(Primitive::Boolean) => 2,
            Type::Primitive(Primitive::Char) => 256,
            Type::Named(index) => match &self.unit.definitions[*index].kind {
                Kind::Enum(found) => found.enumerators.len(),
                _ => usize::MAX,
            },
            _ => usize::MAX,
        }
    }

    /// The first case that has a label, else the one without.
    fn default_case(&self, name: &str, cases: &[Case<'_>], others: Option<&str>) -> String {
        const ZERO: &str = "::core::default::Default::default()";
        let value = match cases.iter().find(|case| !case.labels.is_empty()) {
            Some(case) if case.holds_label() => {
                format!("{}({}, {ZERO})", case.name, case.labels[0])
            }
            Some(case) => format!("{}({ZERO})", case.name),
            None => match (cases.first(), others) {
                (Some(case), _) => format!("{}({ZERO}, {ZERO})", case.name),
                (None, others) => format!("{}({ZERO})", others.unwrap_or_default()),
            },
        };
        format!(
            "\nimpl ::core::default::Default for {name} {{\n    fn default() -> Self {{\n        Self::{value}\n    }}\n}}\n"
        )
    }
}

/// A case as Rust has it.
struct Case<'a> {
    labels: Vec<String>,
    is_default: bool,
    /// It may hold another union of the kind.
    is_nested: bool,
    name: String,
    r#type: String,
    case: &'a UnionCase,
}

impl Case<'_> {
    /// The variant holds the value that chose it, since several do.
    fn holds_label(&self) -> bool {
        self.is_default || self.case.labels.len() > 1
    }

    fn said(&self) -> String {
        let mut labels: Vec<String> = self
            .labels
            .iter()
            .map(|label| format!("`case {label}`"))
            .collect();
        if self.is_default {
            labels.push("`default`".to_owned());
        }
        format!("{}.", labels.join(", "))
    }
}

fn serialize(
    name: &str,
    decides: &str,
    cases: &[Case<'_>],
    labels: &[&str],
    others: Option<&str>,
) -> String {
    let mut text = format!(
        "\nimpl ::rts_runtime::serde::Serialize for {name} {{\n    \
         fn serialize<__S: ::rts_runtime::serde::Serializer>(&self, __to: __S) -> ::core::result::Result<__S::Ok, __S::Error> {{\n        \
         {USE}ser::SerializeTuple as _;\n        let mut __to = __to.serialize_tuple(2)?;\n        match self {{\n"
    );
    let wrong = "return ::core::result::Result::Err(::rts_runtime::serde::ser::Error::custom(\"the value does not choose this case\"))";
    for case in cases {
        if !case.holds_label() {
            let _ = writeln!(
                text,
                "            Self::{}(__value) => {{\n                let __label: {decides} = {};\n                __to.serialize_element(&__label)?;\n                __to.serialize_element(__value)?;\n            }}",
                case.name,
                case.labels.first().map_or("", String::as_str),
            );
            continue;
        }
        let own = case.labels.join(" | ");
        let strange: Vec<&str> = labels
            .iter()
            .copied()
            .filter(|label| !case.labels.iter().any(|own| own == label))
            .collect();
        let guard = match (case.is_default, strange.is_empty()) {
            (true, true) => String::new(),
            (true, false) => format!(
                "                if matches!(__label, {}) {{\n                    {wrong};\n                }}\n",
                strange.join(" | ")
            ),
            (false, _) => format!(
                "                if !matches!(__label, {own}) {{\n                    {wrong};\n                }}\n"
            ),
        };
        let _ = writeln!(
            text,
            "            Self::{}(__label, __value) => {{\n{guard}                __to.serialize_element(__label)?;\n                __to.serialize_element(__value)?;\n            }}",
            case.name
        );
    }
    if let Some(others) = others {
        let _ = writeln!(
            text,
            "            Self::{others}(__label) => {{\n                if matches!(__label, {}) {{\n                    {wrong};\n                }}\n                __to.serialize_element(__label)?;\n            }}",
            labels.join(" | ")
        );
    }
    text.push_str("        }\n        __to.end()\n    }\n}\n");
    text
}

fn deserialize(name: &str, decides: &str, cases: &[Case<'_>], others: Option<&str>) -> String {
    let mut text = format!(
        "\nimpl<'de> ::rts_runtime::serde::Deserialize<'de> for {name} {{\n    \
         fn deserialize<__D: ::rts_runtime::serde::Deserializer<'de>>(__from: __D) -> ::core::result::Result<Self, __D::Error> {{\n        \
         struct __Parts;\n\n        impl<'de> ::rts_runtime::serde::de::Visitor<'de> for __Parts {{\n            \
         type Value = {name};\n\n            \
         fn expecting(&self, __to: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {{\n                \
         __to.write_str(\"a union\")\n            }}\n\n            \
         fn visit_seq<__A: ::rts_runtime::serde::de::SeqAccess<'de>>(self, mut __from: __A) -> ::core::result::Result<{name}, __A::Error> {{\n                \
         {USE}de::Error as _;\n                \
         let __short = || __A::Error::custom(\"the union ends too early\");\n                \
         let __label: {decides} = __from.next_element()?.ok_or_else(__short)?;\n                ::core::result::Result::Ok(match __label {{\n"
    );
    let member = |case: &Case<'_>| {
        let next = match case.is_nested {
            true => {
                "__from.next_element::<::rts_runtime::types::Nested<_>>()?.ok_or_else(__short)?.0"
            }
            false => "__from.next_element()?.ok_or_else(__short)?",
        };
        match case.holds_label() {
            true => format!("{name}::{}(__label, {next})", case.name),
            false => format!("{name}::{}({next})", case.name),
        }
    };
    for case in cases.iter().filter(|case| !case.is_default) {
        let _ = writeln!(
            text,
            "                    {} => {},",
            case.labels.join(" | "),
            member(case)
        );
    }
    if let Some(case) = cases.iter().find(|case| case.is_default) {
        let _ = writeln!(text, "                    _ => {},", member(case));
    } else if let Some(others) = others {
        let _ = writeln!(text, "                    _ => {name}::{others}(__label),");
    }
    text.push_str(
        "                })\n            }\n        }\n\n        __from.deserialize_tuple(2, __Parts)\n    }\n}\n",
    );
    text
}
