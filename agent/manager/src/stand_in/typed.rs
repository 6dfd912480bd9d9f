//! Samples of the types that the SDK knows: a real value that carries the number, so that real components can read it.

use rts_runtime::types::{
    DataType, Time, TimedBoolean, TimedDouble, TimedDoubleSeq, TimedFloat, TimedFloatSeq,
    TimedLong, TimedLongSeq, TimedOctet, TimedOctetSeq, TimedShort, TimedShortSeq, TimedString,
};
use rts_schemas::stand_in::recorded::Value;

/// From here on a float has no place for each whole number.
const FLOAT: u64 = 1 << 24;
/// The same of a double.
const DOUBLE: u64 = 1 << 53;

macro_rules! types {
    ($($name:ident: $number:ident => $value:expr;)*) => {
        /// Encodes the sample with this number; false for a type that is not known here.
        pub fn encode(data_type: &str, number: u64, buffer: &mut Vec<u8>) -> bool {
            $(
                if data_type == $name::TYPE_ID {
                    let $number = number;
                    return $name::now($value).encode(buffer).is_ok();
                }
            )*
            false
        }

        /// Encodes a recorded value; false when its texts spell none, or for a type that is not known here.
        pub fn encode_recorded(data_type: &str, texts: &[String], buffer: &mut Vec<u8>) -> bool {
            $(
                if data_type == $name::TYPE_ID {
                    let data = Value::of(texts);
                    let sample = data.map(|data| $name { tm: Time::now(), data });
                    return sample.is_some_and(|sample| sample.encode(buffer).is_ok());
                }
            )*
            false
        }

        /// Whether bytes are a value of a type; none for a type that is not known here.
        pub fn is_value(data_type: &str, bytes: &[u8]) -> Option<bool> {
            $(
                if data_type == $name::TYPE_ID {
                    return Some($name::decode(bytes).is_ok());
                }
            )*
            None
        }

        #[cfg(test)]
        const KNOWN: &[&str] = &[$($name::TYPE_ID),*];
    };
}

// Numbers that are too large begin again at the type's own smallest one.
types! {
    TimedBoolean: number => number % 2 == 1;
    TimedOctet: number => number as u8;
    TimedShort: number => number as i16;
    TimedLong: number => number as i32;
    TimedFloat: number => (number % FLOAT) as f32;
    TimedDouble: number => (number % DOUBLE) as f64;
    TimedString: number => number.to_string();
    TimedOctetSeq: number => number.to_le_bytes();
    TimedShortSeq: number => [number as i16];
    TimedLongSeq: number => [number as i32];
    TimedFloatSeq: number => [(number % FLOAT) as f32];
    TimedDoubleSeq: number => [(number % DOUBLE) as f64];
}

#[cfg(test)]
mod tests {
    use super::*;
    use rts_schemas::stand_in::recorded::problem;

    #[test]
    fn every_number_is_a_value_of_every_type() {
        let mut buffer = Vec::new();
        for data_type in KNOWN {
            for number in [1, 255, 256, 32_767, 32_768, 65_536, FLOAT, DOUBLE, u64::MAX] {
                assert!(
                    encode(data_type, number, &mut buffer),
                    "{data_type} {number}"
                );
                assert_eq!(
                    is_value(data_type, &buffer),
                    Some(true),
                    "{data_type} {number}"
                );
            }
        }
        assert!(!encode("IDL:Img/TimedCameraImage:1.0", 1, &mut buffer));
        assert_eq!(is_value("IDL:Img/TimedCameraImage:1.0", &buffer), None);
    }

    #[test]
    fn what_a_type_cannot_hold_begins_again() {
        let mut buffer = Vec::new();
        let mut short = |number| {
            encode(TimedShort::TYPE_ID, number, &mut buffer);
            TimedShort::decode(&buffer).unwrap().data
        };
        assert_eq!(
            [1, 32_767, 32_768, 65_537].map(&mut short),
            [1, 32_767, -32_768, 1]
        );
        encode(TimedBoolean::TYPE_ID, 2, &mut buffer);
        assert!(!TimedBoolean::decode(&buffer).unwrap().data);
    }

    /// So what the checks let pass is a value here.
    #[test]
    fn what_can_be_played_is_what_is_known() {
        let mut buffer = Vec::new();
        let one = [vec!["1".to_owned()]];
        for data_type in KNOWN {
            assert_eq!(problem(data_type, &one), None);
            assert!(encode_recorded(data_type, &one[0], &mut buffer));
            assert_eq!(is_value(data_type, &buffer), Some(true), "{data_type}");
        }
        let image = "IDL:Img/TimedCameraImage:1.0";
        assert!(problem(image, &one).is_some());
        assert!(!encode_recorded(image, &one[0], &mut buffer));
        let texts = ["0.5".to_owned(), "-.inf".to_owned()];
        assert!(encode_recorded(TimedFloatSeq::TYPE_ID, &texts, &mut buffer));
        let read = TimedFloatSeq::decode(&buffer).unwrap();
        assert_eq!(read.data, [0.5, f32::NEG_INFINITY]);
        assert!(!encode_recorded(TimedFloat::TYPE_ID, &texts, &mut buffer));
    }

    #[test]
    fn bytes_of_another_type_are_no_value() {
        assert_eq!(is_value(TimedDouble::TYPE_ID, &[0; 3]), Some(false));
    }
}
