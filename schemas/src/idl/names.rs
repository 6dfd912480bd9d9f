//! Scopes and the names in them.
//!
//! IDL does not tell names apart by case, but wants them written as they were declared; and a name that was used in a
//! scope must not get another meaning there.

use std::collections::{BTreeMap, BTreeSet};

use super::reader::Reader;
use super::token::At;
use crate::suggest;

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum What {
    /// Scope of a module.
    Module(usize),
    /// Index of a definition.
    Definition(usize),
    /// Of an enum: its index, and its number.
    Enumerator(usize, u32),
    /// Member, case or parameter.
    Member,
    /// Operation or attribute.
    Operation,
    /// Something that is not supported, which was told.
    Unknown,
}

/// How a name came into its scope.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum How {
    Declared,
    /// It is the name of the scope itself.
    Own,
    /// It was found further out and used here.
    Used,
}

/// A name.
#[derive(Debug, Clone)]
struct Entry {
    name: String,
    what: What,
    how: How,
    at: At,
}

/// A scope.
#[derive(Debug, Default)]
pub(super) struct Scope {
    name: String,
    parent: Option<usize>,
    /// By their names in lower case.
    names: BTreeMap<String, Entry>,
    /// Scopes of the interfaces that this one inherits from.
    pub bases: Vec<usize>,
}

/// `A::B`, `::A::B`.
#[derive(Debug, Clone, Default)]
pub(super) struct ScopedName {
    pub absolute: bool,
    pub parts: Vec<String>,
    pub at: At,
}

impl ScopedName {
    /// As it is written.
    pub fn shown(&self) -> String {
        let lead = if self.absolute { "::" } else { "" };
        format!("{lead}{}", self.parts.join("::"))
    }
}

fn key(name: &str) -> String {
    name.to_ascii_lowercase()
}

