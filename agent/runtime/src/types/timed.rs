//! `BasicDataType.idl` of OpenRTM-aist: the `Timed…` types.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::DataType;

/// `RTC::Time`: seconds and nanoseconds since 1970-01-01 UTC.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub struct Time {
    /// Seconds. `unsigned long` in the IDL: it wraps in 2106.
    pub sec: u32,
    /// Nanoseconds, below 10^9.
    pub nsec: u32,
}

impl Time {
    /// The time now by the wall clock.
    pub fn now() -> Self {
        // A clock before 1970 is a clock that was never set.
        let since = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        Self {
            sec: since.as_secs() as u32,
            nsec: since.subsec_nanos(),
        }
    }
}

macro_rules! timed {
    ($($(#[$serde:meta])? $name:ident: $data:ty, $idl:literal;)*) => {$(
        #[doc = concat!("`RTC::", stringify!($name), "`: `Time tm; ", $idl, " data`.")]
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
        pub struct $name {
            /// When `data` was true.
            pub tm: Time,
            /// The value.
            $(#[$serde])?
            pub data: $data,
        }

        impl $name {
            /// With the time now.
            pub fn now(data: impl Into<$data>) -> Self {
                Self { tm: Time::now(), data: data.into() }
            }
        }

        impl DataType for $name {
            const TYPE_ID: &'static str = concat!("IDL:RTC/", stringify!($name), ":1.0");
        }
    )*};
}

timed! {
    TimedBoolean: bool, "boolean";
    TimedOctet: u8, "octet";
    TimedShort: i16, "short";
    TimedLong: i32, "long";
    TimedFloat: f32, "float";
    TimedDouble: f64, "double";
    TimedString: String, "string";
    #[serde(serialize_with = "super::octets")]
    TimedOctetSeq: Vec<u8>, "sequence<octet>";
    TimedShortSeq: Vec<i16>, "sequence<short>";
    TimedLongSeq: Vec<i32>, "sequence<long>";
    TimedFloatSeq: Vec<f32>, "sequence<float>";
    TimedDoubleSeq: Vec<f64>, "sequence<double>";
}
