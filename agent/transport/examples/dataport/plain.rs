//! Floors: a socket, and nothing else.

use std::io::{Read, Write};

use crate::bytes_of::{expected, fill, sum};
use crate::link::Link;

/// A socket with samples of one size, and nothing that tells them apart.
pub struct Plain<S> {
    socket: S,
    buffer: Vec<u8>,
}

impl<S> Plain<S> {
    pub fn new(socket: S, size: usize) -> Self {
        Self {
            socket,
            buffer: vec![0; size],
        }
    }
}

impl<S: Read + Write> Link for Plain<S> {
    fn send(&mut self, sequence: u64) {
        fill(&mut self.buffer, sequence);
        self.socket.write_all(&self.buffer).unwrap();
    }

    fn receive(&mut self, sequence: u64) -> bool {
        if self.socket.read_exact(&mut self.buffer).is_err() {
            return false;
        }
        assert_eq!(sum(&self.buffer), expected(self.buffer.len(), sequence));
        true
    }
}
