//! Laws of the codec, and its refusals.

use insta::assert_snapshot;
use proptest::prelude::*;
use serde_json::json;

use super::*;
use crate::idl::model::*;
use crate::span::Span;

mod any;

use any::Choices;

const BOTH: [Endian; 2] = [Endian::Little, Endian::Big];

fn named(name: &str, kind: Kind) -> Definition {
    Definition {
        path: vec!["RTC".to_owned(), name.to_owned()],
        repository_id: format!("IDL:RTC/{name}:1.0"),
        file: "test.idl".to_owned(),
        span: Span::default(),
        kind,
    }
}

fn record(name: &str, members: &[(&str, Type)]) -> Definition {
    let members = members.iter().map(|(name, r#type)| Member {
        name: (*name).to_owned(),
        r#type: r#type.clone(),
    });
    let members = members.collect();
    named(name, Kind::Struct(StructType { members }))
}

fn of(primitive: Primitive) -> Type {
    Type::Primitive(primitive)
}

fn sequence(element: Type) -> Type {
    Type::Sequence {
        element: Box::new(element),
        bound: None,
    }
}

const POSE: Type = Type::Named(3);
const STATE: Type = Type::Named(6);
const TREE: Type = Type::Named(7);

/// Of each kind of definition one.
fn unit() -> Unit {
    let double = || of(Primitive::Double);
    let label = |ordinal| {
        Label::Value(ConstantValue::Enumerator {
            definition: 4,
            ordinal,
        })
    };
    let case = |labels, name: &str, r#type| UnionCase {
        labels,
        name: name.to_owned(),
        r#type,
    };
    let enumerators = ["IDLE", "BUSY", "BROKEN"].map(str::to_owned).to_vec();
    Unit {
        definitions: vec![
            record(
                "Time",
                &[
                    ("sec", of(Primitive::ULong)),
                    ("nsec", of(Primitive::ULong)),
                ],
            ),
            record("Point2D", &[("x", double()), ("y", double())]),
            record(
                "Pose2D",
                &[("position", Type::Named(1)), ("heading", double())],
            ),
            record(
                "TimedPose2D",
                &[("tm", Type::Named(0)), ("data", Type::Named(2))],
            ),
            named("Status", Kind::Enum(EnumType { enumerators })),
            named(
                "Detail",
                Kind::Union(Union {
                    discriminator: Type::Named(4),
                    cases: vec![
                        case(vec![label(1)], "progress", of(Primitive::Float)),
                        case(vec![label(2)], "reason", Type::WString { bound: Some(8) }),
                    ],
                }),
            ),
            record(
                "State",
                &[
                    ("name", Type::String { bound: Some(8) }),
                    ("detail", Type::Named(5)),
                    ("ticks", of(Primitive::LongLong)),
                    ("image", sequence(of(Primitive::Octet))),
                    (
                        "grid",
                        Type::Array {
                            element: Box::new(of(Primitive::Short)),
                            dimensions: vec![2, 2],
                        },
                    ),
                ],
            ),
            record("Tree", &[("branches", sequence(TREE))]),
        ],
    }
}

fn state() -> Value {
    let row = |a, b| Value::Sequence(vec![Value::Short(a), Value::Short(b)]);
    Value::Struct(vec![
        Value::String("arm".to_owned()),
        Value::Union {
            discriminator: Box::new(Value::Enum(2)),
            member: Some(Box::new(Value::WString("\u{3042}x".to_owned()))),
        },
        Value::LongLong(1),
        Value::Octets(vec![7]),
        Value::Sequence(vec![row(1, 2), row(3, -1)]),
    ])
}

