//! The receiving half of a connector over a socket.

use std::io::{self, BufReader, Read};
use std::os::unix::net::UnixStream;
use std::sync::Arc;

use rts_manager_api::data::{GOOD_BYE, MAX_SAMPLE};

use super::in_port::InPort;
use super::source::Source;
use super::{Ended, Payload, SILENT_END};

/// Memory for a sample is taken in steps of this size as its bytes arrive, not on the word of its sender.
const STEP: usize = 64 * 1024;

/// What the out-port end sends.
#[derive(Debug, PartialEq, Eq)]
enum Message {
    Sample(u64, Payload),
    GoodBye,
    /// Nothing more, between two messages.
    End,
}

/// Moves samples into an in-port until the connection ends; says why it did. `good_bye`: the other end says one.
pub fn receive(stream: &UnixStream, port: &InPort, source: &Arc<Source>, good_bye: bool) -> Ended {
    let mut reader = BufReader::with_capacity(STEP, stream);
    loop {
        match message(&mut reader) {
            Ok(Message::Sample(sequence, payload)) => {
                if !port.push(source, sequence, payload, || ()) {
                    return Ended::Here;
                }
            }
            Ok(Message::GoodBye) => return Ended::GoodBye,
            Ok(Message::End) => {
                let silent = "its source closed without a good-bye";
                return Ended::Lost(if good_bye { silent } else { SILENT_END }.to_owned());
            }
            Err(error) => return Ended::Lost(error.to_string()),
        }
    }
}

fn message(reader: &mut impl Read) -> io::Result<Message> {
    let mut header = [0; 4];
    if reader.read(&mut header[..1])? == 0 {
        return Ok(Message::End);
    }
    reader.read_exact(&mut header[1..])?;
    if header == GOOD_BYE {
        return Ok(Message::GoodBye);
    }
    let mut sequence = [0; 8];
    reader.read_exact(&mut sequence)?;
    let length = u32::from_be_bytes(header) as usize;
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
    Ok(Message::Sample(
        u64::from_be_bytes(sequence),
        payload.into(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(length: u32, sequence: u64, payload: &[u8]) -> Vec<u8> {
        [&length.to_be_bytes()[..], &sequence.to_be_bytes(), payload].concat()
    }

    #[test]
    fn samples_are_read_one_after_the_other() {
        let good_bye = GOOD_BYE.to_vec();
        let bytes = [frame(11, 1, b"abc"), frame(8, 2, b""), good_bye].concat();
        let mut reader = &bytes[..];
        let mut next = || message(&mut reader).unwrap();
        assert_eq!(next(), Message::Sample(1, "abc".into()));
        assert_eq!(next(), Message::Sample(2, Payload::new()));
        assert_eq!(next(), Message::GoodBye);
        assert_eq!(next(), Message::End);
    }

    #[test]
    fn an_end_without_a_good_bye_is_a_loss_also_when_none_can_be_said() {
        for (good_bye, expected) in [
            (true, "its source closed without a good-bye"),
            (false, SILENT_END),
        ] {
            let (ours, theirs) = UnixStream::pair().unwrap();
            drop(theirs);
            let port = InPort::new("in", "T");
            let ended = receive(&ours, &port, &Arc::new(Source::new(None)), good_bye);
            assert_eq!(ended, Ended::Lost(expected.to_owned()));
        }
    }

    #[test]
    fn bad_lengths_and_cut_samples_are_errors() {
        for bytes in [
            frame(7, 1, b""),
            frame(u32::MAX, 1, b"abc"),
            frame(20, 1, b"abc"),
            vec![0, 0],
        ] {
            assert!(message(&mut &bytes[..]).is_err(), "{bytes:?}");
        }
    }
}
