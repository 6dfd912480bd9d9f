//! What stands in files, modules and interfaces.

use super::super::model::{Kind, Type, Typedef};
use super::super::names::What;
use super::super::token::Token;
use super::types::Position;
use super::{Lost, Parsed, Reader};

/// Words that begin what is not read, and how it is called.
const UNSUPPORTED: [(&str, &str); 3] = [
    ("native", "a native type"),
    ("valuetype", "a value type"),
    ("custom", "a custom value type"),
];

impl Reader<'_> {
    /// Something in a file or a module, with its `;`.
    pub(super) fn definition(&mut self) -> Parsed<()> {
        if self.stray_semicolon() {
            return Ok(());
        }
        match &self.token {
            Token::Keyword("module") => {
                self.module()?;
                self.semicolon("the module")
            }
            Token::Keyword("interface" | "local") => {
                self.interface()?;
                self.semicolon("the interface")
            }
            Token::Keyword("abstract") => {
                self.abstract_one()?;
                self.semicolon("the interface")
            }
            _ => self.type_or_constant("a definition"),
        }
    }

    /// What may stand in interfaces too.
    pub(super) fn type_or_constant(&mut self, what: &str) -> Parsed<()> {
        match &self.token {
            Token::Keyword("struct") => {
                self.structure(true)?;
                self.semicolon("the struct")
            }
            Token::Keyword("union") => {
                self.union(true)?;
                self.semicolon("the union")
            }
            Token::Keyword("enum") => {
                self.enumeration()?;
                self.semicolon("the enum")
            }
            Token::Keyword("exception") => {
                self.exception()?;
                self.semicolon("the exception")
            }
            Token::Keyword("typedef") => {
                self.typedef()?;
                self.semicolon("the typedef")
            }
            Token::Keyword("const") => {
                self.constant()?;
                self.semicolon("the constant")
            }
            Token::Keyword(word) if UNSUPPORTED.iter().any(|(known, _)| known == word) => {
                self.unsupported(word)
            }
            Token::Identifier(word) => {
                let known = [
                    "module",
                    "struct",
                    "enum",
                    "union",
                    "typedef",
                    "const",
                    "interface",
                    "exception",
                ];
                let near = crate::suggest::nearest(word, known);
                let help = near.map_or_else(
                    || "a definition begins with module, struct, enum, union, typedef, const, interface or exception".to_owned(),
                    |near| format!("did you mean `{near}`?"),
                );
                self.expected(what, &help)
            }
            _ => {
                let help = "a definition begins with module, struct, enum, union, typedef, const, interface or exception";
                self.expected(what, help)
            }
        }
    }

    /// `native`, `valuetype`: told, and its name is kept so that its uses are not told too.
    fn unsupported(&mut self, word: &'static str) -> Parsed<()> {
        let at = self.at;
        let what = UNSUPPORTED.iter().find(|(known, _)| *known == word);
        let what = what.map_or(word, |(_, what)| what);
        let help = "write a struct of the values that are to be sent";
        self.error(
            "idl-not-supported",
            at,
            format!("{what} is not supported"),
            help,
        );
        self.advance();
        self.takes_word("valuetype");
        if let Token::Identifier(name) = &self.token {
            let (name, at) = (name.clone(), self.at);
            if self.declared(&name).is_none() {
                self.declare(&name, What::Unknown, at);
            }
        }
        Err(Lost)
    }

    /// `typedef type name, name[2];`
    fn typedef(&mut self) -> Parsed<()> {
        self.advance();
        let read = self.type_spec(Position::Declaration)?;
        loop {
            let declarator = self.declarator("the type")?;
            let known = read
                .clone()
                .and_then(|r#type| self.with_dimensions(r#type, &declarator));
            match known {
                Some(r#type) => {
                    let waits_for = self.waits_for(&r#type);
                    let kind = Kind::Typedef(Typedef { r#type });
                    let index = self.define(&declarator.name, declarator.at, kind);
                    self.facts[index].waits_for = waits_for;
                    self.weigh(index);
                    self.declare(&declarator.name, What::Definition(index), declarator.at);
                }
                None => {
                    self.declare(&declarator.name, What::Unknown, declarator.at);
                }
            }
            if !self.takes(",") {
                return Ok(());
            }
        }
    }

    /// What a sequence has that is not complete yet.
    fn waits_for(&self, r#type: &Type) -> Option<usize> {
        match r#type {
            Type::Sequence { element, .. } => {
                self.incomplete(element).or_else(|| self.waits_for(element))
            }
            Type::Array { element, .. } => self.waits_for(element),
            Type::Named(index) => self.facts[*index].waits_for,
            _ => None,
        }
    }
}
