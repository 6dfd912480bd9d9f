//! `#include`.

use super::super::sources::Include;
use super::super::token::At;
use super::super::{decode, limits};
use super::{Piece, Preprocessor};

impl Preprocessor<'_> {
    pub(super) fn include(&mut self, at: At) {
        let Some((name, angled, at)) = self.include_name(at) else {
            return;
        };
        if let Err((code, message, help)) = self.included(&name, angled, at) {
            self.findings.error(code, at, message, help);
        }
    }

    fn include_name(&mut self, at: At) -> Option<(String, bool, At)> {
        let lexer = &mut self.open.last_mut()?.lexer;
        let angled = match lexer.one_of(&['"', '<']) {
            Some('<') => Some((true, lexer.until('>'))),
            Some(_) => Some((false, lexer.until('"'))),
            None => None,
        };
        match angled {
            Some((angled, Some((name, span)))) if !name.is_empty() => {
                Some((name, angled, self.at(span)))
            }
            _ => {
                let help = "write `#include \"file.idl\"` or `#include <file.idl>`";
                self.findings.error(
                    "idl-bad-directive",
                    at,
                    "this directive names no file",
                    help,
                );
                None
            }
        }
    }

    fn included(
        &mut self,
        name: &str,
        angled: bool,
        at: At,
    ) -> Result<(), (&'static str, String, String)> {
        if self.open.len() >= limits::INCLUDE_DEPTH {
            let message = format!(
                "more than {} files include each other",
                limits::INCLUDE_DEPTH
            );
            let help = match self.open.first().map(|open| open.file)
                == self.open.last().map(|open| open.file)
                || self.is_cycle()
            {
                true => {
                    "a file includes itself: put `#ifndef NAME`, `#define NAME` and `#endif` around what it says"
                }
                false => "include fewer files from included ones",
            };
            return Err(("idl-too-large", message, help.to_owned()));
        }
        self.includes += 1;
        if self.includes > limits::INCLUDES {
            let message = format!("there are more than {} includes", limits::INCLUDES);
            return Err((
                "idl-too-large",
                message,
                "include each file once".to_owned(),
            ));
        }
        let from = self
            .findings
            .files
            .get(at.file)
            .map_or("", |file| file.name())
            .to_owned();
        let include = Include {
            from: &from,
            name,
            angled,
        };
        let found = self.sources.find(include).map_err(|why| {
            let message = format!("`{name}` cannot be read: {why}");
            ("idl-include", message, "make it readable".to_owned())
        })?;
        let Some(found) = found else {
            let message = format!("there is no file `{name}`");
            let help = match angled {
                true => "name the folder that it is in with -I",
                false => "it is looked for beside this file, and in the folders that -I names",
            };
            return Err(("idl-include", message, help.to_owned()));
        };
        let text = decode::decode(&found.path, &found.bytes).map_err(|finding| {
            let code = match finding.code.as_str() {
                "idl-not-text" => "idl-not-text",
                _ => "too-large",
            };
            (code, finding.message, finding.help.unwrap_or_default())
        })?;
        let depth = self.open.len();
        if !self.open(&found.path, text) {
            let message = format!("the files together have more than {} bytes", limits::BYTES);
            return Err(("too-large", message, "include fewer files".to_owned()));
        }
        if self.open.len() > depth {
            self.ready.push_back((Piece::Enter, at));
        }
        Ok(())
    }

    /// A file is open within itself.
    fn is_cycle(&self) -> bool {
        let mut files: Vec<usize> = self.open.iter().map(|open| open.file).collect();
        files.sort_unstable();
        files.windows(2).any(|pair| pair[0] == pair[1])
    }
}
