//! Names of IDL in Rust, and where they are.

use std::collections::{BTreeMap, BTreeSet};

use super::super::model::{Kind, Unit};
use super::selection::Selection;

/// Words that a raw identifier can be.
const KEYWORDS: [&str; 49] = [
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "do", "dyn",
    "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let",
    "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return",
    "static", "struct", "trait", "true", "try", "type", "typeof", "union", "unsafe", "unsized",
    "use", "virtual", "where", "while", "yield",
];

/// Words that nothing can be called.
const RESERVED: [&str; 4] = ["Self", "crate", "self", "super"];

/// Types that Rust has without a path. Code that serde derives names them so, and must not find another in their place.
const PRIMITIVES: [&str; 17] = [
    "bool", "char", "f32", "f64", "i128", "i16", "i32", "i64", "i8", "isize", "str", "u128", "u16",
    "u32", "u64", "u8", "usize",
];

/// The name of a type or a module, which stands for nothing that Rust has itself.
fn own_type(name: &str) -> String {
    let end = if PRIMITIVES.contains(&name) { "_" } else { "" };
    format!("{name}{end}")
}

/// A name as Rust writes it.
pub(super) fn word(name: &str) -> String {
    if RESERVED.contains(&name) {
        format!("{name}_")
    } else if KEYWORDS.contains(&name) {
        format!("r#{name}")
    } else {
        name.to_owned()
    }
}

/// Where definitions are.
#[derive(Debug)]
pub(super) struct Names {
    /// Modules and name of each definition.
    places: Vec<(Vec<String>, String)>,
    /// Names that stand for something else than in Rust's prelude.
    taken: BTreeSet<String>,
}

impl Names {
    pub fn new(unit: &Unit, selection: &Selection<'_>) -> Self {
        let scopes: BTreeMap<&[String], usize> = unit
            .definitions
            .iter()
            .enumerate()
            .map(|(index, definition)| (definition.path.as_slice(), index))
            .collect();
        let mut used: BTreeSet<(Vec<String>, String)> = BTreeSet::new();
        // What stands in no struct keeps its name, whoever comes first.
        let split = |path: &[String]| {
            let own = (1..path.len()).find(|end| scopes.contains_key(&path[..*end]));
            own.map_or(path.len() - 1, |end| end - 1)
        };
        let mut places = vec![(Vec::new(), String::new()); unit.definitions.len()];
        for nested in [false, true] {
            for (index, definition) in unit.definitions.iter().enumerate() {
                let at = split(&definition.path);
                let (modules, rest) = definition.path.split_at(at);
                let modules: Vec<String> = modules.iter().map(|name| own_type(name)).collect();
                if (rest.len() > 1) != nested {
                    continue;
                }
                let mut name = match definition.kind {
                    // A value is no type.
                    Kind::Constant(_) => rest.join("_"),
                    _ => own_type(&rest.join("_")),
                };
                while selection.writes(index) && !used.insert((modules.clone(), name.clone())) {
                    name.push('_');
                }
                places[index] = (modules, name);
            }
        }
        let taken = places
            .iter()
            .flat_map(|(modules, name)| modules.iter().chain([name]).cloned());
        Self {
            taken: taken.collect(),
            places,
        }
    }

    /// Modules that a definition is in.
    pub fn module(&self, index: usize) -> &[String] {
        &self.places[index].0
    }

    /// Its own name.
    pub fn own(&self, index: usize) -> String {
        word(&self.places[index].1)
    }

    /// How it is named where another one stands.
    pub fn path(&self, index: usize, from: usize) -> String {
        let (modules, name) = &self.places[index];
        if self.module(from) == modules {
            return word(name);
        }
        let up = self.module(from).iter().map(|_| "super".to_owned());
        let down = modules.iter().chain([name]).map(|name| word(name));
        up.chain(down).collect::<Vec<_>>().join("::")
    }

    /// A type of the prelude, by its whole path where its name stands for something else.
    pub fn prelude(&self, name: &'static str, path: &'static str) -> &'static str {
        match self.taken.contains(name) {
            true => path,
            false => name,
        }
    }
}
