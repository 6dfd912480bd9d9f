//! A control connection as one life of an agent has it: nothing passes it any more once that life is over.

use std::io;
use std::pin::{Pin, pin};
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, DuplexStream, ReadBuf};

use crate::life::Life;

/// Bytes that may be on their way in one direction.
const BUFFER: usize = 64 * 1024;

/// The agent's end.
pub(super) struct Wire {
    stream: DuplexStream,
    life: Life,
}

/// A connection: the agent's end, and the manager's.
pub(super) fn wire(life: Life) -> (Wire, DuplexStream) {
    let (stream, theirs) = tokio::io::duplex(BUFFER);
    (Wire { stream, life }, theirs)
}

impl Wire {
    /// A passage: the crash may come here.
    fn passes(&self, cx: &mut Context<'_>) -> bool {
        pin!(self.life.pass()).poll(cx).is_ready()
    }
}

impl AsyncRead for Wire {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buf: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if self.life.is_over() {
            return Poll::Pending;
        }
        let before = buf.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(cx, buf);
        if read.is_ready() && !self.passes(cx) {
            // Whoever waits for it would find it at the next look.
            buf.set_filled(before);
            return Poll::Pending;
        }
        read
    }
}

impl AsyncWrite for Wire {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        if !self.passes(cx) {
            return Poll::Pending;
        }
        Pin::new(&mut self.stream).poll_write(cx, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}
