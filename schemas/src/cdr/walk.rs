//! The walk through a [`Value`] along its type, for whoever writes it down.

use super::shape::{Shape, chosen, is_octet, shape};
use super::{DEEPEST, Error, Reason, Value};
use crate::idl::{EnumType, Primitive, StructType, Type, Union, Unit};

/// Name of a union's discriminator, in JSON and in the paths of errors. No member has such a name.
pub(super) const DISCRIMINATOR: &str = "$discriminator";

/// What a form of values writes for each part. The walk has checked kinds, counts and enumerators.
pub(super) trait Form {
    fn primitive(&mut self, primitive: Primitive, value: &Value) -> Result<(), Reason>;
    fn string(&mut self, text: &str, bound: Option<u32>) -> Result<(), Reason>;
    fn wstring(&mut self, text: &str, bound: Option<u32>) -> Result<(), Reason>;
    fn enumerator(&mut self, ordinal: u32, name: &str);
    /// The octets of a sequence or an array, all at once.
    fn octets(&mut self, bytes: &[u8]);
    /// A sequence of so many elements begins.
    fn length(&mut self, length: usize, bound: Option<u32>) -> Result<(), Reason>;
    /// Before, between and behind the elements of a sequence or an array that is not of octets.
    fn elements(&mut self, _at: At) {}
    /// A member begins: the first of its struct or union, or another one.
    fn member(&mut self, _name: &str, _first: bool) {}
    /// The last member has ended.
    fn end(&mut self) {}
}

/// Where in the elements of a sequence.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum At {
    Begin,
    Next,
    End,
}

/// Writes a value in a form. Errors name the type and the place.
pub(super) fn write(
    unit: &Unit,
    r#type: &Type,
    value: &Value,
    form: &mut impl Form,
) -> Result<(), Error> {
    Walk { unit, form }
        .value(r#type, value, 0)
        .map_err(|error| error.in_type(unit, r#type))
}

struct Walk<'a, F> {
    unit: &'a Unit,
    form: &'a mut F,
}

impl<F: Form> Walk<'_, F> {
    fn value(&mut self, r#type: &Type, value: &Value, depth: u32) -> Result<(), Error> {
        if depth > DEEPEST {
            return Err(Reason::Deep.into());
        }
        match (shape(self.unit, r#type)?, value) {
            (Shape::Primitive(primitive), value) => self.form.primitive(primitive, value)?,
            (Shape::String(bound), Value::String(text)) => self.form.string(text, bound)?,
            (Shape::WString(bound), Value::WString(text)) => self.form.wstring(text, bound)?,
            (Shape::Enum(it), Value::Enum(ordinal)) => self.enumerator(it, *ordinal)?,
            (Shape::Sequence(element, bound), value) => {
                self.form.length(length_of(value)?, bound)?;
                self.elements(element, &[], value, depth)?;
            }
            (Shape::Array(element, dimensions), value) => {
                self.array(element, dimensions, value, depth)?;
            }
            (Shape::Struct(it), Value::Struct(members)) => self.members(it, members, depth)?,
            (
                Shape::Union(union),
                Value::Union {
                    discriminator,
                    member,
                },
            ) => self.union(union, discriminator, member.as_deref(), depth)?,
            (Shape::String(_), other) => return Err(mismatch("a string", other).into()),
            (Shape::WString(_), other) => return Err(mismatch("a wstring", other).into()),
            (Shape::Enum(_), other) => return Err(mismatch("an enumerator", other).into()),
            (Shape::Struct(_), other) => return Err(mismatch("a struct", other).into()),
            (Shape::Union(_), other) => return Err(mismatch("a union", other).into()),
        }
        Ok(())
    }

    fn enumerator(&mut self, it: &EnumType, ordinal: u32) -> Result<(), Reason> {
        let count = it.enumerators.len();
        let name = it.enumerators.get(ordinal as usize);
        let name = name.ok_or(Reason::Enumerator { ordinal, count })?;
        self.form.enumerator(ordinal, name);
        Ok(())
    }

    fn members(&mut self, it: &StructType, values: &[Value], depth: u32) -> Result<(), Error> {
        let (found, count) = (values.len(), it.members.len());
        if found != count {
            return Err(Reason::Members { found, count }.into());
        }
        for (index, (member, value)) in it.members.iter().zip(values).enumerate() {
            self.member(&member.name, index == 0, &member.r#type, value, depth)?;
        }
        self.form.end();
        Ok(())
    }

    fn member(
        &mut self,
        name: &str,
        first: bool,
        r#type: &Type,
        value: &Value,
        depth: u32,
    ) -> Result<(), Error> {
        self.form.member(name, first);
        self.value(r#type, value, depth + 1)
            .map_err(|error| error.in_member(name))
    }

    fn union(
        &mut self,
        union: &Union,
        discriminator: &Value,
        member: Option<&Value>,
        depth: u32,
    ) -> Result<(), Error> {
        self.member(
            DISCRIMINATOR,
            true,
            &union.discriminator,
            discriminator,
            depth,
        )?;
        match (chosen(union, discriminator), member) {
            (Some(case), Some(value)) => {
                self.member(&case.name, false, &case.r#type, value, depth)?;
            }
            (None, None) => {}
            (Some(_), None) => return Err(Reason::Union("its member is missing").into()),
            (None, Some(_)) => {
                return Err(
                    Reason::Union("its discriminator chooses no member, there is one").into(),
                );
            }
        }
        self.form.end();
        Ok(())
    }

    fn array(
        &mut self,
        element: &Type,
        dimensions: &[u32],
        value: &Value,
        depth: u32,
    ) -> Result<(), Error> {
        let Some((length, inner)) = dimensions.split_first() else {
            return self.value(element, value, depth);
        };
        if depth > DEEPEST {
            return Err(Reason::Deep.into());
        }
        let (found, length) = (length_of(value)?, *length);
        if found != length as usize {
            return Err(Reason::Length { found, length }.into());
        }
        self.elements(element, inner, value, depth)
    }

    /// What is within a sequence, or a dimension of an array.
    fn elements(
        &mut self,
        element: &Type,
        inner: &[u32],
        value: &Value,
        depth: u32,
    ) -> Result<(), Error> {
        let octets = inner.is_empty() && is_octet(self.unit, element);
        match value {
            Value::Octets(bytes) if octets => self.form.octets(bytes),
            Value::Sequence(elements) if !octets => {
                self.form.elements(At::Begin);
                for (index, value) in elements.iter().enumerate() {
                    if index > 0 {
                        self.form.elements(At::Next);
                    }
                    self.array(element, inner, value, depth + 1)
                        .map_err(|error| error.in_element(index))?;
                }
                self.form.elements(At::End);
            }
            other if octets => return Err(mismatch("a sequence of octets", other).into()),
            other => return Err(mismatch("a sequence", other).into()),
        }
        Ok(())
    }
}

pub(super) fn length_of(value: &Value) -> Result<usize, Reason> {
    match value {
        Value::Octets(bytes) => Ok(bytes.len()),
        Value::Sequence(elements) => Ok(elements.len()),
        other => Err(mismatch("a sequence", other)),
    }
}

pub(super) fn mismatch(wanted: &'static str, found: &Value) -> Reason {
    Reason::Mismatch {
        wanted,
        found: found.kind(),
    }
}
