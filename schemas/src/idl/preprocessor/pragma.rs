//! `#pragma`: `prefix`, `ID`, `version` and `once`. All others are for other programs.

use super::super::token::At;
use super::{Piece, Pragma, Preprocessor};

impl Preprocessor<'_> {
    pub(super) fn pragma(&mut self, at: At) {
        let (text, at) = match self.rest_of_line() {
            (text, _) if text.is_empty() => (text, at),
            found => found,
        };
        let (word, rest) = text.split_once([' ', '\t']).unwrap_or((&text, ""));
        let rest = rest.trim();
        let pragma = match word {
            "prefix" => quoted(rest)
                .filter(|prefix| is_identifier(prefix))
                .map(|prefix| Pragma::Prefix(prefix.to_owned()))
                .ok_or("write `#pragma prefix \"example.com\"`"),
            "ID" => two(rest)
                .and_then(|(name, id)| Some((name, quoted(id)?)))
                .filter(|(_, id)| id.contains(':') && is_identifier(id))
                .map(|(name, id)| Pragma::Id {
                    name: name.to_owned(),
                    id: id.to_owned(),
                })
                .ok_or("write `#pragma ID Name \"IDL:Module/Name:1.0\"`"),
            "version" => two(rest)
                .filter(|(_, version)| is_version(version))
                .map(|(name, version)| Pragma::Version {
                    name: name.to_owned(),
                    version: version.to_owned(),
                })
                .ok_or("write `#pragma version Name 1.0`"),
            "once" => {
                self.once.insert(at.file);
                return;
            }
            _ => return,
        };
        match pragma {
            Ok(pragma) => self.ready.push_back((Piece::Pragma(pragma), at)),
            Err(help) => {
                let message = format!("this `#pragma {word}` is not understood");
                self.findings.error("idl-bad-directive", at, message, help);
            }
        }
    }
}

fn quoted(text: &str) -> Option<&str> {
    text.strip_prefix('"')?.strip_suffix('"')
}

fn two(text: &str) -> Option<(&str, &str)> {
    let (first, second) = text.split_once([' ', '\t'])?;
    Some((first, second.trim_start()))
}

/// No quotes, blanks and the like: what a repository id is made of.
fn is_identifier(text: &str) -> bool {
    text.chars()
        .all(|c| c.is_ascii_graphic() && c != '"' && c != '\\')
}

fn is_version(text: &str) -> bool {
    let number = |text: &str| text.parse::<u16>().is_ok() && !text.starts_with('+');
    text.split_once('.')
        .is_some_and(|(major, minor)| number(major) && number(minor))
}
