//! Frames: u32 length in network order, then that many bytes.

use std::io::{self, Read, Write};

use serde::{Serialize, de::DeserializeOwned};

/// Largest JSON frame to a manager, in bytes.
pub const MAX_FRAME: usize = 4 * 1024 * 1024;
/// Largest JSON frame from a manager, in bytes: the inventory of thousands of components is one.
pub const MAX_ANSWER: usize = 64 * 1024 * 1024;

/// A frame that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The other side closed the connection between two frames.
    #[error("connection closed")]
    Closed,
    /// Length above [`MAX_FRAME`] or [`MAX_ANSWER`].
    #[error("frame of {length} bytes is longer than the limit of {limit}")]
    TooLong {
        /// Length in bytes.
        length: usize,
        /// What is allowed in this direction.
        limit: usize,
    },
    /// Not the JSON that was expected.
    #[error("frame is not valid: {0}")]
    Json(#[from] serde_json::Error),
    /// The socket failed.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// Encodes a value as one frame to a manager, length included.
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, FrameError> {
    encode_within(MAX_FRAME, value)
}

fn encode_within<T: Serialize>(limit: usize, value: &T) -> Result<Vec<u8>, FrameError> {
    let mut bytes = vec![0; 4];
    serde_json::to_writer(&mut bytes, value)?;
    let header = (bytes.len() - 4) as u32;
    check(bytes.len() - 4, limit)?;
    bytes[..4].copy_from_slice(&header.to_be_bytes());
    Ok(bytes)
}

fn check(length: usize, limit: usize) -> Result<usize, FrameError> {
    if length > limit {
        Err(FrameError::TooLong { length, limit })
    } else {
        Ok(length)
    }
}

/// Checks the length field of a frame from a manager.
pub fn length(header: [u8; 4]) -> Result<usize, FrameError> {
    check(u32::from_be_bytes(header) as usize, MAX_ANSWER)
}

/// Decodes the body of a frame.
pub fn decode<T: DeserializeOwned>(body: &[u8]) -> Result<T, FrameError> {
    Ok(serde_json::from_slice(body)?)
}

/// Writes one frame to a manager and flushes it.
pub fn write<T: Serialize>(to: &mut impl Write, value: &T) -> Result<(), FrameError> {
    write_within(MAX_FRAME, to, value)
}

/// Writes one frame from a manager and flushes it.
pub fn write_answer<T: Serialize>(to: &mut impl Write, value: &T) -> Result<(), FrameError> {
    write_within(MAX_ANSWER, to, value)
}

fn write_within<T: Serialize>(
    limit: usize,
    to: &mut impl Write,
    value: &T,
) -> Result<(), FrameError> {
    to.write_all(&encode_within(limit, value)?)?;
    to.flush()?;
    Ok(())
}

/// Reads one frame to a manager. An end of stream before its first byte is [`FrameError::Closed`].
pub fn read<T: DeserializeOwned>(from: &mut impl Read) -> Result<T, FrameError> {
    read_within(MAX_FRAME, from)
}

/// Reads one frame from a manager, else as [`read`].
pub fn read_answer<T: DeserializeOwned>(from: &mut impl Read) -> Result<T, FrameError> {
    read_within(MAX_ANSWER, from)
}

/// Whether [`read`] can read a frame of these bytes, or say that it is none, without more of them.
pub fn is_whole(bytes: &[u8]) -> bool {
    let Some((header, body)) = bytes.split_first_chunk() else {
        return false;
    };
    let length = u32::from_be_bytes(*header) as usize;
    length > MAX_FRAME || length <= body.len()
}

fn read_within<T: DeserializeOwned>(limit: usize, from: &mut impl Read) -> Result<T, FrameError> {
    let mut header = [0; 4];
    let mut filled = 0;
    while filled < header.len() {
        match from.read(&mut header[filled..]) {
            Ok(0) if filled == 0 => return Err(FrameError::Closed),
            Ok(0) => return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into()),
            Ok(n) => filled += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e.into()),
        }
    }
    let mut body = vec![0; check(u32::from_be_bytes(header) as usize, limit)?];
    from.read_exact(&mut body)?;
    decode(&body)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// What is whole is read, or refused, without more bytes; what is not is not.
        #[test]
        fn whole_is_what_needs_no_more(
            length in prop_oneof![0_u32..20, any::<u32>()],
            body in proptest::collection::vec(any::<u8>(), 0..24),
            cut in 0_usize..30,
        ) {
            let bytes = [&length.to_be_bytes()[..], &body].concat();
            let bytes = &bytes[..cut.min(bytes.len())];
            let starved = matches!(
                read::<u8>(&mut &bytes[..]),
                Err(FrameError::Closed | FrameError::Io(_))
            );
            prop_assert_eq!(is_whole(bytes), !starved);
        }
    }

    #[test]
    fn a_frame_comes_back_as_it_went() {
        let bytes = encode(&("hello", 7)).unwrap();
        let mut cursor = io::Cursor::new(&bytes);
        assert_eq!(
            read::<(String, u32)>(&mut cursor).unwrap(),
            ("hello".to_owned(), 7)
        );
        assert!(matches!(
            read::<(String, u32)>(&mut cursor),
            Err(FrameError::Closed)
        ));
    }

    #[test]
    fn a_length_above_the_limit_is_refused_before_anything_is_allocated() {
        let mut bytes = u32::MAX.to_be_bytes().to_vec();
        bytes.extend([0; 16]);
        assert!(matches!(
            read::<()>(&mut &bytes[..]),
            Err(FrameError::TooLong { .. })
        ));
    }

    #[test]
    fn an_answer_may_be_longer_than_a_request() {
        let text = "x".repeat(MAX_FRAME);
        assert!(matches!(encode(&text), Err(FrameError::TooLong { .. })));
        let mut bytes = Vec::new();
        write_answer(&mut bytes, &text).unwrap();
        let header = bytes[..4].try_into().unwrap();
        assert_eq!(length(header).unwrap(), bytes.len() - 4);
        assert!(matches!(
            read::<String>(&mut &bytes[..]),
            Err(FrameError::TooLong {
                limit: MAX_FRAME,
                ..
            })
        ));
        assert_eq!(read_answer::<String>(&mut &bytes[..]).unwrap(), text);
        assert!(matches!(
            write_answer(&mut io::sink(), &"x".repeat(MAX_ANSWER)),
            Err(FrameError::TooLong {
                limit: MAX_ANSWER,
                ..
            })
        ));
    }

    #[test]
    fn a_frame_is_whole_with_its_last_byte() {
        let bytes = encode(&"hello").unwrap();
        for cut in 0..bytes.len() {
            assert!(!is_whole(&bytes[..cut]), "{cut}");
        }
        assert!(is_whole(&bytes));
        assert!(is_whole(&[&bytes[..], &bytes[..2]].concat()));
        // What is too long is refused before the rest comes.
        assert!(is_whole(&u32::MAX.to_be_bytes()));
    }

    #[test]
    fn a_frame_that_is_cut_is_an_error() {
        let bytes = encode(&"hello").unwrap();
        assert!(matches!(
            read::<String>(&mut &bytes[..6]),
            Err(FrameError::Io(_))
        ));
        assert!(matches!(
            read::<String>(&mut &bytes[..2]),
            Err(FrameError::Io(_))
        ));
    }
}