impl Reader<'_> {
    /// Modules and definitions around a scope, and its own name.
    pub(super) fn path(&self, scope: usize) -> Vec<String> {
        let outer = |at: &usize| self.scopes.get(*at).and_then(|scope| scope.parent);
        let all = std::iter::successors(Some(scope), outer);
        let mut path: Vec<String> = all
            .filter_map(|at| self.scopes.get(at))
            .filter(|scope| scope.parent.is_some())
            .map(|scope| scope.name.clone())
            .collect();
        path.reverse();
        path
    }

    /// Opens a scope within this one.
    pub(super) fn enter(&mut self, name: &str, what: What, at: At) -> usize {
        self.charge(DECLARED, at);
        let own = Entry {
            name: name.to_owned(),
            what,
            how: How::Own,
            at,
        };
        self.scopes.push(Scope {
            name: name.to_owned(),
            parent: Some(self.scope),
            names: BTreeMap::from([(key(name), own)]),
            bases: Vec::new(),
        });
        self.scope = self.scopes.len() - 1;
        self.scope
    }

    /// Opens a module, again if it was there.
    pub(super) fn enter_module(&mut self, name: &str, at: At) {
        let known = self.scopes[self.scope].names.get(&key(name));
        match known {
            Some(Entry {
                what: What::Module(scope),
                how: How::Declared,
                name: known,
                ..
            }) if known == name => self.scope = *scope,
            _ => {
                let next = self.scopes.len();
                self.declare(name, What::Module(next), at);
                self.enter(name, What::Module(next), at);
            }
        }
    }

    /// Goes back to the scope around this one; what nobody can name from outside is forgotten.
    pub(super) fn leave(&mut self) {
        let scope = &mut self.scopes[self.scope];
        let parent = scope.parent.unwrap_or_default();
        let is_module = scope
            .names
            .values()
            .any(|entry| entry.how == How::Own && matches!(entry.what, What::Module(_)));
        if !is_module {
            scope
                .names
                .retain(|_, entry| entry.how == How::Declared && entry.what != What::Member);
            if scope.names.is_empty() {
                scope.names = BTreeMap::new();
            }
        }
        self.scope = parent;
    }

    /// Gives a name a meaning in this scope; false, and told, if it has one.
    pub(super) fn declare(&mut self, name: &str, what: What, at: At) -> bool {
        self.charge(DECLARED + 2 * name.len(), at);
        let key = key(name);
        let entry = Entry {
            name: name.to_owned(),
            what,
            how: How::Declared,
            at,
        };
        if let Some(known) = self.scopes[self.scope].names.get(&key).cloned() {
            self.clash(name, at, &known);
            return false;
        }
        let inherited = self.inherited(self.scope, &key);
        let is_operation = |what: What| what == What::Operation;
        let known = inherited
            .into_iter()
            .find(|known| is_operation(known.what) || is_operation(what));
        if let Some(known) = known {
            let message = format!("`{name}` is inherited, so it cannot be declared again");
            let place = self.input.findings.shown(known.at);
            let help = format!(
                "give it another name: `{}` is declared at {place}",
                known.name
            );
            self.input
                .findings
                .error("idl-name-taken", at, message, help);
            return false;
        }
        self.scopes[self.scope].names.insert(key, entry);
        true
    }

    fn clash(&mut self, name: &str, at: At, known: &Entry) {
        let place = self.input.findings.shown(known.at);
        let (message, help) = match (known.how, known.name == name) {
            (How::Own, true) => (
                format!("`{name}` is the name of what it stands in"),
                "give it another name".to_owned(),
            ),
            (How::Own, false) => (
                format!(
                    "`{name}` differs from `{}`, the name of what it stands in, in case only",
                    known.name
                ),
                "give it another name: IDL does not tell names apart by case".to_owned(),
            ),
            (How::Used, true) => (
                format!("`{name}` was used in this scope with another meaning"),
                format!("give it another name, or write `::` before the use at {place}"),
            ),
            (How::Used, false) => (
                format!(
                    "`{name}` differs in case only from `{}`, which is used in this scope",
                    known.name
                ),
                format!(
                    "give it another name: IDL does not tell names apart by case; the use is at {place}"
                ),
            ),
            (How::Declared, true) => (
                format!("`{name}` is declared already"),
                format!("give one of them another name; the other is at {place}"),
            ),
            (How::Declared, false) => (
                format!("`{name}` differs from `{}` in case only", known.name),
                format!(
                    "give one of them another name: IDL does not tell names apart by case; the other is at {place}"
                ),
            ),
        };
        let code = match known.name == name {
            true => "idl-name-taken",
            false => "idl-name-case",
        };
        self.input.findings.error(code, at, message, help);
    }

    /// What this scope itself has declared by that name.
    pub(super) fn declared(&self, name: &str) -> Option<What> {
        let entry = self.scopes[self.scope].names.get(&key(name))?;
        (entry.how == How::Declared && entry.name == name).then_some(entry.what)
    }

    /// What the bases of a scope have by that name: each meaning once.
    fn inherited(&self, scope: usize, key: &str) -> Vec<Entry> {
        let mut seen = BTreeSet::new();
        let mut open = self.scopes[scope].bases.clone();
        let mut found: Vec<Entry> = Vec::new();
        while let Some(base) = open.pop() {
            if !seen.insert(base) {
                continue;
            }
            let scope = &self.scopes[base];
            let own = scope.names.get(key);
            match own.filter(|entry| entry.how == How::Declared) {
                Some(entry) => {
                    if found.iter().all(|other| other.at != entry.at) {
                        found.push(entry.clone());
                    }
                }
                None => open.extend(&scope.bases),
            }
        }
        found
    }

    /// Interfaces that a scope inherits from, directly or not.
    pub(super) fn ancestors(&self, scope: usize) -> BTreeSet<usize> {
        let mut seen = BTreeSet::new();
        let mut open = self.scopes[scope].bases.clone();
        while let Some(base) = open.pop() {
            if seen.insert(base) {
                open.extend(&self.scopes[base].bases);
            }
        }
        seen
    }

    /// Operations and attributes that two bases of this scope both have, of different origin.
    pub(super) fn clashes_of_bases(&mut self, at: At) {
        let mut known: BTreeMap<String, Entry> = BTreeMap::new();
        for base in self.ancestors(self.scope) {
            let names = self.scopes[base].names.clone();
            for (key, entry) in names {
                if entry.what != What::Operation || entry.how != How::Declared {
                    continue;
                }
                if let Some(other) = known.get(&key).filter(|other| other.at != entry.at) {
                    let findings = &mut self.input.findings;
                    let message = format!("two operations `{}` are inherited", entry.name);
                    let (one, two) = (findings.shown(other.at), findings.shown(entry.at));
                    let help = format!("give one of them another name: {one} and {two}");
                    findings.error("idl-inheritance", at, message, help);
                }
                known.insert(key, entry);
            }
        }
    }

    fn find(&mut self, scope: usize, name: &str, at: At) -> Option<Result<Entry, ()>> {
        let key = key(name);
        let own = self.scopes[scope].names.get(&key);
        if let Some(own) = own.filter(|entry| entry.how != How::Used) {
            return Some(Ok(own.clone()));
        }
        let mut inherited = self.inherited(scope, &key);
        if let [first, second, ..] = inherited.as_slice() {
            let findings = &mut self.input.findings;
            let message = format!("`{name}` is inherited with several meanings");
            let (one, two) = (findings.shown(first.at), findings.shown(second.at));
            let help = format!(
                "write which one is meant, with the name of its interface; they are at {one} and {two}"
            );
            findings.error("idl-inheritance", at, message, help);
            return Some(Err(()));
        }
        inherited.pop().map(Ok)
    }

    /// What a name means here; `None`, and told, if it means nothing.
    pub(super) fn resolve(&mut self, name: &ScopedName) -> Option<What> {
        let mut parts = name.parts.iter();
        let first = parts.next()?;
        let (mut entry, mut scope) = match name.absolute {
            true => (self.find(0, first, name.at), 0),
            false => self.find_outwards(first, name.at),
        };
        if !name.absolute && scope != self.scope && matches!(entry, Some(Ok(_))) {
            self.charge(DECLARED, name.at);
            let used = Entry {
                name: first.clone(),
                what: What::Unknown,
                how: How::Used,
                at: name.at,
            };
            self.scopes[self.scope]
                .names
                .entry(key(first))
                .or_insert(used);
        }
        let mut word = first;
        loop {
            let found = match entry {
                Some(found) => found.ok()?,
                None => {
                    self.unknown(name, word, scope);
                    return None;
                }
            };
            if found.name != *word {
                let place = self.input.findings.shown(found.at);
                let message = format!("`{word}` is declared as `{}`", found.name);
                let help =
                    format!("write it as at {place}: IDL wants a name in the same case everywhere");
                self.input
                    .findings
                    .error("idl-name-case", name.at, message, help);
            }
            let Some(next) = parts.next() else {
                return Some(found.what).filter(|what| *what != What::Unknown);
            };
            scope = match found.what {
                What::Module(scope) => scope,
                What::Definition(index) if self.facts[index].scope.is_some() => {
                    self.facts[index].scope.unwrap_or_default()
                }
                What::Unknown => return None,
                _ => {
                    let message = format!("`{word}` has no names in it");
                    let help = "names lie in modules, interfaces, structs, unions and exceptions; enumerators stand beside their enum";
                    self.input
                        .findings
                        .error("idl-unknown-name", name.at, message, help);
                    return None;
                }
            };
            word = next;
            entry = self.find(scope, word, name.at);
        }
    }

    fn find_outwards(&mut self, name: &str, at: At) -> (Option<Result<Entry, ()>>, usize) {
        let mut scope = self.scope;
        loop {
            let found = self.find(scope, name, at);
            match self.scopes[scope].parent {
                Some(parent) if found.is_none() => scope = parent,
                _ => return (found, scope),
            }
        }
    }

    fn unknown(&mut self, name: &ScopedName, word: &str, scope: usize) {
        let whole = name.shown();
        let is_first = name.parts.first().is_some_and(|first| first == word);
        let message = match is_first && !name.absolute {
            true => format!("there is no `{word}` here"),
            false if name.parts.len() == 1 => format!("there is no `{whole}`"),
            false => format!("there is no `{word}` in `{whole}`"),
        };
        let scope = match is_first && !name.absolute {
            true => self.scope,
            false => scope,
        };
        let outer = |at: &usize| self.scopes.get(*at).and_then(|scope| scope.parent);
        let visible = std::iter::successors(Some(scope), outer)
            .take(if scope == self.scope { usize::MAX } else { 1 })
            .filter_map(|at| self.scopes.get(at));
        let names = visible.flat_map(|scope| scope.names.values());
        let names = names.filter(|entry| entry.how == How::Declared && entry.what != What::Member);
        let names = names.map(|entry| entry.name.as_str());
        let basic = BASIC.into_iter().filter(|_| name.parts.len() == 1);
        let nearest = suggest::nearest(word, names.chain(basic));
        let help = match (standard_name(word), nearest) {
            (Some(own), _) => format!("in IDL of CORBA 2.3 it is called `{own}`"),
            (None, Some(near)) => format!("did you mean `{near}`?"),
            (None, None) => "declare it before its use, or include the file that does".to_owned(),
        };
        self.input
            .findings
            .error("idl-unknown-name", name.at, message, help);
    }
}

/// Types that have no declaration.
const BASIC: [&str; 11] = [
    "boolean", "char", "double", "float", "long", "octet", "sequence", "short", "string", "wchar",
    "wstring",
];

/// Memory that a name takes.
const DECLARED: usize = 320;

/// What types of other languages and of IDL 4 are called.
fn standard_name(word: &str) -> Option<&'static str> {
    let name = match word {
        "int8" | "uint8" | "byte" | "uint8_t" => "octet",
        "int16" | "int16_t" => "short",
        "uint16" | "uint16_t" | "ushort" => "unsigned short",
        "int" | "int32" | "int32_t" => "long",
        "uint" | "uint32" | "uint32_t" | "ulong" => "unsigned long",
        "int64" | "int64_t" => "long long",
        "uint64" | "uint64_t" => "unsigned long long",
        "float32" => "float",
        "float64" => "double",
        "bool" => "boolean",
        "String" => "string",
        _ => return None,
    };
    Some(name)
}
