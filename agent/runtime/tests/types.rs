//! The bytes of the data types.

#[path = "types/agreement.rs"]
mod agreement;
#[path = "types/allocations.rs"]
mod allocations;
#[path = "types/parameters.rs"]
mod parameters;

use std::fmt::Debug;

use proptest::prelude::*;
use rts_runtime::types::*;

const TM: Time = Time {
    sec: 0x0102_0304,
    nsec: 5,
};
const TM_BYTES: [u8; 8] = [4, 3, 2, 1, 5, 0, 0, 0];

fn encoded<T: DataType>(value: &T) -> Vec<u8> {
    let mut buffer = vec![0xFF; 3];
    value.encode(&mut buffer).expect("encodable");
    buffer
}

/// `value` has the bytes of `TM` and then `data`, and comes back.
fn check<T: DataType + Debug + PartialEq>(value: T, data: &[u8]) {
    assert_eq!(encoded(&value), [&TM_BYTES, data].concat(), "{value:?}");
    let back = T::decode(&encoded(&value)).expect("what was encoded");
    assert_eq!(back, value);
}

#[test]
fn single_values() {
    check(TimedBoolean { tm: TM, data: true }, &[1]);
    check(TimedOctet { tm: TM, data: 200 }, &[200]);
    check(TimedShort { tm: TM, data: -2 }, &[0xFE, 0xFF]);
    check(TimedLong { tm: TM, data: 1 }, &[1, 0, 0, 0]);
    check(TimedFloat { tm: TM, data: 1.0 }, &[0, 0, 0x80, 0x3F]);
    check(
        TimedDouble { tm: TM, data: -2.0 },
        &[0, 0, 0, 0, 0, 0, 0, 0xC0],
    );
}

#[test]
fn a_string_has_its_length_with_the_zero_that_ends_it() {
    let data = String::from("abc");
    check(
        TimedString { tm: TM, data },
        &[4, 0, 0, 0, b'a', b'b', b'c', 0],
    );
    let data = String::new();
    check(TimedString { tm: TM, data }, &[1, 0, 0, 0, 0]);
}

#[test]
fn a_string_that_others_cannot_read_is_neither_read_nor_written() {
    let told = |error: DataError| match error {
        DataError::Decode(source) | DataError::Encode { source, .. } => source.to_string(),
        other => other.to_string(),
    };
    let read = |rest: &[u8]| {
        let decoded = TimedString::decode(&[&TM_BYTES, rest].concat());
        decoded.map(|sample| sample.data).map_err(told)
    };
    assert_eq!(read(&[0, 0, 0, 0]), Ok(String::new()));
    assert_eq!(
        read(&[2, 0, 0, 0, b'a', b'b']),
        Err("the string does not end with a zero".to_owned())
    );
    let zero = "the string holds a zero";
    assert_eq!(read(&[3, 0, 0, 0, b'a', 0, 0]), Err(zero.to_owned()));
    assert_eq!(
        read(&[2, 0, 0, 0, 0xE9, 0]),
        Err("the string is no UTF-8".to_owned())
    );
    let text = TimedString {
        tm: TM,
        data: "a\0b".to_owned(),
    };
    assert_eq!(told(text.encode(&mut Vec::new()).unwrap_err()), zero);
}

#[test]
fn sequences_have_a_length_and_aligned_elements() {
    check(
        TimedOctetSeq {
            tm: TM,
            data: vec![7, 8],
        },
        &[2, 0, 0, 0, 7, 8],
    );
    check(
        TimedShortSeq {
            tm: TM,
            data: vec![1, -1],
        },
        &[2, 0, 0, 0, 1, 0, 255, 255],
    );
    check(
        TimedLongSeq {
            tm: TM,
            data: vec![1],
        },
        &[1, 0, 0, 0, 1, 0, 0, 0],
    );
    check(
        TimedFloatSeq {
            tm: TM,
            data: vec![1.0],
        },
        &[1, 0, 0, 0, 0, 0, 0x80, 0x3F],
    );
    // Doubles lie at multiples of 8: four bytes of padding after the length, none when the sequence is empty.
    check(
        TimedDoubleSeq {
            tm: TM,
            data: vec![1.0],
        },
        &[1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F],
    );
    check(
        TimedDoubleSeq {
            tm: TM,
            data: vec![],
        },
        &[0, 0, 0, 0],
    );
}

#[test]
fn ids_are_those_of_openrtm() {
    assert_eq!(TimedLong::TYPE_ID, "IDL:RTC/TimedLong:1.0");
    assert_eq!(TimedDoubleSeq::TYPE_ID, "IDL:RTC/TimedDoubleSeq:1.0");
}

