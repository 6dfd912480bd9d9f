//! Any bytes from a machine that is reached by SSH: its greeting, and then what should be streams.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rts_bridge::hello::{self, FarHello, NearHello, Outcome};
use rts_bridge::modules::{Answer, Question};

fuzz_target!(|bytes: &[u8]| {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build();
    let runtime = runtime.expect("a runtime");
    runtime.block_on(async {
        let _ = hello::read_marked::<FarHello>(&mut &bytes[..]).await;
        let _ = rts_bridge::near(std::io::Cursor::new(bytes.to_vec()), tokio::io::sink(), "0").await;
        if let Ok(near) = rts_bridge::near(std::io::Cursor::new(greeted(bytes)), tokio::io::sink(), "0").await {
            let mut link = near.link;
            while link.incoming.next().await.is_some() {}
            link.ended().await;
        }
    });
    let _ = hello::decode::<NearHello>(bytes);
    let _ = hello::decode::<Outcome>(bytes);
    let _ = hello::decode::<Question>(bytes);
    if let Ok(Answer::File(offer)) = hello::decode(bytes)
        && offer.is_sound()
    {
        assert!(!offer.name.contains('/') && !offer.digest.contains(['/', '.']));
    }
});

/// The bytes behind a greeting that is right.
fn greeted(bytes: &[u8]) -> Vec<u8> {
    let mut all = b"rts-agent-stdio {\"version\":1,\"program\":\"0\"}\n{\"outcome\":\"serves\",\"resident\":false}\n".to_vec();
    all.extend_from_slice(bytes);
    all
}
