//! Signs of life: near sends one each second, far answers each. A connection that looks open and carries nothing is found
//! out by both sides.

use std::io;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{MissedTickBehavior, interval, timeout};

use crate::mux::Stream;

/// Time between two signs.
pub const EVERY: Duration = Duration::from_secs(1);
/// Without a sign for so long the other side is gone.
pub const PATIENCE: Duration = Duration::from_secs(8);

/// A sign of life.
const ALIVE: u8 = b'.';
/// Far was told to end, by somebody there or by a newcomer.
const TOLD: u8 = b'T';

/// Why signs have ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The other side is gone.
    Lost,
    /// Far was told to end by somebody else.
    Told,
}

/// Near's end.
#[derive(Debug)]
pub struct Near(Stream);

impl Near {
    pub(crate) fn new(stream: Stream) -> Self {
        Self(stream)
    }

    /// Sends signs until the other side is gone.
    pub async fn keep(self) -> End {
        let (mut from, mut to) = tokio::io::split(self.0);
        let send = async {
            let mut next = interval(EVERY);
            next.set_missed_tick_behavior(MissedTickBehavior::Delay);
            loop {
                next.tick().await;
                if sign(&mut to, ALIVE).await.is_err() {
                    // What it said last may still be on its way.
                    std::future::pending::<()>().await;
                }
            }
        };
        let hear = async {
            loop {
                match timeout(PATIENCE, from.read_u8()).await {
                    Ok(Ok(TOLD)) => return End::Told,
                    Ok(Ok(_)) => {}
                    Ok(Err(_)) | Err(_) => return End::Lost,
                }
            }
        };
        tokio::select! {
            end = hear => end,
            never = send => never,
        }
    }
}

/// Far's end: answers until near is gone, or `told` is done.
pub async fn far(stream: Stream, told: impl Future<Output = ()>) -> End {
    let (mut from, mut to) = tokio::io::split(stream);
    let answer = async {
        loop {
            match timeout(PATIENCE, from.read_u8()).await {
                Ok(Ok(_)) if sign(&mut to, ALIVE).await.is_ok() => {}
                _ => return,
            }
        }
    };
    tokio::select! {
        () = answer => return End::Lost,
        () = told => {}
    }
    let _ = timeout(EVERY, sign(&mut to, TOLD)).await;
    End::Told
}

async fn sign(to: &mut (impl tokio::io::AsyncWrite + Unpin), sign: u8) -> io::Result<()> {
    to.write_u8(sign).await?;
    to.flush().await
}
