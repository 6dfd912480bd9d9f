//! IDL → Rust: types that ports carry, for a component's build script and for `rtsctl idl generate`.
//!
//! Names stay as they are in IDL. A module is a module; what is defined within a struct or an interface stands beside it as
//! `Outer_Inner`. Interfaces and exceptions are not written: service ports have no Rust side yet.

mod constant;
mod names;
mod selection;
mod structure;
mod types;
mod union;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use self::names::Names;
use self::selection::Selection;
use super::model::{EnumType, Kind, Unit};

/// A definition that has no Rust type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Its index in the unit.
    pub definition: usize,
    /// Why.
    pub reason: String,
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Code {
    /// Rust source, to be a module or a part of one. The crate that it stands in needs `rts-runtime` and nothing else.
    pub text: String,
    /// What ports cannot carry.
    pub left_out: Vec<LeftOut>,
}

/// Lints that names of IDL, and types that a component does not use, would trip over.
const ALLOW: &str = "#[allow(dead_code, missing_docs, non_camel_case_types, non_snake_case, non_upper_case_globals, clippy::all)]\n";

/// Writes the definitions of the named files, as they were named to the reader, and those that they need.
///
/// Types that `rts_runtime::types` has are used from there.
///
/// `docs/idl.md` has a build script that does it.
pub fn generate(unit: &Unit, files: &[&str]) -> Code {
    let selection = Selection::new(unit, files);
    let writer = Writer {
        names: Names::new(unit, &selection),
        unit,
        selection: &selection,
    };
    let mut root = Module::default();
    for index in selection.written() {
        let text = writer.definition(index);
        let path = writer.names.module(index);
        root.at(path).items.push_str(&text);
    }
    let mut text = HEAD.to_owned();
    root.write(0, &mut text);
    Code {
        text,
        left_out: selection.left_out(),
    }
}

/// The first line.
const HEAD: &str = "// Generated from IDL by rtsctl: change the IDL file, not this one.\n";

/// A module with its text.
#[derive(Debug, Default)]
struct Module {
    items: String,
    modules: BTreeMap<String, Module>,
}

impl Module {
    fn at(&mut self, path: &[String]) -> &mut Self {
        path.iter().fold(self, |module, name| {
            module.modules.entry(name.clone()).or_default()
        })
    }

    fn write(&self, depth: usize, out: &mut String) {
        let indent = "    ".repeat(depth);
        let is_first = out.ends_with("{\n");
        let items = self.items.strip_prefix('\n').filter(|_| is_first);
        for line in items.unwrap_or(&self.items).lines() {
            let _ = match line.is_empty() {
                true => writeln!(out),
                false => writeln!(out, "{indent}{line}"),
            };
        }
        for (name, module) in &self.modules {
            let gap = if out.ends_with("{\n") { "" } else { "\n" };
            let _ = writeln!(out, "{gap}{indent}/// `module {name}`.");
            if depth == 0 {
                out.push_str(ALLOW);
            }
            let _ = writeln!(out, "{indent}pub mod {} {{", names::word(name));
            module.write(depth + 1, out);
            let _ = writeln!(out, "{indent}}}");
        }
    }
}

/// Keeps the guide's build script compiling.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/idl.md")]
struct Guide;

/// What knows everything that a piece of text needs.
struct Writer<'a> {
    unit: &'a Unit,
    names: Names,
    selection: &'a Selection<'a>,
}

impl Writer<'_> {
    /// A definition, with a blank line before it.
    fn definition(&self, index: usize) -> String {
        let definition = &self.unit.definitions[index];
        let allow = if self.names.module(index).is_empty() {
            ALLOW
        } else {
            ""
        };
        let text = match &definition.kind {
            Kind::Struct(found) => self.structure(index, found),
            Kind::Union(found) => self.union(index, found),
            Kind::Enum(found) => self.enumeration(index, found),
            Kind::Typedef(found) => {
                let name = self.names.own(index);
                let r#type = self.r#type(&found.r#type, index);
                format!("pub type {name} = {type};\n", r#type = r#type)
            }
            Kind::Constant(found) => self.constant(index, found),
            Kind::Exception(_) | Kind::Interface(_) | Kind::Forward => return String::new(),
        };
        let bounds = match &definition.kind {
            Kind::Typedef(found) => types::bound(&found.r#type),
            _ => None,
        };
        let bounds = bounds.map_or_else(String::new, |bounds| format!(" {bounds}"));
        format!("\n/// `{}`.{bounds}\n{allow}{text}", definition.name())
    }

    fn enumeration(&self, index: usize, found: &EnumType) -> String {
        let name = self.names.own(index);
        let mut text = format!(
            "#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, {SERDE})]\n\
             #[serde(crate = \"::rts_runtime::serde\")]\npub enum {name} {{\n    #[default]\n"
        );
        for (number, enumerator) in found.enumerators.iter().enumerate() {
            let _ = writeln!(text, "    /// {number}.\n    {},", names::word(enumerator));
        }
        // The attribute of the first one stands before its comment, which Rust allows.
        text.push_str("}\n");
        text
    }
}

/// What makes a type travel.
const SERDE: &str = "::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize";