#[test]
fn a_huge_length_in_a_short_buffer_is_refused_without_the_memory() {
    let claim = [&TM_BYTES[..], &[0xFF; 4], &[1, 2]].concat();
    for error in [
        TimedOctetSeq::decode(&claim).unwrap_err(),
        TimedDoubleSeq::decode(&claim).unwrap_err(),
        TimedString::decode(&claim).unwrap_err(),
    ] {
        assert!(matches!(error, DataError::Decode(_)), "{error}");
    }
}

#[test]
fn left_over_bytes_are_refused() {
    let mut bytes = encoded(&TimedLong { tm: TM, data: 1 });
    bytes.push(0);
    assert!(matches!(
        TimedLong::decode(&bytes),
        Err(DataError::Trailing(1))
    ));
}

/// Decodes as every type; what is read must be written as the same number of bytes.
fn decode_as_all(bytes: &[u8]) {
    fn one<T: DataType>(bytes: &[u8]) {
        if let Ok(value) = T::decode(bytes) {
            assert_eq!(encoded(&value).len(), bytes.len(), "{}", T::TYPE_ID);
        }
    }
    one::<TimedBoolean>(bytes);
    one::<TimedOctet>(bytes);
    one::<TimedShort>(bytes);
    one::<TimedLong>(bytes);
    one::<TimedFloat>(bytes);
    one::<TimedDouble>(bytes);
    one::<TimedOctetSeq>(bytes);
    one::<TimedShortSeq>(bytes);
    one::<TimedLongSeq>(bytes);
    one::<TimedFloatSeq>(bytes);
    one::<TimedDoubleSeq>(bytes);
    // Some ORBs send an empty string without its zero, which is read; so its length may differ.
    let _ = TimedString::decode(bytes);
}

fn time() -> impl Strategy<Value = Time> {
    (any::<u32>(), any::<u32>()).prop_map(|(sec, nsec)| Time { sec, nsec })
}

proptest! {
    #[test]
    fn values_come_back(
        tm in time(), d in any::<f64>(), text in ".*", octets in any::<Vec<u8>>(), longs in any::<Vec<i32>>(),
        doubles in prop::collection::vec(-1e300..1e300, 0..50),
    ) {
        let back = TimedDouble::decode(&encoded(&TimedDouble { tm, data: d })).unwrap();
        prop_assert_eq!((back.tm, back.data.to_bits()), (tm, d.to_bits()));
        let value = TimedString { tm, data: text.replace('\0', "") };
        prop_assert_eq!(TimedString::decode(&encoded(&value)).unwrap(), value);
        let value = TimedOctetSeq { tm, data: octets };
        prop_assert_eq!(TimedOctetSeq::decode(&encoded(&value)).unwrap(), value);
        let value = TimedLongSeq { tm, data: longs };
        prop_assert_eq!(TimedLongSeq::decode(&encoded(&value)).unwrap(), value);
        let value = TimedDoubleSeq { tm, data: doubles };
        prop_assert_eq!(TimedDoubleSeq::decode(&encoded(&value)).unwrap(), value);
    }

    #[test]
    fn any_bytes_are_decoded_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
        decode_as_all(&bytes);
    }

    #[test]
    fn any_length_is_decoded_or_refused(length in any::<u32>(), rest in prop::collection::vec(any::<u8>(), 0..80)) {
        decode_as_all(&[&TM_BYTES[..], &length.to_le_bytes(), &rest].concat());
    }
}

/// What `rtsctl idl generate` makes of `lab.idl`.
mod lab {
    include!("generated/lab.rs");
}

/// The value has these bytes, and comes back.
fn same<T: DataType + Debug + PartialEq>(value: T, bytes: &[u8]) {
    assert_eq!(encoded(&value), bytes, "{value:?}");
    assert_eq!(T::decode(bytes).expect("what was encoded"), value);
}