#[test]
fn bytes_of_a_value() {
    let big = encode(&unit(), &STATE, &state(), Endian::Big).unwrap();
    #[rustfmt::skip]
    assert_eq!(big, [
        0, 0, 0, 4, b'a', b'r', b'm', 0,
        0, 0, 0, 2,
        // UTF-16 after its byte order mark, in bytes.
        0, 0, 0, 6, 0xff, 0xfe, 0x42, 0x30, b'x', 0,
        0, 0,
        0, 0, 0, 0, 0, 0, 0, 1,
        0, 0, 0, 1, 7,
        0,
        0, 1, 0, 2, 0, 3, 0xff, 0xff,
    ]);
    let little = encode(&unit(), &STATE, &state(), Endian::Little).unwrap();
    assert_eq!(little[..8], [4, 0, 0, 0, b'a', b'r', b'm', 0]);
    assert_eq!(little[24..32], [1, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(
        decode(&unit(), &STATE, &little, Endian::Little),
        Ok(state())
    );
    assert_eq!(decode(&unit(), &STATE, &big, Endian::Big), Ok(state()));
}

#[test]
fn wide_characters_go_by_their_byte_order_mark() {
    let unit = Unit::default();
    let wchar = of(Primitive::WChar);
    for endian in BOTH {
        let written = encode(&unit, &wchar, &Value::WChar('\u{3042}'), endian).unwrap();
        assert_eq!(written, [2, 0x30, 0x42]);
        for bytes in [
            &[2, 0x30, 0x42][..],
            &[4, 0xfe, 0xff, 0x30, 0x42],
            &[4, 0xff, 0xfe, 0x42, 0x30],
        ] {
            assert_eq!(
                decode(&unit, &wchar, bytes, endian),
                Ok(Value::WChar('\u{3042}'))
            );
        }
    }
    // What looks like a mark is a character where nothing follows.
    for it in ['\u{feff}', '\u{fffe}'] {
        let written = encode(&unit, &wchar, &Value::WChar(it), Endian::Big).unwrap();
        assert_eq!(
            decode(&unit, &wchar, &written, Endian::Big),
            Ok(Value::WChar(it))
        );
    }
    let wstring = Type::WString { bound: None };
    for text in [
        &[0, 0, 0, 2, 0x30, 0x42][..],
        &[0, 0, 0, 4, 0xfe, 0xff, 0x30, 0x42],
    ] {
        let value = Value::WString("\u{3042}".to_owned());
        assert_eq!(decode(&unit, &wstring, text, Endian::Big), Ok(value));
    }
    let empty = Value::WString(String::new());
    assert_eq!(encode(&unit, &wstring, &empty, Endian::Big), Ok(vec![0; 4]));
}

fn told<T: std::fmt::Debug>(result: Result<T, Error>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn refused_bytes() {
    let unit = unit();
    let refused = |r#type: &Type, bytes: &[u8]| told(decode(&unit, r#type, bytes, Endian::Big));
    let whole = encode(&unit, &STATE, &state(), Endian::Big).unwrap();
    let bent = |at: usize, byte: u8| {
        let mut bytes = whole.clone();
        bytes[at] = byte;
        refused(&STATE, &bytes)
    };
    let primitive = |primitive, bytes: &[u8]| refused(&of(primitive), bytes);
    assert_snapshot!(
        [
            refused(&POSE, &[0; 20]),
            refused(&STATE, &[&whole[..], &[0; 3]].concat()),
            bent(3, 20),
            bent(3, 3),
            bent(5, 0),
            bent(5, 0xff),
            bent(11, 3),
            bent(15, 5),
            bent(15, 200),
            bent(19, 0xdc),
            bent(32, 0xff),
            bent(35, 255),
            primitive(Primitive::Boolean, &[2]),
            primitive(Primitive::WChar, &[4, 0, 1, 0, 2]),
            refused(
                &sequence(of(Primitive::Double)),
                &[0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0]
            ),
            refused(&sequence(Type::Any), &[0, 0, 0, 1, 0]),
            // A tree with a branch in each branch.
            refused(&TREE, &[0, 0, 0, 1].repeat(100)),
        ]
        .join("\n")
    );
}

#[test]
fn refused_values() {
    let unit = unit();
    let refused = |index: usize, value: Value| {
        let Value::Struct(mut members) = state() else {
            unreachable!()
        };
        members[index] = value;
        told(encode(&unit, &STATE, &Value::Struct(members), Endian::Big))
    };
    let union = |ordinal, member: Option<Value>| Value::Union {
        discriminator: Box::new(Value::Enum(ordinal)),
        member: member.map(Box::new),
    };
    assert_snapshot!(
        [
            refused(0, Value::String("123456789".to_owned())),
            refused(0, Value::String("a\0b".to_owned())),
            refused(0, Value::Long(1)),
            refused(1, union(0, Some(Value::Float(0.5)))),
            refused(1, union(1, None)),
            refused(1, union(1, Some(Value::Double(0.5)))),
            refused(1, union(3, None)),
            refused(3, Value::Sequence(Vec::new())),
            refused(
                4,
                Value::Sequence(vec![Value::Octets(vec![1, 2]), Value::Octets(vec![1, 2])])
            ),
            refused(4, Value::Sequence(Vec::new())),
            told(encode(
                &unit,
                &POSE,
                &Value::Struct(Vec::new()),
                Endian::Big
            )),
        ]
        .join("\n")
    );
}

#[test]
fn json_of_a_value() {
    let unit = unit();
    let text = to_json(&unit, &STATE, &state()).unwrap();
    assert_snapshot!(text);
    assert_eq!(
        from_json(&unit, &STATE, &text.parse().unwrap()),
        Ok(state())
    );
}

#[test]
fn json_of_numbers_that_json_has_not() {
    let unit = Unit::default();
    let shown = |primitive, value: Value| {
        let text = to_json(&unit, &of(primitive), &value).unwrap();
        let back = from_json(&unit, &of(primitive), &text.parse().unwrap()).unwrap();
        assert_eq!(format!("{back:?}"), format!("{value:?}"), "{text}");
        text
    };
    assert_snapshot!(
        [
            shown(Primitive::LongLong, Value::LongLong(-(1 << 53))),
            shown(Primitive::LongLong, Value::LongLong(i64::MIN)),
            shown(Primitive::ULongLong, Value::ULongLong(u64::MAX)),
            shown(Primitive::Float, Value::Float(0.1)),
            shown(Primitive::Float, Value::Float(f32::NAN)),
            shown(Primitive::Double, Value::Double(f64::NEG_INFINITY)),
            shown(Primitive::Double, Value::Double(-0.0)),
            shown(Primitive::LongDouble, Value::LongDouble(0x3fff << 112)),
            shown(
                Primitive::LongDouble,
                Value::LongDouble((0x3fff << 112) + 1)
            ),
            shown(Primitive::Char, Value::Char(0xe4)),
            shown(Primitive::Char, Value::Char(0)),
        ]
        .join("\n")
    );
}

#[test]
fn json_may_leave_out_what_is_zero() {
    let unit = unit();
    let data = json!({"data": {"position": {"x": 1}}});
    let Ok(Value::Struct(members)) = from_json(&unit, &POSE, &data) else {
        unreachable!()
    };
    assert_eq!(
        members[0],
        Value::Struct(vec![Value::ULong(0), Value::ULong(0)])
    );
    let read = from_json(&unit, &STATE, &json!({"detail": {"progress": 0.5}})).unwrap();
    let text = to_json(&unit, &STATE, &read).unwrap();
    assert_snapshot!(text);
    let long = "AAAA".repeat(22);
    let read = from_json(&unit, &STATE, &json!({"image": {"$base64": long}})).unwrap();
    let text = to_json(&unit, &STATE, &read).unwrap();
    assert!(
        text.contains(&format!(r#""image": {{"$base64": "{long}"}}"#)),
        "{text}"
    );
}

#[test]
fn refused_json() {
    let unit = unit();
    let refused = |r#type: &Type, json| told(from_json(&unit, r#type, &json));
    assert_snapshot!(
        [
            refused(&POSE, json!({"dta": 1})),
            refused(&POSE, json!({"tm": {"sec": -1}})),
            refused(&POSE, json!({"tm": {"sec": 1.5}})),
            refused(&POSE, json!({"data": {"position": {"x": "1"}}})),
            refused(
                &POSE,
                json!([
                    1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20
                ])
            ),
            refused(&STATE, json!({"name": 5})),
            refused(&STATE, json!({"name": "123456789"})),
            refused(&STATE, json!({"detail": {}})),
            refused(&STATE, json!({"detail": {"$discriminator": "BUZY"}})),
            refused(
                &STATE,
                json!({"detail": {"$discriminator": "IDLE", "progress": 1}})
            ),
            refused(&STATE, json!({"detail": {"$discriminator": "BUSY"}})),
            refused(&STATE, json!({"detail": {"progress": 1e300}})),
            refused(&STATE, json!({"detail": {"progress": 1, "reason": ""}})),
            refused(&STATE, json!({"detail": {"prgress": 1}})),
            refused(&STATE, json!({"image": [1, 256]})),
            refused(&STATE, json!({"image": {"$base64": "?"}})),
            refused(&STATE, json!({"grid": [[1, 2]]})),
            refused(&STATE, json!({"grid": [[1, 2], [3, 40000]]})),
        ]
        .join("\n")
    );
}

/// A type, and a value of it.
fn drawn(choices: &[u8]) -> (Unit, Type, Value) {
    let mut choices = Choices {
        bytes: choices,
        plain: false,
    };
    let mut unit = Unit::default();
    let r#type = choices.r#type(&mut unit, 3);
    let value = choices.value(&unit, &r#type);
    (unit, r#type, value)
}

fn choices() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..200)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn what_is_written_is_read(choices in choices()) {
        let (unit, r#type, value) = drawn(&choices);
        let [little, big] = BOTH.map(|endian| encode(&unit, &r#type, &value, endian).unwrap());
        prop_assert_eq!(little.len(), big.len());
        prop_assert_eq!(decode(&unit, &r#type, &little, Endian::Little), Ok(value.clone()));
        prop_assert_eq!(decode(&unit, &r#type, &big, Endian::Big), Ok(value));
        let mut turned = little.clone();
        prop_assert_eq!(swap(&unit, &r#type, &mut turned, Endian::Little), Ok(()));
        prop_assert_eq!(&turned, &big);
        prop_assert_eq!(swap(&unit, &r#type, &mut turned, Endian::Big), Ok(()));
        prop_assert_eq!(turned, little);
    }

    #[test]
    fn what_is_shown_as_json_is_read(choices in choices()) {
        let (unit, r#type, value) = drawn(&choices);
        let text = to_json(&unit, &r#type, &value).unwrap();
        let json = serde_json::from_str(&text).unwrap();
        prop_assert_eq!(from_json(&unit, &r#type, &json), Ok(value), "{}", text);
    }

    #[test]
    fn a_value_of_nothing_is_a_value(choices in choices()) {
        let (unit, r#type, _) = drawn(&choices);
        let value = zero(&unit, &r#type).unwrap();
        let bytes = encode(&unit, &r#type, &value, Endian::Big).unwrap();
        prop_assert_eq!(decode(&unit, &r#type, &bytes, Endian::Big), Ok(value));
    }

    #[test]
    fn no_cut_is_a_value(choices in choices(), cut: prop::sample::Index) {
        let (unit, r#type, value) = drawn(&choices);
        let bytes = encode(&unit, &r#type, &value, Endian::Little).unwrap();
        let cut = &bytes[..cut.index(bytes.len())];
        prop_assert!(decode(&unit, &r#type, cut, Endian::Little).is_err());
        prop_assert!(swap(&unit, &r#type, &mut cut.to_vec(), Endian::Little).is_err());
    }

    #[test]
    fn any_bytes_are_judged(choices in choices(), bytes: Vec<u8>) {
        let (unit, r#type, _) = drawn(&choices);
        for endian in BOTH {
            if let Ok(value) = decode(&unit, &r#type, &bytes, endian) {
                let again = encode(&unit, &r#type, &value, endian).unwrap();
                prop_assert!(decode(&unit, &r#type, &again, endian).is_ok());
                prop_assert_eq!(swap(&unit, &r#type, &mut bytes.clone(), endian), Ok(()));
            } else {
                let _ = swap(&unit, &r#type, &mut bytes.clone(), endian);
            }
        }
    }
}
