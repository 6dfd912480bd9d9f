//! What is in a sample: every byte is written by who sends it, and added up by who receives it.

use bytes::{Bytes, BytesMut};

/// Writes all bytes.
#[inline(never)]
pub fn fill(bytes: &mut [u8], sequence: u64) {
    for (at, word) in (0..).zip(bytes.chunks_exact_mut(8)) {
        let value: u64 = sequence.wrapping_add(at);
        word.copy_from_slice(&value.to_ne_bytes());
    }
}

/// Adds up all bytes.
#[inline(never)]
pub fn sum(bytes: &[u8]) -> u64 {
    let words = bytes.chunks_exact(8);
    let words = words.map(|word| u64::from_ne_bytes(std::array::from_fn(|i| word[i])));
    words.fold(0, u64::wrapping_add)
}

/// What [`sum`] of such a sample is.
pub fn expected(size: usize, sequence: u64) -> u64 {
    let n = (size / 8) as u64;
    n.wrapping_mul(sequence).wrapping_add(n * (n - 1) / 2)
}

/// Payloads, in memory that is used again.
pub struct Payloads {
    size: usize,
    last: Bytes,
}

impl Payloads {
    pub fn new(size: usize) -> Self {
        let last = Self::memory(size).freeze();
        Self { size, last }
    }

    fn memory(size: usize) -> BytesMut {
        let mut bytes = BytesMut::zeroed(size);
        // Counted from now on, so that no counter is made each time.
        drop(bytes.split_off(size));
        bytes
    }

    /// The payload of this number.
    pub fn next(&mut self, sequence: u64) -> Bytes {
        let last = std::mem::take(&mut self.last).try_into_mut();
        let mut bytes = last.unwrap_or_else(|_| Self::memory(self.size));
        fill(&mut bytes, sequence);
        let payload = bytes.freeze();
        self.last = payload.clone();
        payload
    }
}
