//! Words → definitions. Names are resolved as they are read, since IDL declares before it uses.
//!
//! A mistake ends the part that it is in; reading goes on behind the next `;` or before the next `}`.

mod constant;
mod definition;
mod enumeration;
mod evaluate;
mod expression;
mod interface;
mod module;
mod operation;
mod pragma;
mod recover;
mod size;
mod structure;
mod types;
mod union;

use super::findings::Findings;
use super::limits;
use super::model::{Definition, Kind, Unit};
use super::names::{Scope, ScopedName, What};
use super::preprocessor::{Piece, Preprocessor};
use super::sources::Sources;
use super::token::{At, Token};
use crate::diagnostic::Finding;

/// What is being read cannot be understood; the problem was told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Lost;

/// A part that was read.
pub(super) type Parsed<T> = Result<T, Lost>;

/// How far a definition has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// Announced by this keyword.
    Forward(&'static str),
    /// Its members are being read.
    Open,
    Complete,
}

/// What is known of a definition beside the model.
#[derive(Debug, Clone)]
pub(super) struct Facts {
    pub at: At,
    /// Its own scope.
    pub scope: Option<usize>,
    pub state: State,
    /// Values without parts that it has at least.
    pub values: u64,
    /// Types within each other.
    pub depth: usize,
    /// Of a sequence: what must be complete before it is used elsewhere.
    pub waits_for: Option<usize>,
    /// A pragma has set its repository id.
    pub has_id: bool,
}

/// What repository ids begin with: this text, then the names of the scopes that were opened within it.
#[derive(Debug, Clone, Default)]
struct Prefix {
    text: String,
    /// Scopes around it.
    outer: usize,
}

/// The reader.
pub(super) struct Reader<'s> {
    pub input: Preprocessor<'s>,
    token: Token,
    at: At,
    /// The word before it.
    before: At,
    depth: usize,
    pub definitions: Vec<Definition>,
    pub facts: Vec<Facts>,
    pub scopes: Vec<Scope>,
    pub scope: usize,
    /// Of repository ids, here, and around each file that is open.
    prefix: Prefix,
    prefixes: Vec<Prefix>,
    /// Pragmas and ends of files before the word.
    waiting: Vec<(Piece, At)>,
    /// Structs, unions, exceptions and interfaces that are open.
    open: usize,
    /// Memory that was taken.
    cost: usize,
    is_too_dense: bool,
}

impl<'s> Reader<'s> {
    pub fn new(sources: &'s dyn Sources) -> Self {
        Self {
            input: Preprocessor::new(sources),
            token: Token::End,
            at: At::default(),
            before: At::default(),
            depth: 0,
            definitions: Vec::new(),
            facts: Vec::new(),
            scopes: vec![Scope::default()],
            scope: 0,
            prefix: Prefix::default(),
            prefixes: Vec::new(),
            waiting: Vec::new(),
            open: 0,
            cost: 0,
            is_too_dense: false,
        }
    }

    /// Reads the file that was opened.
    pub fn file(&mut self) {
        self.prefix = Prefix::default();
        self.advance();
        while self.token != Token::End {
            if self.definition().is_err() {
                self.recover();
                // Nothing is open that it could close.
                self.takes("}");
            }
        }
        self.obey();
    }

    /// What was read, and what is to be said of it.
    pub fn finish(mut self) -> (Unit, Findings) {
        for facts in &self.facts {
            let State::Forward(keyword) = facts.state else {
                continue;
            };
            let findings = &mut self.input.findings;
            let message = format!("this {keyword} is announced and never defined");
            let help = "define it, or leave it out";
            match keyword {
                "interface" => findings.push(
                    Some(facts.at),
                    Finding::warning("idl-incomplete-type", message).help(help),
                ),
                _ => findings.error("idl-incomplete-type", facts.at, message, help),
            }
        }
        let unit = Unit {
            definitions: self.definitions,
        };
        (unit, self.input.findings)
    }

    /// Goes on to the next word. What stands before this one and is no word counts from now on, in its scope.
    fn advance(&mut self) {
        self.before = self.at;
        self.obey();
        loop {
            match self.input.next() {
                (Piece::Token(_), _) if self.is_too_dense => {
                    self.token = Token::End;
                    return;
                }
                (Piece::Token(token), at) => {
                    self.token = token;
                    self.at = at;
                    return;
                }
                other => self.waiting.push(other),
            }
        }
    }

    /// Does what stands before this word.
    fn obey(&mut self) {
        for (piece, at) in std::mem::take(&mut self.waiting) {
            match piece {
                Piece::Token(_) => {}
                Piece::Pragma(pragma) => self.pragma(pragma, at),
                Piece::Enter => {
                    let begun = self.prefix_here(String::new());
                    let outer = std::mem::replace(&mut self.prefix, begun);
                    self.prefixes.push(outer);
                }
                Piece::Leave => self.prefix = self.prefixes.pop().unwrap_or_default(),
            }
        }
    }

    fn error(&mut self, code: &str, at: At, message: impl Into<String>, help: impl Into<String>) {
        self.input.findings.error(code, at, message, help);
    }

    fn is(&self, symbol: &str) -> bool {
        matches!(&self.token, Token::Symbol(found) if *found == symbol)
    }

    fn is_word(&self, keyword: &str) -> bool {
        matches!(&self.token, Token::Keyword(found) if *found == keyword)
    }

    fn takes(&mut self, symbol: &str) -> bool {
        let found = self.is(symbol);
        if found {
            self.advance();
        }
        found
    }

    fn takes_word(&mut self, keyword: &str) -> bool {
        let found = self.is_word(keyword);
        if found {
            self.advance();
        }
        found
    }