#[test]
fn generated_types_have_the_bytes_of_their_idl() {
    use lab::Lab::{self, Choice, Mode, Number, Other, Outer, Outer_Inner, Outer_Kind};

    assert_eq!(Lab::Reading::TYPE_ID, "IDL:Lab/Reading:1.0");
    assert_eq!(
        (lab::ANSWER, Lab::FIRST, Lab::MASK),
        (42, Mode::MOVING, 0xF0)
    );
    assert_eq!(
        (Lab::NAME, Lab::ROBOT, Lab::LETTER),
        ("lab \"1\"", "ロボ", b'a')
    );
    assert_eq!((Lab::RATIO, Lab::YES, Lab::MANY), (0.25, true, u64::MAX));
    assert_eq!(
        (Mode::default(), Choice::default()),
        (Mode::IDLE, Choice::number(0))
    );

    let inner = Outer_Inner { r#fn: -1 };
    same(
        Outer {
            part: inner,
            which: Outer_Kind::B,
        },
        &[0xFF, 0xFF, 0, 0, 1, 0, 0, 0],
    );
    same(Choice::number(5), &[0, 0, 0, 0, 5, 0, 0, 0]);
    same(
        Choice::text(Mode::Self_, "a".into()),
        &[2, 0, 0, 0, 2, 0, 0, 0, b'a', 0],
    );
    same(
        Number::real(-1, 1.0),
        &[0xFF, 0xFF, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F],
    );
    same(Number::small(9), &[7, 0, 9]);
    same(Number::otherwise(300), &[0x2C, 1]);
    same(
        Other::yes(1),
        &[1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0],
    );
    same(
        Other::no(false, Choice::number(1)),
        &[0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0],
    );

    let reading = Lab::Reading {
        raw: Array::from([7; 40]),
        r#type: "ab".into(),
        ..Default::default()
    };
    let bytes = encoded(&reading);
    // tm, state, letter, count, pose, raw, type, way, flags.
    assert_eq!(bytes.len(), 8 + 4 + 4 + 8 + 48 + 40 + (4 + 3 + 1) + 4 + 2);
    assert_eq!(&bytes[72..112], [7; 40]);
    assert_eq!(
        Lab::Reading::decode(&bytes).expect("what was encoded"),
        reading
    );
    assert!(Lab::Reading::decode(&bytes[..100]).is_err());
}

#[test]
fn a_type_may_be_called_as_one_of_rust_is() {
    use lab::Lab::Primitives::{bool_::isize_, i32_, str_, u8_, u64_};

    assert_eq!(str_::TYPE_ID, "IDL:Lab/Primitives/str:1.0");
    assert_eq!(u64_::default(), u64_::A);
    let text = str_ { value: "a".into() };
    same(text.clone(), &[2, 0, 0, 0, b'a', 0]);
    let it = i32_::list(vec![u8_ { value: 9, text }]);
    same(
        isize_ { it, yes: true },
        &[1, 0, 0, 0, 1, 0, 0, 0, 9, 0, 0, 0, 2, 0, 0, 0, b'a', 0, 1],
    );
}

#[test]
fn wide_and_raw_members_are_those_of_the_runtime() {
    let wide = lab::Lab::Wide {
        letter: lab::Lab::SIGN.into(),
        text: "あ".into(),
        raw: vec![1, 2, 3],
        letters: vec![b'a'],
    };
    let bytes = [
        &[2, 0x30, 0x42, 0][..],
        &[4, 0, 0, 0, 0xFF, 0xFE, 0x42, 0x30],
        &[3, 0, 0, 0, 1, 2, 3, 0],
        &[1, 0, 0, 0, b'a'],
    ];
    same(wide, &bytes.concat());
}

#[test]
fn a_union_says_nothing_else_than_what_was_chosen() {
    use lab::Lab::{Choice, Mode, Number, Other};

    let mut buffer = Vec::new();
    assert!(
        Choice::text(Mode::IDLE, String::new())
            .encode(&mut buffer)
            .is_err()
    );
    assert!(Number::real(7, 1.0).encode(&mut buffer).is_err());
    assert!(Number::otherwise(-1).encode(&mut buffer).is_err());
    assert!(
        Other::no(true, Choice::default())
            .encode(&mut buffer)
            .is_err()
    );
    assert!(Choice::decode(&[3, 0, 0, 0, 0, 0, 0, 0]).is_err());
}

#[test]
fn values_within_each_other_are_not_followed_for_ever() {
    use lab::Lab::{Node, Tree};

    let node = |children| Node { count: 1, children };
    let nodes = (0..60).fold(node(Vec::new()), |inner, _| node(vec![inner]));
    assert_eq!(
        Node::decode(&encoded(&nodes)).expect("deep, but not too deep"),
        nodes
    );
    let trees = (0..60).fold(Tree::leaf(1), |inner, _| Tree::branches(vec![inner]));
    assert_eq!(
        Tree::decode(&encoded(&trees)).expect("deep, but not too deep"),
        trees
    );
    // A value and one child, again and again.
    let deep = [1, 0, 0, 0, 1, 0, 0, 0].repeat(1 << 20);
    assert!(Node::decode(&deep).is_err());
    let deep = [b't', 0, 0, 0, 1, 0, 0, 0].repeat(1 << 20);
    assert!(Tree::decode(&deep).is_err());
    // It was left as it was found.
    assert_eq!(
        Node::decode(&encoded(&nodes)).expect("deep, but not too deep"),
        nodes
    );
}
