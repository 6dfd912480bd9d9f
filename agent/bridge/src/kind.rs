//! What a stream is for: its first byte.

use std::time::Duration;

use tokio::io::AsyncReadExt;
use tokio::time::timeout;

use crate::mux::Stream;

/// How long whoever opens a stream may take to say what it is for.
const PATIENCE: Duration = Duration::from_secs(10);

/// What a stream is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Near asks the agent: HTTP, as on its socket.
    Agent,
    /// Far tells the controller of its session: HTTP, as on the controller's socket.
    Controller,
    /// Far asks for a module: see [`crate::modules`].
    Module,
    /// Signs of life, opened by near: see [`crate::pulse`].
    Pulse,
}

impl Kind {
    /// Its byte.
    pub const fn byte(self) -> u8 {
        match self {
            Kind::Agent => b'A',
            Kind::Controller => b'C',
            Kind::Module => b'M',
            Kind::Pulse => b'P',
        }
    }

    /// What a byte means; none for one that means nothing here.
    pub const fn of(byte: u8) -> Option<Self> {
        match byte {
            b'A' => Some(Kind::Agent),
            b'C' => Some(Kind::Controller),
            b'M' => Some(Kind::Module),
            b'P' => Some(Kind::Pulse),
            _ => None,
        }
    }

    /// Reads what a stream that was just accepted is for; none when it does not say so in time.
    pub async fn read(stream: &mut Stream) -> Option<Self> {
        let byte = timeout(PATIENCE, stream.read_u8()).await.ok()?.ok()?;
        Self::of(byte)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_a_byte_of_its_own() {
        let known: Vec<u8> = (0..=u8::MAX).filter(|b| Kind::of(*b).is_some()).collect();
        assert_eq!(known, b"ACMP");
        for byte in known {
            assert_eq!(Kind::of(byte).map(Kind::byte), Some(byte));
        }
    }
}
