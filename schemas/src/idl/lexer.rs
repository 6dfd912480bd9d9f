//! Text → words. Comments and blanks are passed over; `#` at the start of a line is the preprocessor's.

use std::rc::Rc;

use super::literal;
use super::token::{self, LAST_SYMBOLS, SYMBOLS, Token};
use crate::diagnostic::Source;
use crate::span::Span;

/// A word that is none.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fault {
    pub span: Span,
    pub message: String,
    pub help: &'static str,
    /// The word is IDL, but is not read.
    pub unsupported: bool,
}

/// A file that is being read.
#[derive(Debug, Clone)]
pub(super) struct Lexer {
    source: Rc<Source>,
    at: usize,
    /// Nothing but blanks and comments stood in this line so far.
    fresh: bool,
}

impl Lexer {
    pub fn new(source: Rc<Source>) -> Self {
        Self {
            source,
            at: 0,
            fresh: true,
        }
    }

    /// The place where reading stands.
    pub fn here(&self) -> Span {
        Span::new(self.at, self.at)
    }

    fn rest(&self) -> &str {
        self.source.text().get(self.at..).unwrap_or_default()
    }

    fn starts(&self, with: &str) -> bool {
        self.rest().starts_with(with)
    }

    /// The next word; after a fault reading goes on behind it.
    pub fn word(&mut self) -> Result<(Token, Span), Fault> {
        self.blanks(false)?;
        self.token()
    }

    /// The next word of this line.
    pub fn word_in_line(&mut self) -> Result<Option<(Token, Span)>, Fault> {
        self.blanks(true)?;
        if self.rest().is_empty() || self.starts("\n") {
            return Ok(None);
        }
        self.token().map(Some)
    }

    /// What is left of this line, without blanks and comments around it.
    pub fn line(&mut self) -> (String, Span) {
        let from = self.at;
        self.skip_line();
        let text = self.source.text();
        let line = text.get(from..self.at).unwrap_or_default();
        let cut = line.find("//").unwrap_or(line.len());
        let line = line[..cut]
            .find("/*")
            .map_or(&line[..cut], |at| &line[..at]);
        let start = from + line.len() - line.trim_start().len();
        let line = line.trim();
        (line.to_owned(), Span::new(start, start + line.len().max(1)))
    }

    /// The text between this place and the next of these ends, if the line has it; the end is passed over.
    pub fn until(&mut self, end: char) -> Option<(String, Span)> {
        let line = self.rest().lines().next().unwrap_or_default();
        let length = line.find(end)?;
        let text = line[..length].to_owned();
        let span = Span::new(self.at, self.at + length);
        self.at += length + end.len_utf8();
        Some((text, span))
    }

    /// Passes over blanks of this line and one of these characters; says which.
    pub fn one_of(&mut self, these: &[char]) -> Option<char> {
        let _ = self.blanks(true);
        let found = self.rest().chars().next().filter(|c| these.contains(c))?;
        self.at += found.len_utf8();
        Some(found)
    }

    /// To the end of this line; a comment that goes on is passed over.
    pub fn skip_line(&mut self) {
        while !self.rest().is_empty() && !self.starts("\n") {
            if self.starts("/*") {
                let _ = self.comment();
            } else if self.starts("//") {
                self.skip_comment_line();
            } else if !self.splice() {
                self.at += self.rest().chars().next().map_or(0, char::len_utf8);
            }
        }
    }

    /// To the next line that begins with `#`, behind it; false at the end of the file.
    pub fn skip_to_directive(&mut self) -> bool {
        loop {
            let _ = self.blanks(false);
            if self.rest().is_empty() {
                return false;
            }
            if self.fresh && self.starts("#") {
                self.at += 1;
                self.fresh = false;
                return true;
            }
            self.skip_line();
        }
    }

    fn skip_comment_line(&mut self) {
        self.at += self.rest().find('\n').unwrap_or(self.rest().len());
    }

    /// A backslash that continues the line.
    fn splice(&mut self) -> bool {
        let long = ["\\\n", "\\\r\n"].into_iter().find(|end| self.starts(end));
        self.at += long.map_or(0, str::len);
        long.is_some()
    }

    fn blanks(&mut self, in_line: bool) -> Result<(), Fault> {
        loop {
            match self.rest().bytes().next() {
                Some(b'\n') if in_line => return Ok(()),
                Some(b'\n') => {
                    self.fresh = true;
                    self.at += 1;
                }
                Some(b' ' | b'\t' | b'\r' | 0x0b | 0x0c) => self.at += 1,
                Some(b'/') if self.starts("//") => self.skip_comment_line(),
                Some(b'/') if self.starts("/*") => self.comment()?,
                Some(b'\\') if self.splice() => {}
                _ => return Ok(()),
            }
        }
    }

