//! The receiving half of a connector over a socket.

use std::io::{self, BufReader, Read};
use std::os::unix::net::UnixStream;
use std::sync::Arc;

use rts_manager_api::data::MAX_SAMPLE;

use super::Payload;
use super::in_port::InPort;
use super::source::Source;

/// Memory for a sample is taken in steps of this size as its bytes arrive, not on the word of its sender.
const STEP: usize = 64 * 1024;

/// Moves samples into an in-port until the connection ends. An end between two samples is no error.
pub fn receive(stream: &UnixStream, port: &InPort, source: &Arc<Source>) -> io::Result<()> {
    let mut reader = BufReader::with_capacity(STEP, stream);
    while let Some((sequence, payload)) = sample(&mut reader)? {
        if !port.push(source, sequence, payload, || ()) {
            break;
        }
    }
    Ok(())
}

/// Reads one sample; none at the end of the stream.
fn sample(reader: &mut impl Read) -> io::Result<Option<(u64, Payload)>> {
    let mut first = [0];
    if reader.read(&mut first)? == 0 {
        return Ok(None);
    }
    let mut rest = [0; 11];
    reader.read_exact(&mut rest)?;
    let length = u32::from_be_bytes([first[0], rest[0], rest[1], rest[2]]) as usize;
    let mut sequence = [0; 8];
    sequence.copy_from_slice(&rest[3..]);
    let size = length
        .checked_sub(8)
        .filter(|size| *size <= MAX_SAMPLE)
        .ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidData,
                format!("a sample of {length} bytes is not allowed"),
            )
        })?;
    let mut payload = Vec::with_capacity(size.min(STEP));
    reader.take(size as u64).read_to_end(&mut payload)?;
    if payload.len() < size {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(Some((u64::from_be_bytes(sequence), payload.into())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(length: u32, sequence: u64, payload: &[u8]) -> Vec<u8> {
        [&length.to_be_bytes()[..], &sequence.to_be_bytes(), payload].concat()
    }

    #[test]
    fn samples_are_read_one_after_the_other() {
        let bytes = [frame(11, 1, b"abc"), frame(8, 2, b"")].concat();
        let mut reader = &bytes[..];
        assert_eq!(sample(&mut reader).unwrap(), Some((1, "abc".into())));
        assert_eq!(sample(&mut reader).unwrap(), Some((2, Payload::new())));
        assert_eq!(sample(&mut reader).unwrap(), None);
    }

    #[test]
    fn bad_lengths_and_cut_samples_are_errors() {
        for bytes in [
            frame(7, 1, b""),
            frame(u32::MAX, 1, b"abc"),
            frame(20, 1, b"abc"),
            vec![0, 0],
        ] {
            assert!(sample(&mut &bytes[..]).is_err(), "{bytes:?}");
        }
    }
}
