//! Lines that begin with `#`.

use super::super::token::{At, Token};
use super::Preprocessor;
use crate::diagnostic::Finding;
use crate::span::Span;

/// All that are known.
const KNOWN: [&str; 14] = [
    "include", "if", "ifdef", "ifndef", "elif", "else", "endif", "define", "undef", "pragma",
    "error", "warning", "line", "ident",
];

/// Words behind one directive.
const WORDS: usize = 1000;

impl Preprocessor<'_> {
    /// Reads the line behind its `#`.
    pub(super) fn directive(&mut self) {
        let depth = self.open.len();
        let Some((word, at)) = self.directive_word() else {
            return;
        };
        match word.as_str() {
            "if" | "ifdef" | "ifndef" => self.open_condition(&word, at),
            "elif" | "else" | "endif" => self.next_condition(&word, at),
            _ if !self.is_active() => {}
            "include" => self.include(at),
            "define" => self.define(at),
            "undef" => {
                if let Some(name) = self.macro_name(at) {
                    self.macros.remove(&name);
                }
            }
            "pragma" => self.pragma(at),
            "error" | "warning" => {
                let (text, _) = self.rest_of_line();
                let message = format!("the file says: {text}");
                let help = "this is what its author wanted you to know; see the lines around it";
                match word.as_str() {
                    "error" => self.findings.error("idl-said", at, message, help),
                    _ => self
                        .findings
                        .push(Some(at), Finding::warning("idl-said", message).help(help)),
                }
            }
            "line" | "ident" => {}
            _ => {
                let message = format!("there is no directive `#{word}`");
                let help = crate::suggest::advice(&word, "known", &KNOWN);
                self.findings.error("idl-bad-directive", at, message, help);
            }
        }
        // An included file is read before the rest of this line's file.
        let line = self.open.get_mut(depth - 1);
        if let Some(open) = line {
            open.lexer.skip_line();
        }
    }

    /// Its first word; a number is the mark of another preprocessor.
    fn directive_word(&mut self) -> Option<(String, At)> {
        let word = self.open.last_mut()?.lexer.word_in_line();
        match word {
            Ok(Some((Token::Identifier(name), span))) => Some((name, self.at(span))),
            Ok(Some((Token::Keyword(name), span))) => Some((name.to_owned(), self.at(span))),
            Ok(Some((Token::Integer(_), span))) => Some(("line".to_owned(), self.at(span))),
            Ok(None) => Some(("line".to_owned(), self.here())),
            Ok(Some((token, span))) => {
                let message = format!("{} is no directive", token.shown());
                let help = crate::suggest::advice("", "known", &KNOWN);
                self.unless_skipped(span, message, &help);
                Some(("line".to_owned(), self.at(span)))
            }
            Err(fault) => {
                self.unless_skipped(fault.span, fault.message, fault.help);
                Some(("line".to_owned(), self.here()))
            }
        }
    }

    fn unless_skipped(&mut self, span: Span, message: String, help: &str) {
        if self.is_active() {
            let at = self.at(span);
            self.findings.error("idl-bad-directive", at, message, help);
        }
    }

    /// What stands behind the directive.
    pub(super) fn rest_of_line(&mut self) -> (String, At) {
        let line = self.open.last_mut().map(|open| open.lexer.line());
        let (text, span) = line.unwrap_or_default();
        (text, self.at(span))
    }

    /// The words behind the directive; what is no word is told.
    pub(super) fn words_of_line(&mut self) -> Vec<(Token, At)> {
        let mut words = Vec::new();
        while let Some(open) = self.open.last_mut() {
            if words.len() == WORDS {
                let message = format!("there are more than {WORDS} words in this directive");
                let help = "write them into the file itself";
                let at = self.here();
                self.findings.error("idl-too-large", at, message, help);
                break;
            }
            match open.lexer.word_in_line() {
                Ok(Some((token, span))) => words.push((token, self.at(span))),
                Ok(None) => break,
                Err(fault) => self.fault(fault),
            }
        }
        words
    }

    /// The name of a macro, which must follow.
    pub(super) fn macro_name(&mut self, at: At) -> Option<String> {
        let word = self.open.last_mut()?.lexer.word_in_line();
        match word {
            Ok(Some((Token::Identifier(name), _))) => Some(name),
            Ok(Some((Token::Keyword(name), _))) => Some(name.to_owned()),
            Ok(_) => {
                let help = "write the name of a macro behind it";
                self.findings.error(
                    "idl-bad-directive",
                    at,
                    "this directive names no macro",
                    help,
                );
                None
            }
            Err(fault) => {
                self.fault(fault);
                None
            }
        }
    }
}