    fn expect(&mut self, symbol: &'static str, help: &str) -> Parsed<()> {
        match self.takes(symbol) {
            true => Ok(()),
            false => self.expected(&format!("`{symbol}`"), help),
        }
    }

    /// Says that something else stands here.
    fn expected<T>(&mut self, what: &str, help: &str) -> Parsed<T> {
        if self.token == Token::Bad {
            return Err(Lost);
        }
        let message = format!("expected {what}, found {}", self.token.shown());
        let at = self.at;
        self.error("idl-syntax", at, message, help);
        Err(Lost)
    }

    fn identifier(&mut self, what: &str) -> Parsed<(String, At)> {
        let at = self.at;
        match &mut self.token {
            Token::Identifier(name) => {
                let name = std::mem::take(name);
                self.advance();
                Ok((name, at))
            }
            Token::Keyword(word) => {
                let help = format!("`{word}` is a keyword; write `_{word}` to use it as a name");
                self.expected(&format!("the name of {what}"), &help)
            }
            _ => self.expected(&format!("the name of {what}"), "write a name here"),
        }
    }

    fn scoped_name(&mut self, what: &str) -> Parsed<ScopedName> {
        let mut name = ScopedName {
            at: self.at,
            ..ScopedName::default()
        };
        name.absolute = self.takes("::");
        loop {
            let (part, at) = self.identifier(what)?;
            name.parts.push(part);
            if at.file == name.at.file {
                name.at.span.end = at.span.end.max(name.at.span.end);
            }
            if !self.takes("::") {
                return Ok(name);
            }
        }
    }

    /// Reads something that may be within itself again.
    fn within<T>(&mut self, read: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth >= limits::DEPTH {
            let message = format!("more than {} levels are within each other", limits::DEPTH);
            let at = self.at;
            self.error(
                "idl-too-large",
                at,
                message,
                "name the inner ones by a typedef or a constant",
            );
            return Err(Lost);
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }

    /// Notes that memory is taken; too much for the size of the files ends the reading.
    pub(super) fn charge(&mut self, bytes: usize, at: At) {
        self.cost = self.cost.saturating_add(bytes);
        let allowed = limits::AT_LEAST + limits::PER_BYTE * self.input.bytes;
        if self.cost > allowed && !self.is_too_dense {
            self.is_too_dense = true;
            let message = "there are more names than files of this size have";
            self.error("too-dense", at, message, "is this an IDL file?");
        }
    }

    /// A definition at this place: its index. It has no scope of its own, and is complete.
    fn define(&mut self, name: &str, at: At, kind: Kind) -> usize {
        let mut path = self.path(self.scope);
        path.push(name.to_owned());
        let mut repository_id = "IDL:".to_owned();
        if !self.prefix.text.is_empty() {
            repository_id.push_str(&self.prefix.text);
            repository_id.push('/');
        }
        let within = path.get(self.prefix.outer..).unwrap_or(&path);
        repository_id.push_str(&within.join("/"));
        repository_id.push_str(":1.0");
        let file = self.input.findings.files.get(at.file);
        let file = file.map_or_else(String::new, |file| file.name().to_owned());
        let strings = path.len() * 24 + 3 * repository_id.len() + file.len();
        self.charge(
            2 * (size_of::<Definition>() + size_of::<Facts>()) + strings,
            at,
        );
        self.definitions.push(Definition {
            path,
            repository_id,
            file,
            span: at.span,
            kind,
        });
        self.facts.push(Facts {
            at,
            scope: None,
            state: State::Complete,
            values: 1,
            depth: 0,
            waits_for: None,
            has_id: false,
        });
        self.definitions.len() - 1
    }

    /// Begins a definition with a scope of its own, which may have been announced.
    fn begin(&mut self, keyword: &'static str, name: &str, at: At, kind: Kind) -> usize {
        let announced = match self.declared(name) {
            Some(What::Definition(index)) if self.facts[index].state == State::Forward(keyword) => {
                Some(index)
            }
            _ => None,
        };
        let index = match announced {
            Some(index) => {
                self.definitions[index].span = at.span;
                self.definitions[index].file = self
                    .input
                    .findings
                    .files
                    .get(at.file)
                    .map_or_else(String::new, |file| file.name().to_owned());
                index
            }
            None => {
                let index = self.define(name, at, Kind::Forward);
                self.declare(name, What::Definition(index), at);
                index
            }
        };
        self.definitions[index].kind = kind;
        self.facts[index].at = at;
        self.facts[index].state = State::Open;
        self.open += 1;
        let scope = self.enter(name, What::Definition(index), at);
        self.facts[index].scope = Some(scope);
        index
    }

    /// Ends it.
    fn end(&mut self, index: usize, kind: Kind) {
        self.leave();
        self.open = self.open.saturating_sub(1);
        self.definitions[index].kind = kind;
        self.facts[index].state = State::Complete;
        self.weigh(index);
    }

    /// Announces a definition.
    fn forward(&mut self, keyword: &'static str, name: &str, at: At) {
        if let Some(What::Definition(index)) = self.declared(name) {
            let is_same = match (self.facts[index].state, &self.definitions[index].kind) {
                (State::Forward(known), _) => known == keyword,
                (_, Kind::Struct(_)) => keyword == "struct",
                (_, Kind::Union(_)) => keyword == "union",
                (_, Kind::Interface(_)) => keyword == "interface",
                _ => false,
            };
            if is_same {
                return;
            }
        }
        let index = self.define(name, at, Kind::Forward);
        self.facts[index].state = State::Forward(keyword);
        self.declare(name, What::Definition(index), at);
    }
}
