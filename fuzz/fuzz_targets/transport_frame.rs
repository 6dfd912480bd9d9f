//! Any bytes as frames of a data connection, coming in any pieces.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rts_transport::frame::{Decoder, Framing, Malformed, Message};

fuzz_target!(|input: (u16, &[u8])| {
    let (piece, bytes) = input;
    for framing in [Framing::Timed, Framing::Plain] {
        let whole = read(bytes, usize::MAX, framing);
        let pieces = read(bytes, usize::from(piece) + 1, framing);
        assert_eq!(whole, pieces);
    }
});

/// All messages, and what ended them.
fn read(
    mut bytes: &[u8],
    piece: usize,
    framing: Framing,
) -> (Vec<Message>, Option<Malformed>) {
    let (mut decoder, mut messages) = (Decoder::new(framing), Vec::new());
    loop {
        match decoder.message() {
            Ok(Some(message)) => messages.push(message),
            Err(malformed) => return (messages, Some(malformed)),
            Ok(None) if bytes.is_empty() => return (messages, None),
            Ok(None) => {
                let (space, limit) = decoder.space();
                let here = limit.min(piece).min(bytes.len());
                assert!(here > 0 && here <= space.capacity() - space.len());
                space.extend_from_slice(&bytes[..here]);
                bytes = &bytes[here..];
            }
        }
    }
}
