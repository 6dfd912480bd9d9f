//! Files → words: includes, conditions, macros and pragmas.
//!
//! It is the part of the C preprocessor that IDL files use: no macros with parameters, and no `##`.

mod condition;
mod directive;
mod expression;
mod include;
mod macros;
mod pragma;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::rc::Rc;

use self::condition::Condition;
use super::findings::Findings;
use super::lexer::{Fault, Lexer};
use super::limits;
use super::sources::Sources;
use super::token::{At, Token, like_keyword};
use crate::diagnostic::Source;
use crate::span::Span;

/// What comes next.
#[derive(Debug)]
pub(super) enum Piece {
    Token(Token),
    Pragma(Pragma),
    /// An included file begins.
    Enter,
    /// It has ended.
    Leave,
}

/// What a pragma says of repository ids.
#[derive(Debug)]
pub(super) enum Pragma {
    /// From here on.
    Prefix(String),
    /// Of a definition.
    Id { name: String, id: String },
    /// Of a definition.
    Version { name: String, version: String },
}

/// A file that is open.
struct Open {
    file: usize,
    lexer: Lexer,
    /// How many conditions were open when it began.
    conditions: usize,
}

/// All files with their words.
pub(super) struct Preprocessor<'s> {
    sources: &'s dyn Sources,
    pub findings: Findings,
    /// The files that are open, the innermost last.
    open: Vec<Open>,
    conditions: Vec<Condition>,
    macros: BTreeMap<String, Rc<[Token]>>,
    /// Files that said `#pragma once`.
    once: BTreeSet<usize>,
    /// Words that macros stand for, the next one first.
    ready: VecDeque<(Piece, At)>,
    /// How many of them there were.
    expanded: usize,
    includes: usize,
    /// Bytes of all files.
    pub bytes: usize,
}

impl<'s> Preprocessor<'s> {
    pub fn new(sources: &'s dyn Sources) -> Self {
        Self {
            sources,
            findings: Findings::default(),
            open: Vec::new(),
            conditions: Vec::new(),
            macros: BTreeMap::new(),
            once: BTreeSet::new(),
            ready: VecDeque::new(),
            expanded: 0,
            includes: 0,
            bytes: 0,
        }
    }

    /// Opens a file with its text; false if there were too many.
    pub fn open(&mut self, name: &str, text: String) -> bool {
        self.bytes += text.len();
        if self.bytes > limits::BYTES {
            return false;
        }
        let known = self
            .findings
            .files
            .iter()
            .position(|file| file.name() == name);
        let file = known.unwrap_or_else(|| {
            self.findings.files.push(Rc::new(Source::new(name, text)));
            self.findings.files.len() - 1
        });
        if !self.once.contains(&file) {
            self.open.push(Open {
                file,
                lexer: Lexer::new(self.findings.files[file].clone()),
                conditions: self.conditions.len(),
            });
        }
        true
    }

    /// The next piece. At the end of everything it is [`Token::End`], again and again.
    pub fn next(&mut self) -> (Piece, At) {
        loop {
            if self.findings.is_full() {
                return (Piece::Token(Token::End), self.here());
            }
            if let Some(ready) = self.ready.pop_front() {
                return ready;
            }
            let Some(open) = self.open.last_mut() else {
                return (Piece::Token(Token::End), self.here());
            };
            let file = open.file;
            if self
                .conditions
                .last()
                .is_some_and(|condition| !condition.active)
            {
                match open.lexer.skip_to_directive() {
                    true => self.directive(),
                    false => {
                        if let Some(end) = self.close() {
                            return end;
                        }
                    }
                }
                continue;
            }
            match open.lexer.word() {
                Ok((Token::End, _)) => {
                    if let Some(end) = self.close() {
                        return end;
                    }
                }
                Ok((Token::Hash, _)) => self.directive(),
                Ok((token, span)) => {
                    let at = At { file, span };
                    if !self.expand(&token, at) {
                        self.no_keyword(&token, at);
                        return (Piece::Token(token), at);
                    }
                }
                Err(fault) => {
                    let at = self.at(fault.span);
                    self.fault(fault);
                    return (Piece::Token(Token::Bad), at);
                }
            }
        }
    }

    /// A name that is a keyword but for its case is wrong, unless it is escaped.
    fn no_keyword(&mut self, token: &Token, at: At) {
        let Token::Identifier(name) = token else {
            return;
        };
        let is_escaped = at.span.range().len() > name.len();
        if let Some(keyword) = like_keyword(name).filter(|_| !is_escaped) {
            let message = format!("`{name}` differs from the keyword `{keyword}` in case only");
            let help = format!(
                "write `{keyword}` if the keyword is meant, `_{name}` or another name if not"
            );
            self.findings.error("idl-name-case", at, message, help);
        }
    }

    /// Tells of a word that is none.
    fn fault(&mut self, fault: Fault) {
        let code = match fault.unsupported {
            true => "idl-not-supported",
            false => "idl-bad-word",
        };
        let at = self.at(fault.span);
        self.findings.error(code, at, fault.message, fault.help);
    }

    /// A place in the file that is read.
    fn at(&self, span: Span) -> At {
        let file = self.open.last().map_or(0, |open| open.file);
        At { file, span }
    }

    /// Where reading stands; at the end of everything, the end of the first file.
    fn here(&self) -> At {
        let end = self
            .findings
            .files
            .first()
            .map_or(0, |file| file.text().len());
        match self.open.last() {
            Some(open) => self.at(open.lexer.here()),
            None => At {
                file: 0,
                span: Span::new(end, end),
            },
        }
    }

    /// Ends a file, and what was left open in it.
    fn close(&mut self) -> Option<(Piece, At)> {
        let open = self.open.last()?;
        for condition in self.conditions.split_off(open.conditions) {
            let help = "each `#if`, `#ifdef` and `#ifndef` has its `#endif` in the same file";
            self.findings.error(
                "idl-bad-directive",
                condition.at,
                "this condition has no `#endif`",
                help,
            );
        }
        let at = self.here();
        self.open.pop();
        (!self.open.is_empty()).then_some((Piece::Leave, at))
    }
}
