//! `#define`: names that stand for words.

use std::rc::Rc;

use super::super::limits;
use super::super::token::{At, Token};
use super::{Piece, Preprocessor};

/// Macros of macros.
const DEPTH: usize = 32;

impl Preprocessor<'_> {
    pub(super) fn define(&mut self, at: At) {
        let Some(name) = self.macro_name(at) else {
            return;
        };
        let end = self.here().span.start;
        let words = self.words_of_line();
        let first = words.first();
        if first.is_some_and(|(token, at)| *token == Token::Symbol("(") && at.span.start == end) {
            let message = format!("the macro `{name}` has parameters, which is not supported");
            let help = "write out what it stands for";
            self.findings.error("idl-not-supported", at, message, help);
            self.macros.insert(name, Rc::default());
            return;
        }
        let words: Rc<[Token]> = words.into_iter().map(|(token, _)| token).collect();
        let before = self.macros.get(&name);
        if before.is_some_and(|before| *before != words) {
            let message = format!("the macro `{name}` stands for something else already");
            let help = format!("write `#undef {name}` before it, or give it another name");
            self.findings.error("idl-bad-directive", at, message, help);
        }
        self.macros.insert(name, words);
    }

    /// Puts what a macro stands for in the place of its name; false if it is none.
    pub(super) fn expand(&mut self, token: &Token, at: At) -> bool {
        let Token::Identifier(name) = token else {
            return false;
        };
        if !self.macros.contains_key(name) {
            return false;
        }
        let mut words = Vec::new();
        let fits = self.expansion(name, &mut Vec::new(), &mut words);
        if !fits {
            self.expanded = limits::EXPANDED;
            let message = format!("macros stand for more than {} words", limits::EXPANDED);
            let help = "write out what they stand for";
            self.findings.error("idl-too-large", at, message, help);
            return true;
        }
        self.ready
            .extend(words.into_iter().map(|token| (Piece::Token(token), at)));
        true
    }

    /// What a name stands for; a macro within itself is left as it is. Each word of each macro counts, also a name that
    /// stands for nothing.
    fn expansion(&mut self, name: &str, within: &mut Vec<String>, words: &mut Vec<Token>) -> bool {
        let Some(body) = self.macros.get(name).map(Rc::clone) else {
            return true;
        };
        self.expanded += body.len();
        if self.expanded > limits::EXPANDED {
            return false;
        }
        within.push(name.to_owned());
        for token in body.iter() {
            let inner = match token {
                Token::Identifier(inner) => Some(inner)
                    .filter(|inner| self.macros.contains_key(*inner) && !within.contains(inner)),
                _ => None,
            };
            let fits = match inner {
                Some(inner) => within.len() < DEPTH && self.expansion(inner, within, words),
                None => {
                    words.push(token.clone());
                    true
                }
            };
            if !fits {
                return false;
            }
        }
        within.pop();
        true
    }
}
