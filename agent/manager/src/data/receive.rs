//! The receiving half of a connector over a socket.

use std::io::{self, BufReader, Read};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::time::Instant;

use rts_manager_api::data::{EMPTY, GOOD_BYE, MAX_SAMPLE};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::in_port::InPort;
use super::sample::Sample;
use super::sender::Agreed;
use super::source::Source;
use super::{Ended, Payload, SILENT_END};

/// Memory for a sample is taken in steps of this size as its bytes arrive, not on the word of its sender.
const STEP: usize = 64 * 1024;

/// What the out-port end sends.
#[derive(Debug, PartialEq, Eq)]
enum Message {
    Sample(Sample),
    /// To a reader that fetches: there is none.
    Empty,
    GoodBye,
    /// Nothing more, between two messages.
    End,
}

/// Moves samples into an in-port until the connection ends; says why it did.
pub fn receive(stream: &UnixStream, port: &InPort, source: &Arc<Source>, agreed: Agreed) -> Ended {
    let mut reader = BufReader::with_capacity(STEP, stream);
    loop {
        match message(&mut reader, agreed.stamped) {
            Ok(Message::Sample(sample)) => {
                if let Err(sample) = port.offer(source, sample) {
                    port.wait(source, sample, Instant::now(), || !has_hung_up(stream));
                }
                if !source.is_open() {
                    return Ended::Here;
                }
            }
            Ok(Message::Empty) => port.answered(source),
            Ok(Message::GoodBye) => return Ended::GoodBye,
            Ok(Message::End) => {
                let silent = "its source closed without a good-bye";
                let seen = if agreed.good_bye { silent } else { SILENT_END };
                return Ended::Lost(seen.to_owned());
            }
            Err(error) => return Ended::Lost(error.to_string()),
        }
    }
}

/// True when the other end has closed the connection, whatever is still to be read.
fn has_hung_up(stream: &UnixStream) -> bool {
    let mut fds = [PollFd::new(stream, PollFlags::RDHUP)];
    let at_once = Timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    poll(&mut fds, Some(&at_once)).is_ok_and(|ready| ready > 0)
}

fn message(reader: &mut impl Read, stamped: bool) -> io::Result<Message> {
    let mut header = [0; 4];
    if reader.read(&mut header[..1])? == 0 {
        return Ok(Message::End);
    }
    reader.read_exact(&mut header[1..])?;
    if header == GOOD_BYE {
        return Ok(Message::GoodBye);
    }
    if header == EMPTY {
        return Ok(Message::Empty);
    }
    let length = u32::from_be_bytes(header) as usize;
    let sequence = number(reader)?;
    let written = if stamped { number(reader)? } else { 0 };
    let size = length
        .checked_sub(if stamped { 16 } else { 8 })
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
    Ok(Message::Sample(Sample {
        sequence,
        written,
        payload: Payload::from(payload),
    }))
}

fn number(reader: &mut impl Read) -> io::Result<u64> {
    let mut bytes = [0; 8];
    reader.read_exact(&mut bytes)?;
    Ok(u64::from_be_bytes(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rts_schemas::connector::ConnectorSettings;

    fn frame(length: u32, sequence: u64, payload: &[u8]) -> Vec<u8> {
        [&length.to_be_bytes()[..], &sequence.to_be_bytes(), payload].concat()
    }

    #[test]
    fn samples_are_read_one_after_the_other() {
        let good_bye = GOOD_BYE.to_vec();
        let stamped = [5_u64.to_be_bytes().to_vec(), b"abc".to_vec()].concat();
        let plain = [
            frame(11, 1, b"abc"),
            EMPTY.to_vec(),
            frame(8, 2, b""),
            good_bye,
        ];
        let sample = |sequence, written, payload: &'static str| {
            Message::Sample(Sample {
                sequence,
                written,
                payload: payload.into(),
            })
        };
        let bytes = frame(19, 1, &stamped);
        assert_eq!(message(&mut &bytes[..], true).unwrap(), sample(1, 5, "abc"));
        let bytes = plain.concat();
        let mut reader = &bytes[..];
        let mut next = || message(&mut reader, false).unwrap();
        assert_eq!(next(), sample(1, 0, "abc"));
        assert_eq!(next(), Message::Empty);
        assert_eq!(next(), sample(2, 0, ""));
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
            let source = Arc::new(Source::new(None, ConnectorSettings::default(), None));
            let agreed = Agreed {
                good_bye,
                stamped: false,
            };
            let ended = receive(&ours, &port, &source, agreed);
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
            assert!(message(&mut &bytes[..], false).is_err(), "{bytes:?}");
            assert!(message(&mut &bytes[..], true).is_err(), "{bytes:?}");
        }
    }
}
