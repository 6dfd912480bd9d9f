//! The serde format of samples: CDR (XCDR1) as docs/adr/0019-cdr.md fixes it.
//!
//! What cannot be read is not written, and the other way round; the codec of IDL types in rts-schemas agrees on each byte.

mod decode;
mod encode;

use std::borrow::Cow;
use std::fmt::Display;

pub(super) use decode::decode;
pub(super) use encode::encode;

/// Why a value cannot be written, or bytes cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CdrError(Cow<'static, str>);

impl CdrError {
    const fn new(why: &'static str) -> Self {
        Self(Cow::Borrowed(why))
    }
}

impl serde::ser::Error for CdrError {
    fn custom<T: Display>(why: T) -> Self {
        Self(Cow::Owned(why.to_string()))
    }
}

impl serde::de::Error for CdrError {
    fn custom<T: Display>(why: T) -> Self {
        Self(Cow::Owned(why.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use serde::de::DeserializeOwned;
    use serde::{Deserialize, Serialize};

    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    enum Shape {
        Dot,
        Circle(f64),
        Box { wide: u16, high: u16 },
    }

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Unit;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct All {
        small: (i8, u8, bool, char),
        numbers: (i16, u16, i32, u32, i64, u64, f32, f64),
        text: String,
        list: Vec<Vec<u16>>,
        shapes: Vec<Shape>,
        unit: Unit,
    }

    fn all() -> All {
        All {
            small: (-1, 255, true, 'ロ'),
            numbers: (-2, 2, -3, 3, -4, 4, 0.5, -0.25),
            text: "ロボ".to_owned(),
            list: vec![vec![1, 2], vec![], vec![3]],
            shapes: vec![
                Shape::Dot,
                Shape::Circle(1.5),
                Shape::Box { wide: 1, high: 2 },
            ],
            unit: Unit,
        }
    }

    fn both<T: Serialize + DeserializeOwned>(value: &T) -> Result<[(T, usize); 2], CdrError> {
        let (mut little, mut big) = (Vec::new(), Vec::new());
        encode::<false, _>(value, &mut little)?;
        encode::<true, _>(value, &mut big)?;
        assert_eq!(little.len(), big.len());
        Ok([decode::<false, _>(&little)?, decode::<true, _>(&big)?])
    }

    #[test]
    fn all_that_serde_can_say_in_cdr_comes_back_in_both_orders() {
        for (back, _) in both(&all()).unwrap() {
            assert_eq!(back, all());
        }
    }

    #[test]
    fn bytes_that_end_anywhere_are_refused() {
        let mut bytes = Vec::new();
        encode::<false, _>(&all(), &mut bytes).unwrap();
        for end in 0..bytes.len() {
            let told = decode::<false, All>(&bytes[..end]).unwrap_err();
            assert_eq!(told.to_string(), "unexpected end of input", "{end}");
        }
    }

    #[test]
    fn what_cdr_does_not_know_is_refused() {
        let told = |error: Result<_, CdrError>| error.map(|_| ()).unwrap_err().to_string();
        assert_eq!(
            told(both(&Some(1)).map(|_| ())),
            "CDR has no optional values"
        );
        let map = std::collections::BTreeMap::from([(1, 2)]);
        assert_eq!(told(both(&map).map(|_| ())), "CDR has no maps");
        // Four thousand million of what takes no byte.
        assert!(decode::<false, Vec<Unit>>(&[0xFF; 4]).is_err());
        assert!(decode::<false, bool>(&[2]).is_err());
        assert!(decode::<false, char>(&[0, 0xD8, 0, 0]).is_err());
        assert!(decode::<false, Shape>(&[3, 0, 0, 0]).is_err());
    }
}
