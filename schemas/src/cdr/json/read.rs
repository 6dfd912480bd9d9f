//! JSON → [`Value`].

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Map, Value as Json};

use super::{BASE64, EXACT};
use crate::cdr::encode::bounded;
use crate::cdr::shape::{Shape, chosen, discriminator, is_octet, shape};
use crate::cdr::walk::DISCRIMINATOR;
use crate::cdr::{DEEPEST, Error, Reason, Value, quad, zero};
use crate::idl::{EnumType, Primitive, StructType, Type, Union, UnionCase, Unit};
use crate::suggest;

/// The value that a JSON text describes.
pub fn from_json(unit: &Unit, r#type: &Type, json: &Json) -> Result<Value, Error> {
    Reader { unit }
        .value(r#type, json, 0)
        .map_err(|error| error.in_type(unit, r#type))
}

struct Reader<'a> {
    unit: &'a Unit,
}

impl Reader<'_> {
    fn value(&self, r#type: &Type, json: &Json, depth: u32) -> Result<Value, Error> {
        if depth > DEEPEST {
            return Err(Reason::Deep.into());
        }
        Ok(match (shape(self.unit, r#type)?, json) {
            (Shape::Primitive(primitive), json) => scalar(primitive, json)?,
            (Shape::String(bound), Json::String(text)) => {
                bounded(text.len(), bound)?;
                Value::String(whole(text)?)
            }
            (Shape::WString(bound), Json::String(text)) => {
                bounded(text.encode_utf16().count(), bound)?;
                Value::WString(whole(text)?)
            }
            (Shape::Enum(it), Json::String(name)) => enumerator(it, name)?,
            (Shape::Struct(it), Json::Object(map)) => self.members(it, map, depth)?,
            (Shape::Union(union), Json::Object(map)) => self.union(union, map, depth)?,
            (Shape::Sequence(element, bound), json) => {
                let value = self.elements(element, &[], json, depth)?;
                let length = crate::cdr::walk::length_of(&value)?;
                bounded(length, bound)?;
                value
            }
            (Shape::Array(element, dimensions), json) => {
                self.array(element, dimensions, json, depth)?
            }
            (Shape::String(_) | Shape::WString(_), json) => return Err(not("a text", json).into()),
            (Shape::Enum(_), json) => {
                return Err(not("the name of an enumerator", json).into());
            }
            (Shape::Struct(_) | Shape::Union(_), json) => {
                return Err(not("an object", json).into());
            }
        })
    }

    fn members(
        &self,
        it: &StructType,
        map: &Map<String, Json>,
        depth: u32,
    ) -> Result<Value, Error> {
        let names = || it.members.iter().map(|member| member.name.as_str());
        if let Some(key) = map.keys().find(|key| !names().any(|name| name == *key)) {
            return Err(unknown("member", key, names()).into());
        }
        let mut values = Vec::with_capacity(it.members.len());
        for member in &it.members {
            let value = match map.get(&member.name) {
                Some(json) => self.value(&member.r#type, json, depth + 1),
                None => zero(self.unit, &member.r#type).map_err(|error| error.reason.into()),
            };
            values.push(value.map_err(|error| error.in_member(&member.name))?);
        }
        Ok(Value::Struct(values))
    }

    fn union(&self, union: &Union, map: &Map<String, Json>, depth: u32) -> Result<Value, Error> {
        let mut given = map.iter().filter(|(key, _)| *key != DISCRIMINATOR);
        let member = given.next();
        if let Some((key, _)) = given.next() {
            return Err(Reason::Json(format!("a union has one member, `{key}` is another")).into());
        }
        let discriminator = match (map.get(DISCRIMINATOR), member) {
            (Some(json), _) => self
                .value(&union.discriminator, json, depth + 1)
                .map_err(|error| error.in_member(DISCRIMINATOR))?,
            (None, Some((key, _))) => self.deduced(union, key)?,
            (None, None) => {
                return Err(Reason::Json(format!("`{DISCRIMINATOR}` is missing")).into());
            }
        };
        let member = match (chosen(union, &discriminator), member) {
            (Some(case), Some((key, json))) if case.name == *key => Some(
                self.value(&case.r#type, json, depth + 1)
                    .map_err(|error| error.in_member(key))?,
            ),
            (None, None) => None,
            (case, _) => return Err(other_member(case).into()),
        };
        Ok(Value::Union {
            discriminator: Box::new(discriminator),
            member: member.map(Box::new),
        })
    }

    /// The discriminator of a member that is named alone.
    fn deduced(&self, union: &Union, key: &str) -> Result<Value, Reason> {
        let names = || union.cases.iter().map(|case| case.name.as_str());
        let Some(case) = union.cases.iter().find(|case| case.name == key) else {
            return Err(unknown("member", key, names()));
        };
        let mut labels = case.labels.iter();
        labels
            .find_map(|label| discriminator(self.unit, union, label))
            .ok_or_else(|| {
                let why = "many discriminators choose this member";
                Reason::Json(format!("`{DISCRIMINATOR}` is missing: {why}"))
            })
    }

    fn array(
        &self,
        element: &Type,
        dimensions: &[u32],
        json: &Json,
        depth: u32,
    ) -> Result<Value, Error> {
        let Some((length, inner)) = dimensions.split_first() else {
            return self.value(element, json, depth);
        };
        if depth > DEEPEST {
            return Err(Reason::Deep.into());
        }
        let value = self.elements(element, inner, json, depth)?;
        let (found, length) = (crate::cdr::walk::length_of(&value)?, *length);
        if found != length as usize {
            return Err(Reason::Length { found, length }.into());
        }
        Ok(value)
    }

    fn elements(
        &self,
        element: &Type,
        inner: &[u32],
        json: &Json,
        depth: u32,
    ) -> Result<Value, Error> {
        if inner.is_empty() && is_octet(self.unit, element) {
            return octets(json);
        }
        let Json::Array(elements) = json else {
            return Err(not("an array", json).into());
        };
        let mut values = Vec::with_capacity(elements.len());
        for (index, json) in elements.iter().enumerate() {
            let value = self.array(element, inner, json, depth + 1);
            values.push(value.map_err(|error| error.in_element(index))?);
        }
        Ok(Value::Sequence(values))
    }
}

fn scalar(primitive: Primitive, json: &Json) -> Result<Value, Reason> {
    let wanted = || crate::cdr::value::named(primitive);
    match primitive {
        Primitive::Boolean => json.as_bool().map(Value::Boolean),
        Primitive::Char => {
            character(json).and_then(|it| u8::try_from(u32::from(it)).ok().map(Value::Char))
        }
        Primitive::WChar => character(json)
            .filter(|it| *it <= '\u{ffff}')
            .map(Value::WChar),
        Primitive::Float => float(json)
            // A number that only a double can hold is no float; infinity is written as a word.
            .filter(|it| !it.is_finite() || (*it as f32).is_finite())
            .map(|it| Value::Float(it as f32)),
        Primitive::Double => float(json).map(Value::Double),
        Primitive::LongDouble => bits(json)
            .or_else(|| float(json).map(quad::widen))
            .map(Value::LongDouble),
        _ => integer(json).and_then(|number| Value::from_integer(primitive, number)),
    }
    .ok_or_else(|| not(wanted(), json))
}

/// A whole number, also as a text, or as `3.0`.
fn integer(json: &Json) -> Option<i128> {
    match json {
        Json::String(text) => text.parse().ok(),
        Json::Number(number) => {
            let whole = number.as_i64().map(i128::from);
            let whole = whole.or_else(|| number.as_u64().map(i128::from));
            whole.or_else(|| {
                let near = |it: &f64| it.fract() == 0.0 && it.abs() <= EXACT as f64;
                number.as_f64().filter(near).map(|it| it as i128)
            })
        }
        _ => None,
    }
}

fn float(json: &Json) -> Option<f64> {
    match json {
        Json::Number(number) => number.as_f64(),
        Json::String(text) => match text.as_str() {
            "NaN" => Some(f64::NAN),
            "Infinity" => Some(f64::INFINITY),
            "-Infinity" => Some(f64::NEG_INFINITY),
            _ => None,
        },
        _ => None,
    }
}

/// The bits of a long double.
fn bits(json: &Json) -> Option<u128> {
    let digits = json.as_str()?.strip_prefix("0x")?;
    let hex = digits.len() == 32 && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    hex.then(|| u128::from_str_radix(digits, 16).ok()).flatten()
}

fn character(json: &Json) -> Option<char> {
    let mut characters = json.as_str()?.chars();
    let first = characters.next()?;
    characters.next().is_none().then_some(first)
}

fn whole(text: &str) -> Result<String, Reason> {
    match text.contains('\0') {
        true => Err(Reason::Text("a string cannot hold a zero")),
        false => Ok(text.to_owned()),
    }
}

fn enumerator(it: &EnumType, name: &str) -> Result<Value, Reason> {
    let names = || it.enumerators.iter().map(String::as_str);
    names()
        .zip(0..)
        .find(|(enumerator, _)| *enumerator == name)
        .map(|(_, ordinal)| Value::Enum(ordinal))
        .ok_or_else(|| unknown("enumerator", name, names()))
}

fn octets(json: &Json) -> Result<Value, Error> {
    match json {
        Json::Object(map) if map.len() == 1 && map.contains_key(BASE64) => {
            let text = map.get(BASE64).and_then(Json::as_str);
            text.and_then(|text| BASE64_STANDARD.decode(text).ok())
                .map(Value::Octets)
                .ok_or_else(|| Reason::Json(format!("`{BASE64}` is no base64")).into())
        }
        Json::Array(elements) => {
            let octet = |json| integer(json).and_then(|number| u8::try_from(number).ok());
            let bytes = elements.iter().enumerate().map(|(index, json)| {
                octet(json).ok_or_else(|| Error::from(not("an octet", json)).in_element(index))
            });
            bytes.collect::<Result<_, _>>().map(Value::Octets)
        }
        json => Err(not("an array", json).into()),
    }
}

fn other_member(case: Option<&UnionCase>) -> Reason {
    Reason::Json(match case {
        Some(case) => format!("its discriminator chooses the member `{}`", case.name),
        None => "its discriminator chooses no member".to_owned(),
    })
}

fn unknown<'a>(what: &str, name: &str, names: impl Iterator<Item = &'a str>) -> Reason {
    let names: Vec<&str> = names.collect();
    let advice = suggest::advice(name, "there are", &names);
    Reason::Json(format!("there is no {what} `{name}`; {advice}"))
}

fn not(wanted: &str, json: &Json) -> Reason {
    const SHOWN: usize = 40;
    let text = json.to_string();
    let shown: String = text.chars().take(SHOWN).collect();
    let more = if shown.len() < text.len() { "…" } else { "" };
    Reason::Json(format!("{shown}{more} is not {wanted}"))
}
