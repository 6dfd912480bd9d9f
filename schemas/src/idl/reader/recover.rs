//! After a mistake: where reading goes on.

use super::super::token::{At, Token};
use super::{Lost, Parsed, Reader};
use crate::span::Span;

impl Reader<'_> {
    /// Goes behind the next `;`, or before the `}` that ends what is around.
    pub(super) fn recover(&mut self) {
        let mut depth = 0_usize;
        loop {
            match &self.token {
                Token::End => return,
                Token::Symbol(";") if depth == 0 => {
                    self.advance();
                    return;
                }
                Token::Symbol("}") if depth == 0 => return,
                Token::Symbol("{") => depth += 1,
                Token::Symbol("}") => depth -= 1,
                _ => {}
            }
            self.advance();
        }
    }

    /// The `;` behind something. One that is merely missing at the end of a line is told, and reading goes on there.
    pub(super) fn semicolon(&mut self, what: &str) -> Parsed<()> {
        if self.takes(";") {
            return Ok(());
        }
        if self.token == Token::Bad {
            return Err(Lost);
        }
        let message = format!("expected `;` behind {what}, found {}", self.token.shown());
        let help = format!("end {what} with `;`");
        match self.starts_anew() {
            true => {
                let end = self.before.span.range().end;
                let at = At {
                    file: self.before.file,
                    span: Span::new(end, end + 1),
                };
                self.error("idl-syntax", at, message, help);
                Ok(())
            }
            false => {
                let at = self.at;
                self.error("idl-syntax", at, message, help);
                Err(Lost)
            }
        }
    }

    /// The word stands in another line than the one before it, or ends what is around.
    fn starts_anew(&self) -> bool {
        if self.is("}") || self.token == Token::End || self.at.file != self.before.file {
            return true;
        }
        let between = self.before.span.range().end..self.at.span.range().start;
        let text = self
            .input
            .findings
            .files
            .get(self.at.file)
            .map(|file| file.text());
        text.and_then(|text| text.get(between))
            .is_some_and(|text| text.contains('\n'))
    }

    /// A `;` where nothing is to be ended.
    pub(super) fn stray_semicolon(&mut self) -> bool {
        let at = self.at;
        let found = self.takes(";");
        if found {
            self.error("idl-syntax", at, "this `;` ends nothing", "leave it out");
        }
        found
    }

    /// Reads parts until the `}` of what they are in, whose name is given.
    pub(super) fn parts(
        &mut self,
        of: &str,
        mut part: impl FnMut(&mut Self) -> Parsed<()>,
    ) -> Parsed<()> {
        while !self.is("}") && self.token != Token::End {
            if self.stray_semicolon() {
                continue;
            }
            if part(self).is_err() {
                self.recover();
            }
        }
        let help = format!("close {of}");
        self.expect("}", &help)
    }
}
