//! Unions.

use std::collections::BTreeMap;

use super::super::model::{ConstantValue, Kind, Label, Primitive, Type, Union, UnionCase};
use super::super::names::What;
use super::super::token::At;
use super::evaluate::Goal;
use super::types::Position;
use super::{Parsed, Reader};

/// The labels of a union so far.
#[derive(Default)]
struct Labels {
    places: BTreeMap<String, At>,
    /// Those that are values.
    values: usize,
    default: Option<At>,
}

impl Reader<'_> {
    /// `union name switch (type) { case …: … }`, or only `union name` where it may be announced.
    pub(super) fn union(&mut self, may_announce: bool) -> Parsed<Option<Type>> {
        self.advance();
        let (name, at) = self.identifier("the union")?;
        if may_announce && self.is(";") {
            self.forward("union", &name, at);
            return Ok(None);
        }
        if !self.takes_word("switch") {
            return self.expected("`switch`", "write `union name switch (long) { case 1: … }`");
        }
        self.expect("(", "the type that decides stands in parentheses")?;
        self.within(|reader| {
            let index = reader.begin("union", &name, at, Kind::Forward);
            let read = reader.cases(&name, at);
            let (discriminator, cases, result) = match read {
                Ok((discriminator, cases, result)) => (discriminator, cases, result),
                Err(lost) => (None, Vec::new(), Err(lost)),
            };
            let discriminator = discriminator.unwrap_or(Type::Primitive(Primitive::Long));
            reader.end(
                index,
                Kind::Union(Union {
                    discriminator,
                    cases,
                }),
            );
            result.map(|()| Some(Type::Named(index)))
        })
    }

    #[allow(clippy::type_complexity, reason = "its parts are taken apart at once")]
    fn cases(&mut self, name: &str, at: At) -> Parsed<(Option<Type>, Vec<UnionCase>, Parsed<()>)> {
        let type_at = self.at;
        let read = self.type_spec(Position::Declaration)?;
        let goal = read
            .as_ref()
            .map_or(Goal::Unknown, |r#type| self.goal(r#type));
        let decides = matches!(
            goal,
            Goal::Integer { .. } | Goal::Boolean | Goal::Char | Goal::Enum(_) | Goal::Unknown
        );
        if !decides || goal.is_octet() {
            let help = "a whole number but no octet, `char`, `boolean` or an enum decides";
            self.error(
                "idl-wrong-name",
                type_at,
                "no union is decided by this type",
                help,
            );
        }
        self.expect(")", "the type that decides stands in parentheses")?;
        self.expect("{", "a union has its cases in braces")?;
        if self.is("}") {
            let message = format!("the union `{name}` is empty");
            self.error("idl-syntax", at, message, "a union has at least one case");
        }
        let mut cases = Vec::new();
        let mut labels = Labels::default();
        let result = self.parts(&format!("the union `{name}`"), |reader| {
            let case = reader.case(&goal, &mut labels)?;
            cases.extend(case);
            Ok(())
        });
        self.all_labels(&goal, &labels);
        Ok((read, cases, result))
    }

    /// `case 1: case 2: type name;`
    fn case(&mut self, goal: &Goal, all: &mut Labels) -> Parsed<Option<UnionCase>> {
        let mut labels = Vec::new();
        loop {
            let at = self.at;
            let label = if self.takes_word("default") {
                Some(Label::Default)
            } else if self.takes_word("case") {
                self.constant_of(goal)?.map(Label::Value)
            } else if labels.is_empty() {
                return self.expected(
                    "`case` or `default`",
                    "each member of a union has its labels before it",
                );
            } else {
                break;
            };
            self.expect(":", "a label ends with `:`")?;
            let at = At {
                file: at.file,
                span: crate::span::Span {
                    start: at.span.start,
                    end: self.before.span.end,
                },
            };
            if let Some(label) = &label {
                self.one_label(label, at, all);
            }
            labels.push(label);
        }
        let read = self.type_spec(Position::Declaration)?;
        let declarator = self.declarator("the case")?;
        self.declare(&declarator.name, What::Member, declarator.at);
        let known = read.and_then(|r#type| self.with_dimensions(r#type, &declarator));
        self.semicolon("the case")?;
        Ok(known.map(|r#type| UnionCase {
            labels: labels.into_iter().flatten().collect(),
            name: declarator.name,
            r#type,
        }))
    }

    fn one_label(&mut self, label: &Label, at: At, all: &mut Labels) {
        // As text, since a constant may hold a number without an order.
        if let Some(known) = all.places.insert(format!("{label:?}"), at) {
            let place = self.input.findings.shown(known);
            let help = format!("leave out one of them; the other is at {place}");
            self.error("idl-bad-label", at, "this label stands twice", help);
        } else if *label == Label::Default {
            all.default = Some(at);
        } else if !matches!(label, Label::Value(ConstantValue::Text(_))) {
            all.values += 1;
        }
    }

    /// `default` must be able to happen.
    fn all_labels(&mut self, goal: &Goal, labels: &Labels) {
        let count = match goal {
            Goal::Boolean => 2,
            Goal::Enum(index) => match &self.definitions[*index].kind {
                Kind::Enum(found) => found.enumerators.len(),
                _ => return,
            },
            Goal::Char => 256,
            _ => return,
        };
        if let Some(at) = labels.default.filter(|_| labels.values >= count) {
            let help = "leave it out: each value has a case of its own";
            self.error("idl-bad-label", at, "no value is left for `default`", help);
        }
    }
}
