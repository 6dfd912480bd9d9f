//! Interfaces.

use super::super::limits;
use super::super::model::{Attribute, Interface, Kind};
use super::super::names::What;
use super::super::token::Token;
use super::{Parsed, Reader, State};

impl Reader<'_> {
    /// `abstract interface`; abstract value types are not supported.
    pub(super) fn abstract_one(&mut self) -> Parsed<()> {
        let at = self.at;
        self.advance();
        if self.is_word("valuetype") {
            let help = "write a struct of the values that are to be sent";
            self.error(
                "idl-not-supported",
                at,
                "an abstract value type is not supported",
                help,
            );
            return Err(super::Lost);
        }
        self.interface_of(Some("abstract"))
    }

    /// `interface name : base, base { … }`, or only `interface name`.
    pub(super) fn interface(&mut self) -> Parsed<()> {
        let modifier = self.takes_word("local").then_some("local");
        self.interface_of(modifier)
    }

    fn interface_of(&mut self, modifier: Option<&'static str>) -> Parsed<()> {
        if !self.takes_word("interface") {
            return self.expected(
                "`interface`",
                "`abstract` and `local` stand before `interface`",
            );
        }
        let (name, at) = self.identifier("the interface")?;
        if self.is(";") {
            self.forward("interface", &name, at);
            return Ok(());
        }
        let bases = match self.takes(":") {
            true => self.bases(modifier)?,
            false => Vec::new(),
        };
        self.expect("{", "an interface has its operations in braces")?;
        self.within(|reader| {
            let mut interface = Interface {
                modifier: modifier.map(str::to_owned),
                bases,
                ..Interface::default()
            };
            let index = reader.begin("interface", &name, at, Kind::Interface(interface.clone()));
            let scopes = interface
                .bases
                .iter()
                .filter_map(|base| reader.facts[*base].scope);
            reader.scopes[reader.scope].bases = scopes.collect();
            if reader.ancestors(reader.scope).len() > limits::ANCESTORS {
                let message = format!(
                    "`{name}` inherits from more than {} interfaces",
                    limits::ANCESTORS
                );
                reader.error("idl-too-large", at, message, "inherit from fewer");
                reader.scopes[reader.scope].bases.clear();
            }
            reader.clashes_of_bases(at);
            let result = reader.parts(&format!("the interface `{name}`"), |reader| {
                reader.export(&mut interface)
            });
            reader.end(index, Kind::Interface(interface));
            result
        })
    }

    fn bases(&mut self, modifier: Option<&str>) -> Parsed<Vec<usize>> {
        let mut bases = Vec::new();
        loop {
            let name = self.scoped_name("an interface")?;
            let shown = name.shown();
            let found = match self.resolve(&name) {
                Some(What::Definition(index)) => Some(index),
                Some(_) => Some(usize::MAX),
                None => None,
            };
            let wrong = found.and_then(|index| self.wrong_base(index, &bases, modifier, &shown));
            match (found, wrong) {
                (_, Some((message, help))) => self.error("idl-inheritance", name.at, message, help),
                (Some(index), None) => bases.push(index),
                (None, None) => {}
            }
            if !self.takes(",") {
                return Ok(bases);
            }
        }
    }

    /// Why an interface cannot inherit from it.
    fn wrong_base(
        &self,
        index: usize,
        others: &[usize],
        modifier: Option<&str>,
        name: &str,
    ) -> Option<(String, &'static str)> {
        let known = self
            .definitions
            .get(index)
            .map(|definition| &definition.kind);
        let Some(Kind::Interface(base)) = known else {
            let is_announced = self
                .facts
                .get(index)
                .is_some_and(|f| f.state == State::Forward("interface"));
            return Some(match is_announced {
                true => (
                    format!("the interface `{name}` is not defined yet"),
                    "define it before the interfaces that inherit from it",
                ),
                false => (format!("`{name}` is no interface"), "name an interface"),
            });
        };
        let own = base.modifier.as_deref();
        if others.contains(&index) {
            Some((format!("`{name}` stands here twice"), "name it once"))
        } else if self.facts[index].state == State::Open {
            Some((
                format!("`{name}` would inherit from itself"),
                "leave it out",
            ))
        } else if modifier == Some("abstract") && own != Some("abstract") {
            Some((
                format!("`{name}` is not abstract"),
                "an abstract interface inherits from abstract ones only",
            ))
        } else if modifier.is_none() && own == Some("local") {
            Some((
                format!("`{name}` is local"),
                "only a local interface inherits from a local one",
            ))
        } else {
            None
        }
    }

    /// Something in an interface.
    fn export(&mut self, interface: &mut Interface) -> Parsed<()> {
        match &self.token {
            Token::Keyword("readonly" | "attribute") => {
                self.attribute(&mut interface.attributes)?;
                self.semicolon("the attribute")
            }
            Token::Keyword(
                "struct" | "union" | "enum" | "exception" | "typedef" | "const" | "native"
                | "valuetype",
            ) => self.type_or_constant("a definition"),
            _ => {
                let operation = self.operation()?;
                interface.operations.extend(operation);
                self.semicolon("the operation")
            }
        }
    }

    /// `readonly attribute type name, name`.
    fn attribute(&mut self, attributes: &mut Vec<Attribute>) -> Parsed<()> {
        let readonly = self.takes_word("readonly");
        if !self.takes_word("attribute") {
            return self.expected("`attribute`", "write `readonly attribute type name;`");
        }
        let read = self.type_spec(super::types::Position::Parameter)?;
        loop {
            let (name, at) = self.identifier("the attribute")?;
            self.declare(&name, What::Operation, at);
            attributes.extend(read.clone().map(|r#type| Attribute {
                name,
                r#type,
                readonly,
            }));
            if !self.takes(",") {
                return Ok(());
            }
        }
    }
}
