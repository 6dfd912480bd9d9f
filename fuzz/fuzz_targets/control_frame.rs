//! Any bytes as frames of the control protocol, and as what zygotes say and are told.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rts_manager_api::control::{FromManager, Greeting, Request};
use rts_manager_api::frame::{self, FrameError};
use rts_manager_api::zygote::{self, Become, Fork, FromZygote};
use serde::{Serialize, de::DeserializeOwned};

fuzz_target!(|bytes: &[u8]| {
    all::<Greeting>(bytes);
    all::<Request>(bytes);
    all::<FromManager>(bytes);
    all::<Become>(bytes);
    // What is whole is read, or refused, without more bytes.
    let starved = matches!(
        frame::read::<Request>(&mut &bytes[..]),
        Err(FrameError::Closed | FrameError::Io(_))
    );
    assert_eq!(frame::is_whole(bytes), !starved);
    let _ = zygote::decode::<Fork>(bytes);
    let _ = zygote::decode::<FromZygote>(bytes);
});

/// Reads frames to the end; what was read must be readable again after it is written.
fn all<T: Serialize + DeserializeOwned>(bytes: &[u8]) {
    let mut rest = bytes;
    while let Ok(value) = frame::read::<T>(&mut rest) {
        if let Ok(again) = frame::encode(&value) {
            assert!(frame::read::<T>(&mut &again[..]).is_ok());
        }
    }
    let _ = frame::decode::<T>(bytes);
}
