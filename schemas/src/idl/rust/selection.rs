//! Which definitions are written, and why others are not.

use std::collections::BTreeSet;

use super::super::model::{Constant, Definition, Kind, Primitive, Type, Unit};
use super::LeftOut;
use crate::idl::{self, Standard};

/// Types that `rts_runtime::types` has by hand, by the ends of their repository ids. The others of OpenRTM are generated.
const BY_HAND: [&str; 13] = [
    "Time",
    "TimedBoolean",
    "TimedDouble",
    "TimedDoubleSeq",
    "TimedFloat",
    "TimedFloatSeq",
    "TimedLong",
    "TimedLongSeq",
    "TimedOctet",
    "TimedOctetSeq",
    "TimedShort",
    "TimedShortSeq",
    "TimedString",
];

/// Which definitions `rts_runtime::types` has: those of OpenRTM's files. They are generated only where those files
/// themselves are asked for.
fn known(unit: &Unit, files: &[&str]) -> Vec<bool> {
    let openrtm = openrtm();
    let openrtm: BTreeSet<&str> = openrtm.definitions.iter().filter_map(name).collect();
    let known = |definition: &Definition| {
        name(definition).is_some_and(|name| {
            BY_HAND.contains(&name)
                || openrtm.contains(name) && !files.contains(&definition.file.as_str())
        })
    };
    unit.definitions.iter().map(known).collect()
}

fn name(definition: &Definition) -> Option<&str> {
    let id = definition.repository_id.strip_prefix("IDL:RTC/")?;
    id.strip_suffix(":1.0")
}

/// What OpenRTM's files define.
fn openrtm() -> Unit {
    let include = |(name, _)| format!("#include <{name}>\n");
    let text: String = Standard::files().map(include).collect();
    // They are read without a mistake, which tests see to.
    idl::read("openrtm.idl", text.as_bytes(), &idl::standard())
        .map(|read| read.unit)
        .unwrap_or_default()
}

/// A choice of definitions.
#[derive(Debug)]
pub(super) struct Selection<'a> {
    unit: &'a Unit,
    /// `rts_runtime::types` has it.
    known: Vec<bool>,
    /// Of the files, and what those need.
    chosen: BTreeSet<usize>,
    /// Why a definition has no Rust type.
    reasons: Vec<Option<String>>,
}

impl<'a> Selection<'a> {
    pub fn new(unit: &'a Unit, files: &[&str]) -> Self {
        let own = |definition: &Definition| files.contains(&definition.file.as_str());
        let all = unit.definitions.iter().enumerate();
        let mut open: Vec<usize> = all
            .filter(|(_, found)| own(found))
            .map(|(index, _)| index)
            .collect();
        let known = known(unit, files);
        let mut chosen = BTreeSet::new();
        while let Some(index) = open.pop() {
            if !known[index] && chosen.insert(index) {
                open.extend(needs(&unit.definitions[index].kind));
            }
        }
        let mut selection = Self {
            unit,
            known,
            chosen,
            reasons: unit
                .definitions
                .iter()
                .map(|found| lacks(&found.kind, unit))
                .collect(),
        };
        selection.spread();
        selection
    }

    /// What is made of something that has no Rust type has none either.
    fn spread(&mut self) {
        loop {
            let mut more = Vec::new();
            for (index, definition) in self.unit.definitions.iter().enumerate() {
                if self.reasons[index].is_some() {
                    continue;
                }
                let without = needs(&definition.kind)
                    .into_iter()
                    .find(|other| self.reasons[*other].is_some());
                if let Some(other) = without {
                    more.push((
                        index,
                        format!(
                            "`{}` cannot be carried",
                            self.unit.definitions[other].name()
                        ),
                    ));
                }
            }
            if more.is_empty() {
                return;
            }
            for (index, reason) in more {
                self.reasons[index] = Some(reason);
            }
        }
    }

    /// The name in `rts_runtime::types` of a definition that is there.
    pub fn known(&self, index: usize) -> Option<&str> {
        let path = &self.unit.definitions[index].path;
        path.last()
            .filter(|_| self.known[index])
            .map(String::as_str)
    }

    /// True when a definition is written.
    pub fn writes(&self, index: usize) -> bool {
        let kind = &self.unit.definitions[index].kind;
        let is_type = !matches!(
            kind,
            Kind::Interface(_) | Kind::Exception(_) | Kind::Forward
        );
        is_type && self.chosen.contains(&index) && self.reasons[index].is_none()
    }

    /// All that are written.
    pub fn written(&self) -> impl Iterator<Item = usize> {
        self.chosen
            .iter()
            .copied()
            .filter(|index| self.writes(*index))
    }

    /// Those that ports cannot carry.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let types = self.chosen.iter().filter(|index| {
            let kind = &self.unit.definitions[**index].kind;
            !matches!(
                kind,
                Kind::Interface(_) | Kind::Exception(_) | Kind::Forward
            )
        });
        let left_out = types.filter_map(|index| {
            let reason = self.reasons[*index].clone()?;
            Some(LeftOut {
                definition: *index,
                reason,
            })
        });
        left_out.collect()
    }

    /// True when a value of a type may hold another of the definition.
    pub fn reaches(&self, r#type: &Type, definition: usize) -> bool {
        let mut seen = BTreeSet::new();
        let mut open = named(r#type);
        while let Some(index) = open.pop() {
            if index == definition {
                return true;
            }
            if seen.insert(index) {
                open.extend(needs(&self.unit.definitions[index].kind));
            }
        }
        false
    }
}

/// The definitions that a type names.
fn named(r#type: &Type) -> Vec<usize> {
    match r#type {
        Type::Named(index) => vec![*index],
        Type::Sequence { element, .. } | Type::Array { element, .. } => named(element),
        _ => Vec::new(),
    }
}

/// The types that a definition is made of.
fn types(kind: &Kind) -> Vec<&Type> {
    match kind {
        Kind::Struct(found) => found.members.iter().map(|member| &member.r#type).collect(),
        Kind::Union(found) => {
            let cases = found.cases.iter().map(|case| &case.r#type);
            cases.chain([&found.discriminator]).collect()
        }
        Kind::Typedef(found) => vec![&found.r#type],
        Kind::Constant(Constant { r#type, .. }) => vec![r#type],
        Kind::Enum(_) | Kind::Exception(_) | Kind::Interface(_) | Kind::Forward => Vec::new(),
    }
}

fn needs(kind: &Kind) -> Vec<usize> {
    types(kind).into_iter().flat_map(named).collect()
}

/// What ports cannot carry in a definition itself.
fn lacks(kind: &Kind, unit: &Unit) -> Option<String> {
    let reason = match kind {
        Kind::Interface(_) => {
            return Some("a reference to an interface cannot be carried".to_owned());
        }
        Kind::Forward => return Some("it is announced only".to_owned()),
        Kind::Constant(_) => return None,
        _ => types(kind)
            .into_iter()
            .find_map(|found| uncarried(found, unit))?,
    };
    Some(format!("{reason} cannot be carried"))
}

fn uncarried(r#type: &Type, unit: &Unit) -> Option<String> {
    let name = match r#type {
        Type::Primitive(Primitive::LongDouble) => "`long double`",
        Type::Any => "`any`",
        Type::Object => "`Object`",
        Type::Sequence { element, .. } | Type::Array { element, .. } => {
            return uncarried(element, unit);
        }
        Type::Named(index) if matches!(unit.definitions[*index].kind, Kind::Interface(_)) => {
            return Some(format!(
                "a reference to `{}`",
                unit.definitions[*index].name()
            ));
        }
        _ => return None,
    };
    Some(name.to_owned())
}
