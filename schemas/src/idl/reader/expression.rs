//! Expressions of constants.

use super::super::model::Kind;
use super::super::names::What;
use super::super::token::{At, Token};
use super::evaluate::{Goal, Value, combine};
use super::{Parsed, Reader};
use crate::span::Span;

/// Operators, those that bind loosest first.
const LEVELS: [&[&str]; 6] = [
    &["|"],
    &["^"],
    &["&"],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

impl Reader<'_> {
    /// An expression with its place. `None` if it has no value, which was told.
    pub(super) fn expression(&mut self, goal: &Goal) -> Parsed<(Option<Value>, At)> {
        self.level(0, goal)
    }

    fn level(&mut self, level: usize, goal: &Goal) -> Parsed<(Option<Value>, At)> {
        let Some(operators) = LEVELS.get(level) else {
            return self.unary(goal);
        };
        let (mut left, mut at) = self.level(level + 1, goal)?;
        while let Token::Symbol(operator) = self.token {
            if !operators.contains(&operator) {
                break;
            }
            self.advance();
            let (right, right_at) = self.level(level + 1, goal)?;
            at = to(at, right_at);
            left = match left.zip(right) {
                Some((left, right)) => match combine(operator, &left, &right) {
                    Ok(value) => Some(value),
                    Err((message, help)) => {
                        self.error("idl-bad-value", at, message, help);
                        None
                    }
                },
                None => None,
            };
        }
        Ok((left, at))
    }

    fn unary(&mut self, goal: &Goal) -> Parsed<(Option<Value>, At)> {
        let start = self.at;
        let Token::Symbol(operator @ ("-" | "+" | "~")) = self.token else {
            return self.primary(goal);
        };
        self.advance();
        let (value, at) = self.primary(goal)?;
        let at = to(start, at);
        let value = value.and_then(|value| match (operator, value) {
            ("-", Value::Integer(value)) => Some(Value::Integer(-value)),
            ("-", Value::Float(value)) => Some(Value::Float(-value)),
            ("+", value @ (Value::Integer(_) | Value::Float(_))) => Some(value),
            ("~", Value::Integer(value)) => Some(Value::Integer(goal.complement(value))),
            (_, value) => {
                let message = format!("`{operator}` has no meaning before {}", value.kind());
                self.error("idl-bad-value", at, message, "leave it out");
                None
            }
        });
        Ok((value, at))
    }

    fn primary(&mut self, goal: &Goal) -> Parsed<(Option<Value>, At)> {
        let at = self.at;
        let value =
            match &mut self.token {
                Token::Symbol("(") => {
                    return self.within(|reader| {
                        reader.advance();
                        let (value, inner) = reader.expression(goal)?;
                        let end = to(inner, reader.at);
                        reader.expect(")", "close what `(` opens")?;
                        Ok((value, to(at, end)))
                    });
                }
                Token::Integer(value) => Value::Integer((*value).into()),
                Token::Float(value) => Value::Float(*value),
                Token::Char(value) => Value::Char(*value),
                Token::WChar(value) => Value::WChar(*value),
                Token::Text(value) => Value::Text(std::mem::take(value)),
                Token::WText(value) => Value::WText(std::mem::take(value)),
                Token::Keyword("TRUE") => Value::Boolean(true),
                Token::Keyword("FALSE") => Value::Boolean(false),
                Token::Symbol("::") | Token::Identifier(_) => return self.named_value(),
                Token::Bad => {
                    self.advance();
                    return Ok((None, at));
                }
                _ => return self.expected(
                    "a value",
                    "write a number, a character, a string, TRUE, FALSE or the name of a constant",
                ),
            };
        self.advance();
        self.strings(value, at)
    }

    /// Strings that follow each other are one.
    fn strings(&mut self, mut value: Value, mut at: At) -> Parsed<(Option<Value>, At)> {
        loop {
            match (&mut value, &self.token) {
                (Value::Text(text), Token::Text(next))
                | (Value::WText(text), Token::WText(next)) => text.push_str(next),
                _ => return Ok((Some(value), at)),
            }
            at = to(at, self.at);
            self.advance();
        }
    }

    fn named_value(&mut self) -> Parsed<(Option<Value>, At)> {
        let name = self.scoped_name("a constant")?;
        let value = match self.resolve(&name) {
            None => None,
            Some(What::Enumerator(definition, ordinal)) => Some(Value::Enumerator {
                definition,
                ordinal,
            }),
            Some(What::Definition(index)) => match &self.definitions[index].kind {
                Kind::Constant(constant) => {
                    let (r#type, value) = (constant.r#type.clone(), constant.value.clone());
                    Some(Value::of(value, &self.goal(&r#type)))
                }
                _ => {
                    self.no_value(&name.shown(), name.at);
                    None
                }
            },
            Some(_) => {
                self.no_value(&name.shown(), name.at);
                None
            }
        };
        Ok((value, name.at))
    }

    fn no_value(&mut self, name: &str, at: At) {
        let message = format!("`{name}` is no constant");
        self.error(
            "idl-wrong-name",
            at,
            message,
            "name a constant or an enumerator",
        );
    }
}

/// From the start of one to the end of another.
fn to(start: At, end: At) -> At {
    if start.file != end.file {
        return start;
    }
    At {
        file: start.file,
        span: Span {
            start: start.span.start,
            end: end.span.end.max(start.span.end),
        },
    }
}
