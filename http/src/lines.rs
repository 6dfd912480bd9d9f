//! Reading streams of lines (JSON Lines, server-sent events) with a bound on each line.

use std::pin::Pin;

use bytes::{Buf, Bytes, BytesMut};
use futures_util::{Stream, StreamExt};

/// Longest line in bytes.
pub const MAX_LINE: usize = 16 * 1024 * 1024;

/// A stream that broke.
#[derive(Debug, thiserror::Error)]
pub enum LineError {
    /// The transport failed.
    #[error("{0}")]
    Transport(String),
    /// A line above [`MAX_LINE`].
    #[error("a line is longer than {MAX_LINE} bytes")]
    TooLong,
}

/// Splits a body into lines.
pub struct Lines {
    body: Pin<Box<dyn Stream<Item = Result<Bytes, String>> + Send>>,
    buffer: BytesMut,
    scanned: usize,
}

impl Lines {
    /// Lines of a response.
    pub fn of(response: reqwest::Response) -> Self {
        Self::new(
            response
                .bytes_stream()
                .map(|chunk| chunk.map_err(|e| e.to_string())),
        )
    }

    /// Lines of any stream of bytes.
    pub fn new(body: impl Stream<Item = Result<Bytes, String>> + Send + 'static) -> Self {
        Self {
            body: Box::pin(body),
            buffer: BytesMut::new(),
            scanned: 0,
        }
    }

    /// The next line without its end; `None` at the end of the stream. A last line without an end is given too.
    pub async fn next(&mut self) -> Option<Result<String, LineError>> {
        loop {
            if let Some(at) = self.buffer[self.scanned..].iter().position(|b| *b == b'\n') {
                let line = self.buffer.split_to(self.scanned + at);
                self.buffer.advance(1);
                self.scanned = 0;
                return Some(Ok(text(&line)));
            }
            self.scanned = self.buffer.len();
            if self.scanned > MAX_LINE {
                return Some(Err(LineError::TooLong));
            }
            match self.body.next().await {
                Some(Ok(chunk)) => self.buffer.extend_from_slice(&chunk),
                Some(Err(e)) => return Some(Err(LineError::Transport(e))),
                None if self.buffer.is_empty() => return None,
                None => {
                    self.scanned = 0;
                    let rest = self.buffer.split();
                    return Some(Ok(text(&rest)));
                }
            }
        }
    }
}

fn text(line: &[u8]) -> String {
    String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line)).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn lines_come_whole_however_the_chunks_fall() {
        let chunks = ["a", "b\nc", "\r\n\nd"].map(|c| Ok(Bytes::from_static(c.as_bytes())));
        let mut lines = Lines::new(futures_util::stream::iter(chunks));
        let mut got = Vec::new();
        while let Some(line) = lines.next().await {
            got.push(line.unwrap());
        }
        assert_eq!(got, ["ab", "c", "", "d"]);
    }
}
