//! IDL of a unit.

use std::fmt::Write;

use rts_schemas::idl::model::*;

/// A module with the definitions of a unit, and `Root` for a type.
pub fn module(name: &str, unit: &Unit, root: &Type) -> String {
    let mut writer = Writer {
        text: format!("module {name} {{\n"),
        arrays: 0,
    };
    for definition in &unit.definitions {
        writer.definition(unit, definition);
    }
    writer.typedef("Root", root);
    writer.text + "};\n"
}

struct Writer {
    text: String,
    /// Arrays have no name in the model, but need one in IDL.
    arrays: usize,
}

impl Writer {
    fn line(&mut self, line: &str) {
        writeln!(self.text, "{line}").unwrap();
    }

    fn definition(&mut self, unit: &Unit, definition: &Definition) {
        let name = definition.path.last().unwrap();
        match &definition.kind {
            Kind::Typedef(it) => self.typedef(name, &it.r#type),
            Kind::Enum(it) => {
                let names = it.enumerators.join(", ");
                self.line(&format!("enum {name} {{ {names} }};"));
            }
            Kind::Struct(it) => {
                let members = it.members.iter();
                let members = members.map(|m| format!("{} {};", self.spec(&m.r#type), m.name));
                let members = members.collect::<Vec<_>>().join(" ");
                self.line(&format!("struct {name} {{ {members} }};"));
            }
            Kind::Union(it) => {
                let switch = self.spec(&it.discriminator);
                let cases = it.cases.iter().map(|case| {
                    let labels = case.labels.iter().map(|label| labelled(unit, label));
                    let labels: String = labels.collect();
                    format!("{labels} {} {};", self.spec(&case.r#type), case.name)
                });
                let cases = cases.collect::<Vec<_>>().join(" ");
                self.line(&format!("union {name} switch ({switch}) {{ {cases} }};"));
            }
            other => panic!("not drawn: {other:?}"),
        }
    }

    fn typedef(&mut self, name: &str, r#type: &Type) {
        let line = match r#type {
            Type::Array {
                element,
                dimensions,
            } => {
                let dimensions: String = dimensions.iter().map(|it| format!("[{it}]")).collect();
                format!("typedef {} {name}{dimensions};", self.spec(element))
            }
            other => format!("typedef {} {name};", self.spec(other)),
        };
        self.line(&line);
    }

    fn spec(&mut self, r#type: &Type) -> String {
        let bounded = |bound: &Option<u32>, before: &str| bound.map(|it| format!("{before}{it}"));
        match r#type {
            Type::Primitive(primitive) => primitive_name(*primitive).to_owned(),
            Type::String { bound } => match bounded(bound, "") {
                Some(bound) => format!("string<{bound}>"),
                None => "string".to_owned(),
            },
            Type::WString { bound } => match bounded(bound, "") {
                Some(bound) => format!("wstring<{bound}>"),
                None => "wstring".to_owned(),
            },
            Type::Sequence { element, bound } => {
                let bound = bounded(bound, ", ").unwrap_or_default();
                format!("sequence<{}{bound} >", self.spec(element))
            }
            Type::Array { .. } => {
                self.arrays += 1;
                let name = format!("A{}", self.arrays);
                self.typedef(&name, r#type);
                name
            }
            Type::Named(index) => format!("T{index}"),
            other => panic!("not drawn: {other:?}"),
        }
    }
}

fn labelled(unit: &Unit, label: &Label) -> String {
    match label {
        Label::Default => "default:".to_owned(),
        Label::Value(ConstantValue::Boolean(true)) => "case TRUE:".to_owned(),
        Label::Value(ConstantValue::Boolean(false)) => "case FALSE:".to_owned(),
        Label::Value(ConstantValue::Integer(number)) => format!("case {number}:"),
        Label::Value(ConstantValue::Char(it)) => format!("case '\\x{:x}':", u32::from(*it)),
        Label::Value(ConstantValue::Enumerator {
            definition,
            ordinal,
        }) => match &unit.definitions[*definition].kind {
            Kind::Enum(it) => format!("case {}:", it.enumerators[*ordinal as usize]),
            other => panic!("no enum: {other:?}"),
        },
        Label::Value(other) => panic!("not drawn: {other:?}"),
    }
}

fn primitive_name(primitive: Primitive) -> &'static str {
    match primitive {
        Primitive::Boolean => "boolean",
        Primitive::Octet => "octet",
        Primitive::Char => "char",
        Primitive::WChar => "wchar",
        Primitive::Short => "short",
        Primitive::UShort => "unsigned short",
        Primitive::Long => "long",
        Primitive::ULong => "unsigned long",
        Primitive::LongLong => "long long",
        Primitive::ULongLong => "unsigned long long",
        Primitive::Float => "float",
        Primitive::Double => "double",
        Primitive::LongDouble => "long double",
    }
}
