//! Any bytes as a sample of every data type: what is accepted is written back byte for byte.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rts_runtime::types::{
    ActArrayState, CameraImage, DataType, GPSData, PointCloud, RangeData, TimedBoolean, TimedDouble, TimedDoubleSeq,
    TimedFloat, TimedFloatSeq, TimedLong, TimedLongSeq, TimedOctet, TimedOctetSeq, TimedPose3D, TimedShort,
    TimedShortSeq, TimedString, TimedStringSeq, TimedWCharSeq, TimedWString,
};

fuzz_target!(|bytes: &[u8]| {
    macro_rules! each {
        ($($ty:ty),*) => {
            $(if let Ok(sample) = <$ty>::decode(bytes) {
                let mut again = Vec::new();
                sample.encode(&mut again).expect("what was read can be written");
                let back = <$ty>::decode(&again).expect("its own bytes are read");
                let mut third = Vec::new();
                back.encode(&mut third).expect("what was read can be written");
                assert_eq!(again, third);
            })*
        };
    }
    each!(
        TimedBoolean, TimedDouble, TimedDoubleSeq, TimedFloat, TimedFloatSeq, TimedLong, TimedLongSeq, TimedOctet,
        TimedOctetSeq, TimedShort, TimedShortSeq, TimedString, ActArrayState, CameraImage, GPSData, PointCloud, RangeData,
        TimedPose3D, TimedStringSeq, TimedWCharSeq, TimedWString
    );
});
