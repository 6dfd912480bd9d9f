//! Any type and any value of it, made of bytes: the laws and the fuzz target draw the bytes.

use super::{
    ConstantValue, Definition, EnumType, Kind, Label, Member, Primitive, Span, StructType, Type,
    Typedef, Union, UnionCase, Unit, Value,
};

/// Bytes to choose by; after their end, zeros.
pub struct Choices<'a> {
    /// Bytes that are left.
    pub bytes: &'a [u8],
    /// Only what omniORB for Python carries too: no long double, no large unsigned long long, ASCII in bounded strings.
    pub plain: bool,
}

const PRIMITIVES: [Primitive; 13] = [
    Primitive::Octet,
    Primitive::Boolean,
    Primitive::Char,
    Primitive::WChar,
    Primitive::Short,
    Primitive::UShort,
    Primitive::Long,
    Primitive::ULong,
    Primitive::LongLong,
    Primitive::ULongLong,
    Primitive::Float,
    Primitive::Double,
    Primitive::LongDouble,
];

impl Choices<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.bytes.split_first() else {
            return 0;
        };
        self.bytes = rest;
        *first
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        std::array::from_fn(|_| self.byte())
    }

    fn below(&mut self, end: usize) -> usize {
        usize::from(self.byte()) % end
    }

    fn bound(&mut self) -> Option<u32> {
        let bound = self.byte();
        (bound % 2 == 1).then_some(1 + u32::from(bound / 16))
    }

    /// A type with its definitions, nested up to `depth`.
    pub fn r#type(&mut self, unit: &mut Unit, depth: u32) -> Type {
        match self.below(if depth == 0 { 8 } else { 16 }) {
            0..=4 => {
                // The last one is long double.
                let count = PRIMITIVES.len() - usize::from(self.plain);
                Type::Primitive(PRIMITIVES[self.below(count)])
            }
            5 => Type::String {
                bound: self.bound(),
            },
            6 => Type::WString {
                bound: self.bound(),
            },
            7 => self.r#enum(unit),
            8..=9 => Type::Sequence {
                bound: self.bound(),
                element: Box::new(self.r#type(unit, depth - 1)),
            },
            10 => Type::Array {
                dimensions: (0..1 + self.below(2))
                    .map(|_| 1 + self.below(3) as u32)
                    .collect(),
                element: Box::new(self.r#type(unit, depth - 1)),
            },
            11 => {
                let r#type = self.r#type(unit, depth - 1);
                define(unit, Kind::Typedef(Typedef { r#type }))
            }
            12 => self.union(unit, depth - 1),
            _ => {
                let mut members = Vec::new();
                for number in 0..1 + self.below(4) {
                    let (name, r#type) = (format!("m{number}"), self.r#type(unit, depth - 1));
                    members.push(Member { name, r#type });
                }
                define(unit, Kind::Struct(StructType { members }))
            }
        }
    }

    fn r#enum(&mut self, unit: &mut Unit) -> Type {
        let index = unit.definitions.len();
        let enumerators = (0..1 + self.below(4)).map(|n| format!("T{index}E{n}"));
        let enumerators = enumerators.collect();
        define(unit, Kind::Enum(EnumType { enumerators }))
    }

    /// Labels from 0 on, and perhaps `default` where they are not all.
    fn union(&mut self, unit: &mut Unit, depth: u32) -> Type {
        let (discriminator, cases) = match self.below(4) {
            0 => (Type::Primitive(Primitive::Boolean), 2),
            1 => (Type::Primitive(Primitive::Short), 3),
            2 => (Type::Primitive(Primitive::Char), 3),
            _ => match self.r#enum(unit) {
                Type::Named(index) => (Type::Named(index), 1),
                other => (other, 1),
            },
        };
        let label = |number: u8| match &discriminator {
            Type::Primitive(Primitive::Boolean) => ConstantValue::Boolean(number == 1),
            Type::Primitive(Primitive::Char) => ConstantValue::Char(number.into()),
            Type::Named(definition) => ConstantValue::Enumerator {
                definition: *definition,
                ordinal: number.into(),
            },
            _ => ConstantValue::Integer(number.into()),
        };
        let mut union = Union {
            discriminator: discriminator.clone(),
            cases: Vec::new(),
        };
        for number in 0..=self.below(cases) as u8 {
            union.cases.push(UnionCase {
                labels: vec![Label::Value(label(number))],
                name: format!("c{number}"),
                r#type: self.r#type(unit, depth),
            });
        }
        let all = match &discriminator {
            Type::Primitive(Primitive::Boolean) => union.cases.len() == 2,
            Type::Named(index) => {
                matches!(&unit.definitions[*index].kind, Kind::Enum(it) if it.enumerators.len() == 1)
            }
            _ => false,
        };
        if !all && self.below(2) == 1 {
            union.cases.push(UnionCase {
                labels: vec![Label::Default],
                name: "other".to_owned(),
                r#type: self.r#type(unit, depth),
            });
        }
        define(unit, Kind::Union(union))
    }

    /// A value of a type that [`Self::type`] made.
    pub fn value(&mut self, unit: &Unit, r#type: &Type) -> Value {
        match r#type {
            Type::Primitive(primitive) => self.primitive(*primitive),
            Type::String { bound } => Value::String(self.text(*bound)),
            Type::WString { bound } => Value::WString(self.text(*bound)),
            Type::Sequence { element, bound } => {
                let most = bound.unwrap_or(5).min(5) as usize;
                let length = self.below(most + 1);
                self.elements(unit, element, &[], length)
            }
            Type::Array {
                element,
                dimensions,
            } => self.array(unit, element, dimensions),
            Type::Named(index) => match &unit.definitions[*index].kind {
                Kind::Typedef(alias) => self.value(unit, &alias.r#type),
                Kind::Enum(it) => Value::Enum(self.below(it.enumerators.len()) as u32),
                Kind::Struct(it) => {
                    let members = it.members.iter();
                    Value::Struct(members.map(|m| self.value(unit, &m.r#type)).collect())
                }
                Kind::Union(union) => self.union_value(unit, union),
                other => panic!("no type: {other:?}"),
            },
            other => panic!("no type: {other:?}"),
        }
    }

    fn union_value(&mut self, unit: &Unit, union: &Union) -> Value {
        let discriminator = self.value(unit, &union.discriminator);
        let number = match &discriminator {
            Value::Boolean(it) => i128::from(*it),
            Value::Char(it) => i128::from(*it),
            Value::Short(it) => i128::from(*it),
            Value::Enum(it) => i128::from(*it),
            other => panic!("no discriminator: {other:?}"),
        };
        let is = |label: &Label| match label {
            Label::Value(ConstantValue::Integer(it)) => *it == number,
            Label::Value(ConstantValue::Boolean(it)) => i128::from(*it) == number,
            Label::Value(ConstantValue::Char(it)) => i128::from(u32::from(*it)) == number,
            Label::Value(ConstantValue::Enumerator { ordinal, .. }) => {
                i128::from(*ordinal) == number
            }
            _ => false,
        };
        let case = union.cases.iter().find(|case| case.labels.iter().any(is));
        let default = |case: &&UnionCase| case.labels.contains(&Label::Default);
        let case = case.or_else(|| union.cases.iter().find(default));
        Value::Union {
            discriminator: Box::new(discriminator),
            member: case.map(|case| Box::new(self.value(unit, &case.r#type))),
        }
    }

    fn array(&mut self, unit: &Unit, element: &Type, dimensions: &[u32]) -> Value {
        match dimensions.split_first() {
            None => self.value(unit, element),
            Some((length, inner)) => self.elements(unit, element, inner, *length as usize),
        }
    }

    fn elements(&mut self, unit: &Unit, element: &Type, inner: &[u32], length: usize) -> Value {
        let mut under = element;
        while let Type::Named(index) = under
            && let Kind::Typedef(alias) = &unit.definitions[*index].kind
        {
            under = &alias.r#type;
        }
        if inner.is_empty() && *under == Type::Primitive(Primitive::Octet) {
            return Value::Octets((0..length).map(|_| self.byte()).collect());
        }
        Value::Sequence(
            (0..length)
                .map(|_| self.array(unit, element, inner))
                .collect(),
        )
    }

    fn text(&mut self, bound: Option<u32>) -> String {
        let mut text = String::new();
        for _ in 0..self.below(8) {
            let character = char::from_u32(u32::from_le_bytes(self.bytes()) % 0x11_0000)
                .filter(|it| *it != '\0' && !(self.plain && bound.is_some() && !it.is_ascii()))
                .unwrap_or('a');
            // A bound counts bytes in a string, which are never fewer than the units of UTF-16.
            if bound.is_none_or(|bound| text.len() + character.len_utf8() <= bound as usize) {
                text.push(character);
            }
        }
        text
    }

    fn primitive(&mut self, primitive: Primitive) -> Value {
        match primitive {
            Primitive::Boolean => Value::Boolean(self.byte() % 2 == 1),
            Primitive::Octet => Value::Octet(self.byte()),
            Primitive::Char => Value::Char(self.byte()),
            Primitive::WChar => {
                let unit = u32::from(u16::from_le_bytes(self.bytes()));
                Value::WChar(char::from_u32(unit).unwrap_or('w'))
            }
            Primitive::Short => Value::Short(i16::from_le_bytes(self.bytes())),
            Primitive::UShort => Value::UShort(u16::from_le_bytes(self.bytes())),
            Primitive::Long => Value::Long(i32::from_le_bytes(self.bytes())),
            Primitive::ULong => Value::ULong(u32::from_le_bytes(self.bytes())),
            Primitive::LongLong => Value::LongLong(i64::from_le_bytes(self.bytes())),
            Primitive::ULongLong => {
                let number = u64::from_le_bytes(self.bytes());
                Value::ULongLong(number >> u32::from(self.plain))
            }
            // No NaN: it is not equal to itself.
            Primitive::Float => {
                let number = f32::from_le_bytes(self.bytes());
                Value::Float(if number.is_nan() { 0.1 } else { number })
            }
            Primitive::Double => {
                let number = f64::from_le_bytes(self.bytes());
                Value::Double(if number.is_nan() { 0.1 } else { number })
            }
            Primitive::LongDouble => {
                let bits = u128::from_le_bytes(self.bytes());
                let nan = bits >> 112 & 0x7fff == 0x7fff;
                Value::LongDouble(if nan { 0x3fff << 112 | 1 } else { bits })
            }
        }
    }
}

fn define(unit: &mut Unit, kind: Kind) -> Type {
    let index = unit.definitions.len();
    unit.definitions.push(Definition {
        path: vec![format!("T{index}")],
        repository_id: format!("IDL:T{index}:1.0"),
        file: String::new(),
        span: Span::default(),
        kind,
    });
    Type::Named(index)
}
