//! The yamux connection: who opens streams, who is handed those of the other side, and the task that drives it.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio_util::compat::{Compat, FuturesAsyncReadCompatExt, TokioAsyncReadCompatExt};
use yamux::{Config, Connection, ConnectionError, Mode};

use crate::Kind;

/// A stream.
pub type Stream = Compat<yamux::Stream>;

/// Most streams at once, of both sides.
const MAX_STREAMS: usize = 256;
/// Most bytes that may wait to be read here, over all streams: enough for the smallest window of each.
const MAX_WAITING: usize = MAX_STREAMS * 256 * 1024;
/// Streams of the other side that may wait to be taken; more are refused.
const BACKLOG: usize = 64;

/// The connection has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the connection has ended")]
pub struct Gone;

/// Opens streams. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Opener(mpsc::Sender<oneshot::Sender<yamux::Stream>>);

impl Opener {
    /// Opens a stream and says what it is for.
    pub async fn open(&self, kind: Kind) -> Result<Stream, Gone> {
        let (answer, answered) = oneshot::channel();
        self.0.send(answer).await.map_err(|_| Gone)?;
        let mut stream = answered.await.map_err(|_| Gone)?.compat();
        stream.write_u8(kind.byte()).await.map_err(|_| Gone)?;
        stream.flush().await.map_err(|_| Gone)?;
        Ok(stream)
    }
}

/// The streams that the other side opens.
#[derive(Debug)]
pub struct Incoming(mpsc::Receiver<yamux::Stream>);

impl Incoming {
    /// The next one; none when the connection has ended.
    pub async fn next(&mut self) -> Option<Stream> {
        Some(self.0.recv().await?.compat())
    }
}

/// Begins a connection; it ends when the task is aborted, or by itself with why.
pub(crate) fn begin(
    io: impl AsyncRead + AsyncWrite + Send + Unpin + 'static,
    mode: Mode,
) -> (Opener, Incoming, JoinHandle<String>) {
    let mut config = Config::default();
    config
        .set_max_num_streams(MAX_STREAMS)
        .set_max_connection_receive_window(Some(MAX_WAITING));
    let connection = Connection::new(io.compat(), config, mode);
    let (open, wanted) = mpsc::channel(BACKLOG);
    let (take, taken) = mpsc::channel(BACKLOG);
    let mut driver = Driver {
        connection,
        wanted,
        waiting: VecDeque::new(),
        take,
    };
    let task = tokio::spawn(async move {
        let why = poll_fn(|context| driver.poll(context)).await;
        why.map_or_else(|| "it was closed".to_owned(), |e| e.to_string())
    });
    (Opener(open), Incoming(taken), task)
}

struct Driver<T> {
    connection: Connection<T>,
    wanted: mpsc::Receiver<oneshot::Sender<yamux::Stream>>,
    /// Who waits for a stream; at most [`BACKLOG`].
    waiting: VecDeque<oneshot::Sender<yamux::Stream>>,
    take: mpsc::Sender<yamux::Stream>,
}

impl<T: futures_util::AsyncRead + futures_util::AsyncWrite + Unpin> Driver<T> {
    /// Goes on; ready when the connection has ended.
    fn poll(&mut self, context: &mut Context<'_>) -> Poll<Option<ConnectionError>> {
        loop {
            while self.waiting.len() < BACKLOG {
                match self.wanted.poll_recv(context) {
                    Poll::Ready(Some(who)) => self.waiting.push_back(who),
                    Poll::Ready(None) | Poll::Pending => break,
                }
            }
            if !self.waiting.is_empty() {
                match self.connection.poll_new_outbound(context) {
                    Poll::Ready(Ok(stream)) => {
                        if let Some(who) = self.waiting.pop_front() {
                            // Whoever has given up drops it.
                            let _ = who.send(stream);
                        }
                        continue;
                    }
                    Poll::Ready(Err(e)) => return Poll::Ready(Some(e)),
                    Poll::Pending => {}
                }
            }
            match self.connection.poll_next_inbound(context) {
                // One that finds no room is dropped, and so reset.
                Poll::Ready(Some(Ok(stream))) => drop(self.take.try_send(stream)),
                Poll::Ready(Some(Err(e))) => return Poll::Ready(Some(e)),
                Poll::Ready(None) => return Poll::Ready(None),
                Poll::Pending => return Poll::Pending,
            }
        }
    }
}