    fn comment(&mut self) -> Result<(), Fault> {
        let start = self.at;
        match self.rest()[2..].find("*/") {
            Some(length) => {
                self.at += length + 4;
                Ok(())
            }
            None => {
                self.at = self.source.text().len();
                Err(Fault {
                    span: Span::new(start, start + 2),
                    message: "this comment has no end".to_owned(),
                    help: "end it with `*/`",
                    unsupported: false,
                })
            }
        }
    }

    fn token(&mut self) -> Result<(Token, Span), Fault> {
        let start = self.at;
        let fresh = std::mem::replace(&mut self.fresh, false);
        let Some(first) = self.rest().chars().next() else {
            return Ok((Token::End, self.here()));
        };
        let text = self.source.clone();
        let rest = text.text().get(start..).unwrap_or_default();
        let (length, token) = match first {
            '#' if fresh => (1, Ok(Token::Hash)),
            'L' if rest.starts_with("L'") => literal::character(rest),
            'L' if rest.starts_with("L\"") => literal::string(rest),
            '\'' => literal::character(rest),
            '"' => literal::string(rest),
            'a'..='z' | 'A'..='Z' => word(rest),
            '_' => escaped(rest),
            '0'..='9' => literal::number(rest),
            '.' if rest[1..].starts_with(|c: char| c.is_ascii_digit()) => literal::number(rest),
            _ => symbol(rest, first),
        };
        self.at = start + length;
        let span = Span::new(start, self.at);
        match token {
            Ok(token) => Ok((token, span)),
            Err((message, help)) => Err(Fault {
                span,
                message,
                help,
                unsupported: help == literal::FIXED || help == ANNOTATION,
            }),
        }
    }
}

/// A word as it was read: its length, and what it is or why it is none with advice.
pub(super) type Lexed = (usize, Result<Token, (String, &'static str)>);

/// Bytes of the name at the start.
fn name_length(text: &str) -> usize {
    let end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    end.unwrap_or(text.len())
}

fn word(text: &str) -> Lexed {
    let length = name_length(text);
    let name = &text[..length];
    let token = token::keyword(name).map(Token::Keyword);
    (
        length,
        Ok(token.unwrap_or_else(|| Token::Identifier(name.to_owned()))),
    )
}

fn escaped(text: &str) -> Lexed {
    let length = name_length(text);
    let name = &text[1..length];
    match name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        true => (length, Ok(Token::Identifier(name.to_owned()))),
        false => {
            let message = format!("`{}` is no name", &text[..length]);
            let help = "a name begins with a letter; one underscore before it keeps it from being a keyword";
            (length, Err((message, help)))
        }
    }
}

/// Advice on what only IDL 4 has.
const ANNOTATION: &str = "leave the annotation out: IDL of CORBA 2.3 has none";

fn symbol(text: &str, first: char) -> Lexed {
    let mut all = SYMBOLS.into_iter().chain(LAST_SYMBOLS);
    if let Some(symbol) = all.find(|symbol| text.starts_with(symbol)) {
        return (symbol.len(), Ok(Token::Symbol(symbol)));
    }
    if first == '@' {
        let length = 1 + name_length(&text[1..]);
        return (
            length,
            Err(("annotations are not supported".to_owned(), ANNOTATION)),
        );
    }
    let is_part = |c: &char| !c.is_ascii() && !c.is_whitespace();
    let length: usize = text.chars().take_while(is_part).map(char::len_utf8).sum();
    let length = length.max(first.len_utf8());
    let help = match first {
        '#' => "`#` stands at the start of a line",
        _ => {
            "names have letters of ASCII, digits and `_`; anything else belongs into comments and strings"
        }
    };
    let shown: String = text[..length].chars().take(20).collect();
    (
        length,
        Err((format!("`{shown}` has no meaning here"), help)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        let mut lexer = Lexer::new(Rc::new(Source::new("f.idl", text)));
        let mut all = Vec::new();
        loop {
            match lexer.word() {
                Ok((Token::End, _)) => return all,
                Ok((token, span)) => all.push(format!("{token:?} {:?}", span.range())),
                Err(fault) => all.push(format!("{} {:?}", fault.message, fault.span.range())),
            }
        }
    }

    #[test]
    fn words_have_their_places() {
        insta::assert_debug_snapshot!(words(
            "struct _struct {\n  A::B x; // x\n} /* y\n */ >>~\n# a#"
        ));
    }

    #[test]
    fn what_is_no_word_is_said_and_passed_over() {
        insta::assert_debug_snapshot!(words("é @key __a _1 \u{1} ? 'a /* x"));
    }
}
