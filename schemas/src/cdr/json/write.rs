//! [`Value`] → JSON text, members in the order of the type.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::{BASE64, EXACT, FEW_OCTETS};
use crate::cdr::walk::{At, Form, mismatch, write};
use crate::cdr::{Error, Reason, Value, quad};
use crate::idl::{Primitive, Type, Unit};

/// One line of JSON.
pub fn to_json(unit: &Unit, r#type: &Type, value: &Value) -> Result<String, Error> {
    let mut writer = Writer {
        text: String::new(),
    };
    write(unit, r#type, value, &mut writer)?;
    Ok(writer.text)
}

struct Writer {
    text: String,
}

impl Form for Writer {
    fn primitive(&mut self, primitive: Primitive, value: &Value) -> Result<(), Reason> {
        match (primitive, value) {
            (Primitive::Boolean, Value::Boolean(it)) => self.put(it),
            (Primitive::Char, Value::Char(it)) => {
                self.text_of(char::from(*it).encode_utf8(&mut [0; 4]));
            }
            (Primitive::WChar, Value::WChar(it)) => self.text_of(it.encode_utf8(&mut [0; 4])),
            (Primitive::Float, Value::Float(it)) => self.number(shortest(*it)),
            (Primitive::Double, Value::Double(it)) => self.number(*it),
            (Primitive::LongDouble, Value::LongDouble(bits)) => match quad::narrow(*bits) {
                Some(number) => self.number(number),
                None if quad::is_nan(*bits) => self.number(f64::NAN),
                None => self.text_of(&format!("0x{bits:032x}")),
            },
            (primitive, value) => match value.integer() {
                Some(number) if Value::from_integer(primitive, number).as_ref() == Some(value) => {
                    let exact = number.unsigned_abs() <= EXACT.into();
                    match exact {
                        true => self.put(number),
                        false => self.text_of(&number.to_string()),
                    }
                }
                _ => return Err(mismatch(crate::cdr::value::named(primitive), value)),
            },
        }
        Ok(())
    }

    fn string(&mut self, text: &str, _bound: Option<u32>) -> Result<(), Reason> {
        self.text_of(text);
        Ok(())
    }

    fn wstring(&mut self, text: &str, bound: Option<u32>) -> Result<(), Reason> {
        self.string(text, bound)
    }

    fn enumerator(&mut self, _ordinal: u32, name: &str) {
        self.text_of(name);
    }

    fn octets(&mut self, bytes: &[u8]) {
        if bytes.len() > FEW_OCTETS {
            self.member(BASE64, true);
            self.text_of(&BASE64_STANDARD.encode(bytes));
            self.end();
        } else {
            let numbers: Vec<String> = bytes.iter().map(u8::to_string).collect();
            self.put(format_args!("[{}]", numbers.join(", ")));
        }
    }

    fn length(&mut self, _length: usize, _bound: Option<u32>) -> Result<(), Reason> {
        Ok(())
    }

    fn elements(&mut self, at: At) {
        self.text.push_str(match at {
            At::Begin => "[",
            At::Next => ", ",
            At::End => "]",
        });
    }

    fn member(&mut self, name: &str, first: bool) {
        self.text.push_str(if first { "{" } else { ", " });
        self.text_of(name);
        self.text.push_str(": ");
    }

    fn end(&mut self) {
        self.text.push('}');
    }
}

impl Writer {
    fn put(&mut self, it: impl std::fmt::Display) {
        // A String takes everything.
        let _ = write!(self.text, "{it}");
    }

    fn number(&mut self, number: f64) {
        match serde_json::Number::from_f64(number) {
            Some(number) => self.put(number),
            None if number.is_nan() => self.text_of("NaN"),
            None if number > 0.0 => self.text_of("Infinity"),
            None => self.text_of("-Infinity"),
        }
    }

    fn text_of(&mut self, text: &str) {
        self.put(serde_json::Value::from(text));
    }
}

/// The double that looks shortest and is read as the same float: 0.1, not 0.10000000149011612.
fn shortest(number: f32) -> f64 {
    match number.to_string().parse::<f64>() {
        Ok(short) if short as f32 == number => short,
        _ => number.into(),
    }
}
