//! A stream joined to a Unix socket.

use std::io;
use std::path::Path;

use tokio::io::copy_bidirectional;
use tokio::net::UnixStream;

use crate::mux::Stream;

/// Joins a stream to whoever listens on a socket, until both have ended.
pub async fn join(mut stream: Stream, socket: &Path) -> io::Result<()> {
    let mut other = UnixStream::connect(socket).await?;
    copy_bidirectional(&mut stream, &mut other).await.map(drop)
}
