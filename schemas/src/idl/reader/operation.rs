//! Operations.

use super::super::model::{Direction, Kind, Operation, Parameter};
use super::super::names::What;
use super::super::token::{At, Token};
use super::types::Position;
use super::{Parsed, Reader};

impl Reader<'_> {
    /// `oneway type name (in type name, …) raises (…) context (…)`.
    pub(super) fn operation(&mut self) -> Parsed<Option<Operation>> {
        let oneway = self.takes_word("oneway");
        let result_at = self.at;
        let (result, known) = match self.takes_word("void") {
            true => (None, true),
            false => {
                let read = self.type_spec(Position::Parameter)?;
                let known = read.is_some();
                (read, known)
            }
        };
        let (name, at) = self.identifier("the operation")?;
        if !self.is("(") {
            let help = "an operation has its parameters in parentheses, an attribute has `attribute` before it";
            return self.expected("`(`", help);
        }
        self.declare(&name, What::Operation, at);
        if oneway && (result.is_some() || !known) {
            let help = "nobody waits for a oneway operation: its result is `void`";
            self.error(
                "idl-bad-operation",
                result_at,
                "a oneway operation has a result",
                help,
            );
        }
        let scope = self.scope;
        self.enter("(", What::Unknown, at);
        let parameters = self.parameters(oneway);
        self.leave();
        self.scope = scope;
        let parameters = parameters?;
        let raises = self.raises(oneway)?;
        if self.takes_word("context") {
            self.contexts()?;
        }
        Ok(known.then_some(Operation {
            name,
            oneway,
            result,
            parameters,
            raises,
        }))
    }

    fn parameters(&mut self, oneway: bool) -> Parsed<Vec<Parameter>> {
        let mut parameters = Vec::new();
        self.expect("(", "parameters stand in parentheses")?;
        if self.takes(")") {
            return Ok(parameters);
        }
        loop {
            let at = self.at;
            let direction = match &self.token {
                Token::Keyword("in") => Direction::In,
                Token::Keyword("out") => Direction::Out,
                Token::Keyword("inout") => Direction::InOut,
                _ => {
                    return self.expected(
                        "`in`, `out` or `inout`",
                        "each parameter says which way it goes",
                    );
                }
            };
            self.advance();
            if oneway && direction != Direction::In {
                let help = "nobody waits for a oneway operation: all of its parameters are `in`";
                self.error(
                    "idl-bad-operation",
                    at,
                    "a oneway operation gives a parameter back",
                    help,
                );
            }
            let read = self.type_spec(Position::Parameter)?;
            let (name, at) = self.identifier("the parameter")?;
            self.declare(&name, What::Member, at);
            parameters.extend(read.map(|r#type| Parameter {
                direction,
                name,
                r#type,
            }));
            if !self.takes(",") {
                self.expect(
                    ")",
                    "parameters are separated by commas, and `)` follows the last one",
                )?;
                return Ok(parameters);
            }
        }
    }

    /// `raises (A, B)`.
    fn raises(&mut self, oneway: bool) -> Parsed<Vec<usize>> {
        let mut raises = Vec::new();
        let at = self.at;
        if !self.takes_word("raises") {
            return Ok(raises);
        }
        if oneway {
            let help = "nobody waits for a oneway operation: leave `raises` out";
            self.error(
                "idl-bad-operation",
                at,
                "a oneway operation raises exceptions",
                help,
            );
        }
        self.expect("(", "exceptions stand in parentheses")?;
        loop {
            let name = self.scoped_name("an exception")?;
            if let Some(what) = self.resolve(&name) {
                let exception = match what {
                    What::Definition(index) => Some(index).filter(|index| {
                        matches!(self.definitions[*index].kind, Kind::Exception(_))
                    }),
                    _ => None,
                };
                match exception {
                    Some(index) if raises.contains(&index) => self.twice(&name.shown(), name.at),
                    Some(index) => raises.push(index),
                    None => {
                        let message = format!("`{}` is no exception", name.shown());
                        self.error("idl-wrong-name", name.at, message, "name an `exception`");
                    }
                }
            }
            if !self.takes(",") {
                self.expect(
                    ")",
                    "exceptions are separated by commas, and `)` follows the last one",
                )?;
                return Ok(raises);
            }
        }
    }

    fn twice(&mut self, name: &str, at: At) {
        let message = format!("`{name}` is raised twice");
        self.error("idl-bad-operation", at, message, "name it once");
    }

    /// `("name", "name")`: which properties of a context travel. Nobody uses them.
    fn contexts(&mut self) -> Parsed<()> {
        self.expect("(", "names stand in parentheses")?;
        loop {
            match self.token {
                Token::Text(_) => self.advance(),
                _ => return self.expected("a string", "write `context (\"name\")`"),
            }
            if !self.takes(",") {
                return self.expect(
                    ")",
                    "names are separated by commas, and `)` follows the last one",
                );
            }
        }
    }
}
