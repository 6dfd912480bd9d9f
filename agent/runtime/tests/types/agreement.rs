//! The codec of Rust types and that of IDL types, which omniORB judges, write the same bytes and read each other's.

use std::sync::LazyLock;

use proptest::prelude::*;
use rts_runtime::types::{self, DataType, WChar, WString, octets};
use rts_schemas::cdr::{Endian, Value, decode, encode};
use rts_schemas::idl::model::*;
use rts_schemas::idl::{read, standard};
use rts_schemas::span::Span;
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

#[path = "../../../../schemas/src/cdr/tests/any.rs"]
#[allow(dead_code)] // Types are not drawn here.
mod any;

/// Of a drawn value: the same bytes in both orders, and back.
fn agrees<T: DataType>(unit: &Unit, choices: &[u8]) {
    let r#type = Type::Named(unit.find(T::TYPE_ID).expect(T::TYPE_ID));
    let mut choices = any::Choices {
        bytes: choices,
        plain: false,
    };
    let value = choices.value(unit, &r#type);
    let orders = [
        (Endian::Little, types::Endian::Little),
        (Endian::Big, types::Endian::Big),
    ];
    for (theirs, ours) in orders {
        let bytes = encode(unit, &r#type, &value, theirs).expect("a drawn value");
        let sample = T::decode_as(ours, &bytes);
        let sample = sample.unwrap_or_else(|error| panic!("{}: {error:?}: {value:?}", T::TYPE_ID));
        let mut again = Vec::new();
        sample.encode_as(ours, &mut again).expect("what was read");
        assert_eq!(again, bytes, "{}: {value:?}", T::TYPE_ID);
    }
}

/// Bytes of a value with some of them changed, or fewer: what one of the two refuses, the other refuses too.
fn agrees_on_faults<T: DataType>(unit: &Unit, choices: &[u8], faults: &[(u16, u8)], fewer: u8) {
    let r#type = Type::Named(unit.find(T::TYPE_ID).expect(T::TYPE_ID));
    let mut drawn = any::Choices {
        bytes: choices,
        plain: false,
    };
    let value = drawn.value(unit, &r#type);
    let mut bytes = encode(unit, &r#type, &value, Endian::Little).expect("a drawn value");
    for (at, byte) in faults {
        let at = usize::from(*at) % bytes.len();
        bytes[at] = *byte;
    }
    bytes.truncate(bytes.len() - usize::from(fewer).min(bytes.len() - 1));
    let theirs = decode(unit, &r#type, &bytes, Endian::Little);
    let mut again = Vec::new();
    let ours = T::decode(&bytes).and_then(|sample| sample.encode(&mut again));
    match (theirs, ours) {
        (Ok(value), Ok(())) => {
            let theirs = encode(unit, &r#type, &value, Endian::Little).expect("what was read");
            assert_eq!(again, theirs, "{}: {bytes:?}", T::TYPE_ID);
        }
        (Err(_), Err(_)) => {}
        (theirs, ours) => panic!("{}: {bytes:?}: {theirs:?}, {ours:?}", T::TYPE_ID),
    }
}

/// The types of OpenRTM, and what they have not.
const IDL: &str = "#include <rtm/idl/InterfaceDataTypes.idl>
module Test {
    enum Mode { OFF, ON, AUTO };
    union Detail switch (short) { case 0: double speed; case 1: case 2: wstring reason; default: octet raw; };
    struct Sample {
        char letter; wchar wide; Mode state; short grid[2][3]; sequence<wchar> wides; Detail about;
        sequence<octet> image; unsigned long long count; sequence<sequence<boolean> > flags;
    };
};";

static UNIT: LazyLock<Unit> = LazyLock::new(|| {
    let read = read("all.idl", IDL.as_bytes(), &standard());
    read.expect("right IDL").unit
});

#[derive(Serialize, Deserialize)]
enum Mode {
    Off,
    On,
    Auto,
}

/// A union: the discriminator and the member, as a tuple.
enum Detail {
    Speed(f64),
    Reason(i16, WString),
    Raw(i16, u8),
}

impl Serialize for Detail {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(2)?;
        match self {
            Self::Speed(speed) => {
                tuple.serialize_element(&0_i16)?;
                tuple.serialize_element(speed)?;
            }
            Self::Reason(chosen, reason) => {
                tuple.serialize_element(chosen)?;
                tuple.serialize_element(reason)?;
            }
            Self::Raw(chosen, raw) => {
                tuple.serialize_element(chosen)?;
                tuple.serialize_element(raw)?;
            }
        }
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for Detail {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Parts;
        impl<'de> Visitor<'de> for Parts {
            type Value = Detail;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a Detail")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Detail, A::Error> {
                let missing = || A::Error::custom("a Detail ends too early");
                let chosen: i16 = seq.next_element()?.ok_or_else(missing)?;
                Ok(match chosen {
                    0 => Detail::Speed(seq.next_element()?.ok_or_else(missing)?),
                    1 | 2 => Detail::Reason(chosen, seq.next_element()?.ok_or_else(missing)?),
                    _ => Detail::Raw(chosen, seq.next_element()?.ok_or_else(missing)?),
                })
            }
        }
        deserializer.deserialize_tuple(2, Parts)
    }
}

#[derive(Serialize, Deserialize)]
struct Sample {
    letter: u8,
    wide: WChar,
    state: Mode,
    grid: [[i16; 3]; 2],
    wides: Vec<WChar>,
    about: Detail,
    #[serde(serialize_with = "octets")]
    image: Vec<u8>,
    count: u64,
    flags: Vec<Vec<bool>>,
}

impl DataType for Sample {
    const TYPE_ID: &'static str = "IDL:Test/Sample:1.0";
}

fn choices() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(0..=u8::MAX, 0..200)
}

/// Calls a function for each type of OpenRTM.
macro_rules! each {
    ($call:ident $arguments:tt) => {
        each!(@ $call $arguments
            TimedBoolean TimedOctet TimedShort TimedLong TimedFloat TimedDouble TimedString TimedOctetSeq TimedShortSeq
            TimedLongSeq TimedFloatSeq TimedDoubleSeq
            TimedState TimedUShort TimedULong TimedChar TimedWChar TimedWString TimedUShortSeq TimedULongSeq TimedCharSeq
            TimedWCharSeq TimedBooleanSeq TimedStringSeq TimedWStringSeq
            TimedRGBColour TimedPose2D TimedVelocity2D TimedPoint3D TimedPose3D TimedCovariance3D TimedQuaternion
            ActArrayState CameraImage MultiCameraImages GPSData GripperState OGMapTile PointCloud RangeData)
    };
    (@ $call:ident $arguments:tt $($name:ident)*) => {$( $call::<types::$name> $arguments; )*};
}

fn faults() -> impl Strategy<Value = Vec<(u16, u8)>> {
    // Zeros and small numbers are what lengths and ends of texts are made of.
    let byte = prop_oneof![Just(0), 0..8_u8, any::<u8>()];
    prop::collection::vec((any::<u16>(), byte), 0..4)
}

proptest! {
    #[test]
    fn types_of_openrtm(choices in choices()) {
        each!(agrees(&UNIT, &choices));
    }

    #[test]
    fn enums_unions_arrays_and_wide_texts(choices in choices()) {
        agrees::<Sample>(&UNIT, &choices);
    }

    #[test]
    fn what_is_no_value(choices in choices(), faults in faults(), fewer in prop_oneof![Just(0), 0..9_u8]) {
        each!(agrees_on_faults(&UNIT, &choices, &faults, fewer));
        agrees_on_faults::<Sample>(&UNIT, &choices, &faults, fewer);
    }
}
