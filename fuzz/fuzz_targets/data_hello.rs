//! Any bytes as the first frames of a data connection.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rts_manager_api::data::{DataHello, DataReply};
use rts_manager_api::frame;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(hello) = frame::decode::<DataHello>(bytes) {
        let again = frame::encode(&hello).expect("a hello is plain data");
        let back: DataHello = frame::read(&mut &again[..]).expect("its own frame is read");
        assert_eq!(back, hello);
    }
    let _ = frame::read::<DataHello>(&mut &bytes[..]);
    let _ = frame::read::<DataReply>(&mut &bytes[..]);
    let _ = frame::decode::<DataReply>(bytes);
});
