//! Structs and exceptions.

use super::super::model::{Exception, Kind, Member, StructType, Type};
use super::super::names::What;
use super::super::token::Token;
use super::types::Position;
use super::{Parsed, Reader};

impl Reader<'_> {
    /// `struct name { … }`, or only `struct name` where it may be announced.
    pub(super) fn structure(&mut self, may_announce: bool) -> Parsed<Option<Type>> {
        self.advance();
        let (name, at) = self.identifier("the struct")?;
        if may_announce && self.is(";") {
            self.forward("struct", &name, at);
            return Ok(None);
        }
        self.expect("{", "a struct has its members in braces")?;
        self.within(|reader| {
            let index = reader.begin("struct", &name, at, Kind::Struct(StructType::default()));
            let empty = reader.is("}");
            let (members, result) = reader.members(&format!("the struct `{name}`"));
            if empty {
                let message = format!("the struct `{name}` is empty");
                reader.error(
                    "idl-syntax",
                    at,
                    message,
                    "a struct has at least one member",
                );
            }
            reader.end(index, Kind::Struct(StructType { members }));
            result.map(|()| Some(Type::Named(index)))
        })
    }

    /// `exception name { … }`.
    pub(super) fn exception(&mut self) -> Parsed<()> {
        self.advance();
        let (name, at) = self.identifier("the exception")?;
        self.expect("{", "an exception has its members in braces")?;
        self.within(|reader| {
            let index = reader.begin(
                "exception",
                &name,
                at,
                Kind::Exception(Exception::default()),
            );
            let (members, result) = reader.members(&format!("the exception `{name}`"));
            reader.end(index, Kind::Exception(Exception { members }));
            result
        })
    }

    /// Members until the `}`, which is passed over if it is there.
    fn members(&mut self, of: &str) -> (Vec<Member>, Parsed<()>) {
        let mut members = Vec::new();
        let result = self.parts(of, |reader| reader.member(&mut members));
        (members, result)
    }

    /// `type name, name[2];`
    fn member(&mut self, members: &mut Vec<Member>) -> Parsed<()> {
        let read = self.type_spec(Position::Declaration)?;
        loop {
            let declarator = self.declarator("the member")?;
            self.declare(&declarator.name, What::Member, declarator.at);
            let known = read
                .clone()
                .and_then(|r#type| self.with_dimensions(r#type, &declarator));
            if let Some(r#type) = known {
                members.push(Member {
                    name: declarator.name,
                    r#type,
                });
            }
            if !self.takes(",") {
                return match self.token {
                    // A word is missing between the two, not the end.
                    Token::Symbol("=") => self.expected("`;`", "members have no default values"),
                    _ => self.semicolon("the member"),
                };
            }
        }
    }
}
