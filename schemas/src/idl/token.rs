//! Words of IDL.

use crate::span::Span;

/// A place in one of the files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct At {
    /// Index of the file.
    pub file: usize,
    /// Where in it.
    pub span: Span,
}

/// A word.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token {
    /// A name, without the underscore that escapes it.
    Identifier(String),
    Keyword(&'static str),
    Integer(u64),
    Float(f64),
    Char(char),
    WChar(char),
    Text(String),
    WText(String),
    /// `{`, `::`, `<<` and so on.
    Symbol(&'static str),
    /// `#` at the start of a line.
    Hash,
    /// What is no word, which was told.
    Bad,
    /// End of the last file.
    End,
}

impl Token {
    /// As a message calls it.
    pub fn shown(&self) -> String {
        match self {
            Self::Identifier(name) => format!("`{name}`"),
            Self::Keyword(word) | Self::Symbol(word) => format!("`{word}`"),
            Self::Integer(_) | Self::Float(_) => "a number".to_owned(),
            Self::Char(_) | Self::WChar(_) => "a character".to_owned(),
            Self::Text(_) | Self::WText(_) => "a string".to_owned(),
            Self::Hash => "`#`".to_owned(),
            Self::Bad => "what is no word".to_owned(),
            Self::End => "the end of the file".to_owned(),
        }
    }
}

/// Keywords of CORBA 2.3; those of CORBA 3 components and IDL 4 are names in the files that people have.
const KEYWORDS: [&str; 48] = [
    "FALSE",
    "Object",
    "TRUE",
    "ValueBase",
    "abstract",
    "any",
    "attribute",
    "boolean",
    "case",
    "char",
    "const",
    "context",
    "custom",
    "default",
    "double",
    "enum",
    "exception",
    "factory",
    "fixed",
    "float",
    "in",
    "inout",
    "interface",
    "local",
    "long",
    "module",
    "native",
    "octet",
    "oneway",
    "out",
    "private",
    "public",
    "raises",
    "readonly",
    "sequence",
    "short",
    "string",
    "struct",
    "supports",
    "switch",
    "truncatable",
    "typedef",
    "union",
    "unsigned",
    "valuetype",
    "void",
    "wchar",
    "wstring",
];

/// The keyword that is written so.
pub(super) fn keyword(word: &str) -> Option<&'static str> {
    KEYWORDS.into_iter().find(|known| *known == word)
}

/// The keyword that a name differs from in case only.
pub(super) fn like_keyword(word: &str) -> Option<&'static str> {
    let same = |known: &&str| known.eq_ignore_ascii_case(word);
    KEYWORDS.into_iter().find(same)
}

/// Symbols, the longer ones first.
pub(super) const SYMBOLS: [&str; 29] = [
    "::", "<<", ">>", "&&", "||", "==", "!=", "<=", ">=", "{", "}", "(", ")", "[", "]", "<", ">",
    ";", ",", ":", "=", "+", "-", "*", "/", "%", "|", "^", "&",
];

/// Symbols of one character that no longer one begins with.
pub(super) const LAST_SYMBOLS: [&str; 2] = ["~", "!"];
