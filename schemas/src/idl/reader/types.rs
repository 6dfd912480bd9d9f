//! Types where they are used.

use super::super::model::{Kind, Primitive, Type};
use super::super::names::What;
use super::super::token::{At, Token};
use super::{Parsed, Reader, State};

/// Where a type stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Position {
    /// Of a member, a case or a typedef: any.
    Declaration,
    /// Of the elements of a sequence: none that is defined there.
    Element,
    /// Of a parameter, a result, an attribute or a constant: none without a name of its own but strings.
    Parameter,
}

/// A name with its dimensions.
#[derive(Debug, Clone)]
pub(super) struct Declarator {
    pub name: String,
    pub at: At,
    /// `None` for one that is wrong, which was told.
    pub dimensions: Vec<Option<u32>>,
}

impl Reader<'_> {
    /// A type; `None` if it means nothing, which was told.
    pub(super) fn type_spec(&mut self, position: Position) -> Parsed<Option<Type>> {
        let Token::Keyword(word) = self.token else {
            return match self.is("::") || matches!(self.token, Token::Identifier(_)) {
                true => self.named_type(position),
                false => self.expected(
                    "a type",
                    "write a type here, such as `long` or the name of a struct",
                ),
            };
        };
        match word {
            "struct" | "union" | "enum" if position != Position::Declaration => {
                let help = format!("define the {word} before it, and use its name");
                self.expected("the name of a type", &help)
            }
            "struct" => self.structure(false),
            "union" => self.union(false),
            "enum" => self.enumeration(),
            "sequence" if position == Position::Parameter => {
                let help = "give the sequence a name: `typedef sequence<…> Name;`";
                self.expected("the name of a type", help)
            }
            "sequence" => self.within(Self::sequence),
            "string" | "wstring" => {
                self.advance();
                let bound = self.bound()?;
                Ok(bound.map(|bound| match word {
                    "string" => Type::String { bound },
                    _ => Type::WString { bound },
                }))
            }
            "fixed" | "ValueBase" | "valuetype" | "native" => {
                let at = self.at;
                let help = match word {
                    "fixed" => "use `double`, or a `long` of the smallest unit",
                    _ => "use a struct of the values that are to be sent",
                };
                self.error(
                    "idl-not-supported",
                    at,
                    format!("the type `{word}` is not supported"),
                    help,
                );
                self.advance();
                if word == "fixed" && self.takes("<") {
                    self.size()?;
                    self.expect(",", "a `fixed` type has two numbers")?;
                    self.size_or_zero()?;
                    self.expect(">", "close what `<` opens")?;
                }
                Ok(None)
            }
            "void" => self.expected("a type", "only operations have the result `void`"),
            _ => self.primitive(word),
        }
    }

    fn primitive(&mut self, word: &'static str) -> Parsed<Option<Type>> {
        let primitive = match word {
            "boolean" => Primitive::Boolean,
            "octet" => Primitive::Octet,
            "char" => Primitive::Char,
            "wchar" => Primitive::WChar,
            "short" => Primitive::Short,
            "float" => Primitive::Float,
            "double" => Primitive::Double,
            "any" | "Object" => {
                self.advance();
                return Ok(Some(if word == "any" {
                    Type::Any
                } else {
                    Type::Object
                }));
            }
            "long" => {
                self.advance();
                let primitive = match &self.token {
                    Token::Keyword("long") => Primitive::LongLong,
                    Token::Keyword("double") => Primitive::LongDouble,
                    _ => return Ok(Some(Type::Primitive(Primitive::Long))),
                };
                self.advance();
                return Ok(Some(Type::Primitive(primitive)));
            }
            "unsigned" => {
                self.advance();
                if self.takes_word("short") {
                    return Ok(Some(Type::Primitive(Primitive::UShort)));
                }
                if !self.takes_word("long") {
                    let help =
                        "`unsigned short`, `unsigned long` and `unsigned long long` are known";
                    return self.expected("`short` or `long`", help);
                }
                let primitive = match self.takes_word("long") {
                    true => Primitive::ULongLong,
                    false => Primitive::ULong,
                };
                return Ok(Some(Type::Primitive(primitive)));
            }
            _ => {
                let help =
                    format!("`{word}` is a keyword, no type; write `_{word}` to use it as a name");
                return self.expected("a type", &help);
            }
        };
        self.advance();
        Ok(Some(Type::Primitive(primitive)))
    }

    fn sequence(&mut self) -> Parsed<Option<Type>> {
        self.advance();
        self.expect("<", "write the type of the elements: `sequence<long>`")?;
        let element = self.type_spec(Position::Element)?;
        let bound = match self.takes(",") {
            true => self.size()?.map(Some),
            false => Some(None),
        };
        self.close_angle()?;
        Ok(element.zip(bound).map(|(element, bound)| Type::Sequence {
            element: Box::new(element),
            bound,
        }))
    }

    /// `<N>` behind a string; without it there is no bound.
    fn bound(&mut self) -> Parsed<Option<Option<u32>>> {
        if !self.takes("<") {
            return Ok(Some(None));
        }
        let bound = self.size()?;
        self.close_angle()?;
        Ok(bound.map(Some))
    }

    fn close_angle(&mut self) -> Parsed<()> {
        let help = match self.is(">>") {
            true => "write `> >`: `>>` is the operator that shifts",
            false => "close what `<` opens",
        };
        self.expect(">", help)
    }

    fn named_type(&mut self, position: Position) -> Parsed<Option<Type>> {
        let name = self.scoped_name("a type")?;
        let Some(what) = self.resolve(&name) else {
            return Ok(None);
        };
        let index = match what {
            What::Definition(index) => index,
            _ => return Ok(self.no_type(&name.shown(), name.at, what_is(what))),
        };
        match &self.definitions[index].kind {
            Kind::Constant(_) => return Ok(self.no_type(&name.shown(), name.at, "a constant")),
            Kind::Exception(_) => return Ok(self.no_type(&name.shown(), name.at, "an exception")),
            _ => {}
        }
        let r#type = Type::Named(index);
        let waits = self.facts[index]
            .waits_for
            .filter(|other| matches!(self.facts[*other].state, State::Forward(_)));
        if position != Position::Element && (self.incomplete(&r#type).is_some() || waits.is_some())
        {
            let message = match self.facts[index].state {
                State::Open => format!("`{}` would hold itself", name.shown()),
                _ => format!("`{}` is not defined yet", name.shown()),
            };
            let help = match (waits, self.facts[index].state) {
                (Some(_), _) => "define what its elements are before it",
                (None, State::Open) => "use a sequence of it: `sequence<…>` may be empty",
                _ => "define it before its use; only a sequence of it may come before",
            };
            self.error("idl-incomplete-type", name.at, message, help);
            return Ok(None);
        }
        Ok(Some(r#type))
    }

    fn no_type(&mut self, name: &str, at: At, what: &str) -> Option<Type> {
        let message = format!("`{name}` is {what}, no type");
        let help = "name a struct, a union, an enum, a typedef or an interface";
        self.error("idl-wrong-name", at, message, help);
        None
    }

    /// The struct or union that a type needs, and that is not complete.
    pub(super) fn incomplete(&self, r#type: &Type) -> Option<usize> {
        let Type::Named(index) = r#type else {
            return None;
        };
        match self.facts[*index].state {
            State::Complete | State::Forward("interface") => None,
            State::Open if matches!(self.definitions[*index].kind, Kind::Interface(_)) => None,
            _ => Some(*index),
        }
    }

    /// `name`, `name[2][3]`.
    pub(super) fn declarator(&mut self, what: &str) -> Parsed<Declarator> {
        let (name, at) = self.identifier(what)?;
        let mut dimensions = Vec::new();
        while self.takes("[") {
            dimensions.push(self.size()?);
            self.expect("]", "close what `[` opens")?;
        }
        Ok(Declarator {
            name,
            at,
            dimensions,
        })
    }

    /// The type of what is declared; `None` if a dimension is wrong.
    pub(super) fn with_dimensions(
        &mut self,
        r#type: Type,
        declarator: &Declarator,
    ) -> Option<Type> {
        if declarator.dimensions.is_empty() {
            return Some(r#type);
        }
        let array = Type::Array {
            element: Box::new(r#type),
            dimensions: declarator
                .dimensions
                .iter()
                .copied()
                .collect::<Option<_>>()?,
        };
        self.fits_memory(&array, declarator.at).then_some(array)
    }
}

fn what_is(what: What) -> &'static str {
    match what {
        What::Module(_) => "a module",
        What::Enumerator(..) => "an enumerator",
        What::Operation => "an operation or an attribute",
        _ => "a member",
    }
}
