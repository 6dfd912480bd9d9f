//! [`Value`] → JSON text, members in the order of the type.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::{BASE64, DISCRIMINATOR, EXACT, FEW_OCTETS};
use crate::cdr::encode::{length_of, mismatch};
use crate::cdr::shape::{Shape, chosen, is_octet, shape};
use crate::cdr::{DEEPEST, Error, Reason, Value, quad};
use crate::idl::{EnumType, Primitive, StructType, Type, Union, Unit};

/// One line of JSON.
pub fn to_json(unit: &Unit, r#type: &Type, value: &Value) -> Result<String, Error> {
    let mut writer = Writer {
        unit,
        text: String::new(),
    };
    writer
        .value(r#type, value, 0)
        .map_err(|error| error.in_type(unit, r#type))?;
    Ok(writer.text)
}

struct Writer<'a> {
    unit: &'a Unit,
    text: String,
}

impl Writer<'_> {
    fn value(&mut self, r#type: &Type, value: &Value, depth: u32) -> Result<(), Error> {
        if depth > DEEPEST {
            return Err(Reason::Deep.into());
        }
        match (shape(self.unit, r#type)?, value) {
            (Shape::Primitive(primitive), value) => self.primitive(primitive, value)?,
            (Shape::String(_), Value::String(text)) => self.string(text),
            (Shape::WString(_), Value::WString(text)) => self.string(text),
            (Shape::Enum(it), Value::Enum(ordinal)) => self.enumerator(it, *ordinal)?,
            (Shape::Sequence(element, _), value) => self.elements(element, &[], value, depth)?,
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

    fn primitive(&mut self, primitive: Primitive, value: &Value) -> Result<(), Reason> {
        match (primitive, value) {
            (Primitive::Boolean, Value::Boolean(it)) => self.put(it),
            (Primitive::Char, Value::Char(it)) => {
                self.string(char::from(*it).encode_utf8(&mut [0; 4]));
            }
            (Primitive::WChar, Value::WChar(it)) => self.string(it.encode_utf8(&mut [0; 4])),
            (Primitive::Float, Value::Float(it)) => self.number(shortest(*it)),
            (Primitive::Double, Value::Double(it)) => self.number(*it),
            (Primitive::LongDouble, Value::LongDouble(bits)) => match quad::narrow(*bits) {
                Some(number) => self.number(number),
                None if quad::is_nan(*bits) => self.number(f64::NAN),
                None => self.string(&format!("0x{bits:032x}")),
            },
            (primitive, value) => match value.integer() {
                Some(number) if Value::from_integer(primitive, number).as_ref() == Some(value) => {
                    let exact = number.unsigned_abs() <= EXACT.into();
                    match exact {
                        true => self.put(number),
                        false => self.string(&number.to_string()),
                    }
                }
                _ => return Err(mismatch(crate::cdr::value::named(primitive), value)),
            },
        }
        Ok(())
    }

    fn put(&mut self, it: impl std::fmt::Display) {
        // A String takes everything.
        let _ = write!(self.text, "{it}");
    }

    fn number(&mut self, number: f64) {
        match serde_json::Number::from_f64(number) {
            Some(number) => self.put(number),
            None if number.is_nan() => self.string("NaN"),
            None if number > 0.0 => self.string("Infinity"),
            None => self.string("-Infinity"),
        }
    }

    fn string(&mut self, text: &str) {
        self.put(serde_json::Value::from(text));
    }

    fn key(&mut self, name: &str, first: bool) {
        self.text.push_str(if first { "{" } else { ", " });
        self.string(name);
        self.text.push_str(": ");
    }

    fn enumerator(&mut self, it: &EnumType, ordinal: u32) -> Result<(), Reason> {
        let count = it.enumerators.len();
        let name = it.enumerators.get(ordinal as usize);
        self.string(name.ok_or(Reason::Enumerator { ordinal, count })?);
        Ok(())
    }

    fn members(&mut self, it: &StructType, values: &[Value], depth: u32) -> Result<(), Error> {
        let (found, count) = (values.len(), it.members.len());
        if found != count {
            return Err(Reason::Members { found, count }.into());
        }
        for (index, (member, value)) in it.members.iter().zip(values).enumerate() {
            self.key(&member.name, index == 0);
            self.value(&member.r#type, value, depth + 1)
                .map_err(|error| error.in_member(&member.name))?;
        }
        self.text.push('}');
        Ok(())
    }

    fn union(
        &mut self,
        union: &Union,
        discriminator: &Value,
        member: Option<&Value>,
        depth: u32,
    ) -> Result<(), Error> {
        self.key(DISCRIMINATOR, true);
        self.value(&union.discriminator, discriminator, depth + 1)
            .map_err(|error| error.in_member(DISCRIMINATOR))?;
        match (chosen(union, discriminator), member) {
            (Some(case), Some(value)) => {
                self.key(&case.name, false);
                self.value(&case.r#type, value, depth + 1)
                    .map_err(|error| error.in_member(&case.name))?;
            }
            (None, None) => {}
            _ => return Err(Reason::Union("its member is not that of its discriminator").into()),
        }
        self.text.push('}');
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

    fn elements(
        &mut self,
        element: &Type,
        inner: &[u32],
        value: &Value,
        depth: u32,
    ) -> Result<(), Error> {
        let octets = inner.is_empty() && is_octet(self.unit, element);
        match value {
            Value::Octets(bytes) if octets && bytes.len() > FEW_OCTETS => {
                self.key(BASE64, true);
                self.string(&BASE64_STANDARD.encode(bytes));
                self.text.push('}');
            }
            Value::Octets(bytes) if octets => {
                let numbers: Vec<String> = bytes.iter().map(u8::to_string).collect();
                self.put(format_args!("[{}]", numbers.join(", ")));
            }
            Value::Sequence(elements) if !octets => {
                self.text.push('[');
                for (index, value) in elements.iter().enumerate() {
                    if index > 0 {
                        self.text.push_str(", ");
                    }
                    self.array(element, inner, value, depth + 1)
                        .map_err(|error| error.in_element(index))?;
                }
                self.text.push(']');
            }
            other if octets => return Err(mismatch("a sequence of octets", other).into()),
            other => return Err(mismatch("a sequence", other).into()),
        }
        Ok(())
    }
}

/// The double that looks shortest and is read as the same float: 0.1, not 0.10000000149011612.
fn shortest(number: f32) -> f64 {
    match number.to_string().parse::<f64>() {
        Ok(short) if short as f32 == number => short,
        _ => number.into(),
    }
}
