//! Frames from bytes that come as they like.

use bytes::{Buf, BytesMut};

use super::framing::Framing;
use super::header::{Header, Malformed};
use super::spare::Spare;
use crate::Sample;

/// Memory is taken in steps of this size as bytes arrive, not on the word of their sender.
const STEP: usize = 64 * 1024;

/// Smaller payloads share the buffer that they were read into; larger ones are read into one of their own.
const SHARED: usize = 16 * 1024;

/// What was read.
#[derive(Debug, PartialEq, Eq)]
pub enum Message {
    /// A sample.
    Sample(Sample),
    /// The last frame.
    GoodBye,
}

/// Puts frames together.
#[derive(Debug, Default)]
pub struct Decoder {
    framing: Framing,
    /// Headers and small payloads.
    buffer: BytesMut,
    /// A large payload on its way.
    body: Option<Body>,
    spare: Spare,
    /// The last one was large, so the next one may be: its payload is not to be read with its header.
    was_large: bool,
    ended: bool,
}

#[derive(Debug)]
struct Body {
    size: usize,
    sequence: u64,
    time: u64,
    bytes: BytesMut,
}

impl Decoder {
    /// Of frames that look so.
    pub fn new(framing: Framing) -> Self {
        Self {
            framing,
            ..Self::default()
        }
    }

    /// Where to append the bytes that come next, and how many at most. There is room for them.
    pub fn space(&mut self) -> (&mut BytesMut, usize) {
        match &mut self.body {
            Some(body) => {
                let missing = body.size - body.bytes.len();
                if body.bytes.capacity() == body.bytes.len() {
                    let step = body.bytes.len().max(STEP);
                    body.bytes.reserve(step.min(missing));
                }
                let room = body.bytes.capacity() - body.bytes.len();
                (&mut body.bytes, room.min(missing))
            }
            None => {
                // From its beginning again when all of it was read: that memory is in the cache.
                let header = self.framing.header();
                let again = self.buffer.is_empty() && self.buffer.try_reclaim(STEP);
                if !again && self.buffer.capacity() - self.buffer.len() < header + SHARED {
                    self.buffer.reserve(STEP);
                }
                let room = self.buffer.capacity() - self.buffer.len();
                let limit = if self.was_large { header } else { room };
                (&mut self.buffer, limit)
            }
        }
    }

    /// The next message, once its bytes are there.
    pub fn message(&mut self) -> Result<Option<Message>, Malformed> {
        if self.body.is_none() {
            let Some(header) = self.framing.decode(&self.buffer)? else {
                return Ok(None);
            };
            if self.ended {
                return Err(Malformed::AfterGoodBye);
            }
            match header {
                Header::GoodBye => {
                    self.buffer.advance(self.framing.header());
                    self.ended = true;
                    return Ok(Some(Message::GoodBye));
                }
                Header::Sample {
                    size,
                    sequence,
                    time,
                } if size <= SHARED => {
                    self.was_large = false;
                    return Ok(self.small(size, sequence, time));
                }
                Header::Sample {
                    size,
                    sequence,
                    time,
                } => self.begin(size, sequence, time),
            }
        }
        Ok(self.large())
    }

    /// True when a frame has begun that is not whole.
    pub fn is_within(&self) -> bool {
        self.body.is_some() || !self.buffer.is_empty()
    }

    fn small(&mut self, size: usize, sequence: u64, time: u64) -> Option<Message> {
        let header = self.framing.header();
        if self.buffer.len() < header + size {
            return None;
        }
        self.buffer.advance(header);
        let payload = match size {
            0 => crate::Payload::new(),
            _ => self.buffer.split_to(size).freeze(),
        };
        Some(Message::Sample(Sample {
            sequence,
            time,
            payload,
        }))
    }

    fn begin(&mut self, size: usize, sequence: u64, time: u64) {
        self.buffer.advance(self.framing.header());
        let mut bytes = self.spare.take(size);
        let here = self.buffer.len().min(size);
        bytes.extend_from_slice(&self.buffer[..here]);
        self.buffer.advance(here);
        self.was_large = true;
        self.body = Some(Body {
            size,
            sequence,
            time,
            bytes,
        });
    }

