//! Any bytes as an IDL file, which may include a guarded one and itself: what is read refers to what is there.
#![no_main]

#[path = "../laws.rs"]
mod laws;

use libfuzzer_sys::fuzz_target;
use rts_schemas::diagnostic::render;
use rts_schemas::idl::{Found, Include, Kind, Sources, Type, Unit, read, rust};

const COMMON: &str = "#ifndef A\n#define A\nmodule A { struct B { long c; }; };\n#endif\n";

struct Files<'a>(&'a [u8]);

impl Sources for Files<'_> {
    fn find(&self, include: Include<'_>) -> Result<Option<Found>, String> {
        let bytes = match include.name {
            "a" => COMMON.as_bytes(),
            "f" => self.0,
            _ => return Ok(None),
        };
        let path = include.name.to_owned();
        Ok(Some(Found { path, bytes: bytes.to_vec() }))
    }
}

/// Every type that a definition is made of.
fn types(kind: &Kind) -> Vec<&Type> {
    match kind {
        Kind::Struct(found) => found.members.iter().map(|m| &m.r#type).collect(),
        Kind::Exception(found) => found.members.iter().map(|m| &m.r#type).collect(),
        Kind::Union(found) => found.cases.iter().map(|c| &c.r#type).chain([&found.discriminator]).collect(),
        Kind::Typedef(found) => vec![&found.r#type],
        Kind::Constant(found) => vec![&found.r#type],
        Kind::Interface(found) => {
            let parameters = found.operations.iter().flat_map(|o| o.parameters.iter().map(|p| &p.r#type).chain(&o.result));
            parameters.chain(found.attributes.iter().map(|a| &a.r#type)).collect()
        }
        Kind::Enum(_) | Kind::Forward => Vec::new(),
    }
}

fn is_there(found: &Type, unit: &Unit) -> bool {
    match found {
        Type::Sequence { element, .. } | Type::Array { element, .. } => is_there(element, unit),
        Type::Named(index) => *index < unit.definitions.len(),
        _ => true,
    }
}

fuzz_target!(|bytes: &[u8]| {
    let includes = bytes.windows(8).filter(|word| word == b"#include" || word == b"include ").count();
    let read = match includes {
        // What is included may be larger than what includes it.
        0 => laws::bounded(bytes, |bytes| read("f", bytes, &Files(bytes))),
        _ => read("f", bytes, &Files(bytes)),
    };
    let read = match read {
        Ok(read) => read,
        Err(report) => {
            assert!(report.has_errors());
            for finding in &report.findings {
                assert!(!render(finding).contains('\u{1b}'));
                assert!(finding.help.is_some());
            }
            return;
        }
    };
    let _ = rust::generate(&read.unit, &["f"]);
    for definition in &read.unit.definitions {
        assert!(types(&definition.kind).into_iter().all(|found| is_there(found, &read.unit)));
        let found = read.unit.find(&definition.name()).expect("it has its name");
        assert!(found < read.unit.definitions.len());
    }
});
