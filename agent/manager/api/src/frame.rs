//! Frames: u32 length in network order, then that many bytes.

use std::io::{self, Read, Write};

use serde::{Serialize, de::DeserializeOwned};

/// Largest JSON frame in bytes.
pub const MAX_FRAME: usize = 4 * 1024 * 1024;

/// A frame that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The other side closed the connection between two frames.
    #[error("connection closed")]
    Closed,
    /// Length above [`MAX_FRAME`].
    #[error("frame of {0} bytes is longer than the limit of {MAX_FRAME}")]
    TooLong(usize),
    /// Not the JSON that was expected.
    #[error("frame is not valid: {0}")]
    Json(#[from] serde_json::Error),
    /// The socket failed.
    #[error("{0}")]
    Io(#[from] io::Error),
}

/// Encodes a value as one frame, length included.
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, FrameError> {
    let mut bytes = vec![0; 4];
    serde_json::to_writer(&mut bytes, value)?;
    let length = bytes.len() - 4;
    if length > MAX_FRAME {
        return Err(FrameError::TooLong(length));
    }
    bytes[..4].copy_from_slice(&(length as u32).to_be_bytes());
    Ok(bytes)
}

/// Checks the length field of a frame.
pub fn length(header: [u8; 4]) -> Result<usize, FrameError> {
    let length = u32::from_be_bytes(header) as usize;
    if length > MAX_FRAME {
        Err(FrameError::TooLong(length))
    } else {
        Ok(length)
    }
}

/// Decodes the body of a frame.
pub fn decode<T: DeserializeOwned>(body: &[u8]) -> Result<T, FrameError> {
    Ok(serde_json::from_slice(body)?)
}

/// Writes one frame and flushes it.
pub fn write<T: Serialize>(to: &mut impl Write, value: &T) -> Result<(), FrameError> {
    to.write_all(&encode(value)?)?;
    to.flush()?;
    Ok(())
}

/// Reads one frame. An end of stream before its first byte is [`FrameError::Closed`].
pub fn read<T: DeserializeOwned>(from: &mut impl Read) -> Result<T, FrameError> {
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
    let mut body = vec![0; length(header)?];
    from.read_exact(&mut body)?;
    decode(&body)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            Err(FrameError::TooLong(_))
        ));
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
