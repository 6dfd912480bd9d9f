//! The transports by their names in connector profiles.

use std::fmt;
use std::io;
use std::os::fd::OwnedFd;
use std::str::FromStr;

use crate::{Receiver, Sender, shm, tcp, unix};

/// A transport, as `dataport.interface_type` names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Inside a process.
    InProcess,
    /// Shared memory.
    SharedMemory,
    /// Unix socket.
    Unix,
    /// TCP.
    Tcp,
}

impl Kind {
    /// All, the best first where several reach.
    pub const ALL: [Self; 4] = [Self::InProcess, Self::SharedMemory, Self::Unix, Self::Tcp];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::InProcess => "inproc",
            Self::SharedMemory => "shm",
            Self::Unix => "uds",
            Self::Tcp => "tcp",
        }
    }

    /// The sending end over a connected socket, which both ends have agreed to use for this.
    pub fn sender(self, socket: OwnedFd) -> io::Result<Box<dyn Sender>> {
        Ok(match self {
            Self::InProcess => return Err(self.needs_none()),
            Self::SharedMemory => Box::new(shm::sender(socket.into())?),
            Self::Unix => Box::new(unix::sender(socket.into())?),
            Self::Tcp => Box::new(tcp::sender(socket.into())?),
        })
    }

    /// The receiving end over a connected socket, which both ends have agreed to use for this.
    pub fn receiver(self, socket: OwnedFd) -> io::Result<Box<dyn Receiver>> {
        Ok(match self {
            Self::InProcess => return Err(self.needs_none()),
            Self::SharedMemory => Box::new(shm::receiver(socket.into())?),
            Self::Unix => Box::new(unix::receiver(socket.into())?),
            Self::Tcp => Box::new(tcp::receiver(socket.into())?),
        })
    }

    fn needs_none(self) -> io::Error {
        let text = format!("the transport {self} has no socket");
        io::Error::new(io::ErrorKind::InvalidInput, text)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// No transport has this name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownKind(pub String);

impl fmt::Display for UnknownKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known: Vec<_> = Kind::ALL.map(Kind::name).into();
        write!(
            f,
            "there is no transport {:?}: {} are known",
            self.0,
            known.join(", ")
        )
    }
}

impl std::error::Error for UnknownKind {}

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(name: &str) -> Result<Self, UnknownKind> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| UnknownKind(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_found_by_its_name_and_no_other() {
        for kind in Kind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        let error = "pigeon".parse::<Kind>().unwrap_err();
        assert!(error.to_string().contains("uds"), "{error}");
    }
}