    fn large(&mut self) -> Option<Message> {
        let mut body = self.body.take_if(|body| body.bytes.len() >= body.size)?;
        // Has the memory counted from now on, so that no counter is made for each sample in it.
        drop(body.bytes.split_off(body.size));
        let payload = body.bytes.freeze();
        self.spare.keep(&payload);
        Some(Message::Sample(Sample {
            sequence: body.sequence,
            time: body.time,
            payload,
        }))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn encoded(sizes: &[usize]) -> (Vec<Sample>, Vec<u8>) {
        let (mut samples, mut bytes) = (Vec::new(), Vec::new());
        for (sequence, size) in (1..).zip(sizes) {
            let payload: Vec<u8> = (0..*size)
                .map(|i| (i as u64 * 7 + sequence) as u8)
                .collect();
            let time = sequence * 1000;
            let header = Header::Sample {
                size: *size,
                sequence,
                time,
            };
            bytes.extend(header.encode());
            bytes.extend(&payload);
            samples.push(Sample {
                sequence,
                time,
                payload: payload.into(),
            });
        }
        bytes.extend(Header::GoodBye.encode());
        (samples, bytes)
    }

    /// Feeds bytes in pieces of the given sizes, over and over.
    fn decode(mut bytes: &[u8], pieces: &[usize]) -> Result<Vec<Message>, Malformed> {
        let (mut decoder, mut messages) = (Decoder::default(), Vec::new());
        for piece in pieces.iter().cycle() {
            while let Some(message) = decoder.message()? {
                messages.push(message);
            }
            if bytes.is_empty() {
                break;
            }
            let (space, limit) = decoder.space();
            assert!(limit > 0 && limit <= space.capacity() - space.len());
            let here = limit.min(*piece).min(bytes.len());
            space.extend_from_slice(&bytes[..here]);
            bytes = &bytes[here..];
        }
        assert!(!decoder.is_within());
        Ok(messages)
    }

    fn size() -> impl Strategy<Value = usize> {
        prop_oneof![0..100_usize, SHARED - 30..SHARED + 30, 0..200_000_usize]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn samples_are_put_together_however_their_bytes_come(
            sizes in prop::collection::vec(size(), 0..8),
            pieces in prop::collection::vec(prop_oneof![1..100_usize, 1..100_000_usize], 1..6),
        ) {
            let (samples, bytes) = encoded(&sizes);
            let mut expected: Vec<_> = samples.into_iter().map(Message::Sample).collect();
            expected.push(Message::GoodBye);
            prop_assert_eq!(decode(&bytes, &pieces), Ok(expected));
        }
    }

    #[test]
    fn memory_is_taken_as_bytes_arrive() {
        let mut decoder = Decoder::default();
        let header = Header::Sample {
            size: crate::MAX_SAMPLE,
            sequence: 1,
            time: 0,
        };
        decoder.space().0.extend_from_slice(&header.encode());
        assert_eq!(decoder.message(), Ok(None));
        let (space, limit) = decoder.space();
        assert!(space.capacity() <= 2 * STEP && limit <= 2 * STEP);
    }

    #[test]
    fn nothing_comes_after_a_good_bye() {
        let bytes = [Header::GoodBye.encode(), Header::GoodBye.encode()].concat();
        assert_eq!(decode(&bytes, &[1000]), Err(Malformed::AfterGoodBye));
    }

    #[test]
    fn the_memory_of_a_large_sample_is_used_again_when_nobody_reads_it_any_more() {
        let mut decoder = Decoder::default();
        let mut places = Vec::new();
        let mut kept = Vec::new();
        for sequence in 0..4 {
            let header = Header::Sample {
                size: 100_000,
                sequence,
                time: 0,
            };
            decoder.space().0.extend_from_slice(&header.encode());
            while decoder.message() == Ok(None) {
                let (space, limit) = decoder.space();
                space.extend_from_slice(&vec![sequence as u8; limit.min(100_000)]);
                if limit >= 100_000 || space.len() == 100_000 {
                    break;
                }
            }
            let Ok(Some(Message::Sample(sample))) = decoder.message() else {
                panic!("the sample is whole");
            };
            assert!(sample.payload.iter().all(|byte| *byte == sequence as u8));
            places.push(sample.payload.as_ptr());
            if sequence == 2 {
                kept.push(sample.payload);
            }
        }
        assert_eq!(places[0], places[1]);
        assert_ne!(places[2], places[3]);
        assert!(kept[0].iter().all(|byte| *byte == 2));
    }
}
