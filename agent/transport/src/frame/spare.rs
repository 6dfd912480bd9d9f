//! Payload buffers that are used again once their readers have let go of them.

use std::collections::VecDeque;

use bytes::BytesMut;

use crate::Payload;

/// So many are kept.
const KEPT: usize = 2;

/// Larger ones are not kept, as they would be held as long as the connection.
const LARGEST: usize = 8 * 1024 * 1024;

/// A sample gets no more memory than so many times its size, as whoever counts what waits counts its size.
const ROOM: usize = 4;

/// Buffers of samples that were handed on.
#[derive(Debug, Default)]
pub struct Spare(VecDeque<Payload>);

impl Spare {
    /// An empty buffer: a used one that has room for so much, or one without memory.
    pub fn take(&mut self, size: usize) -> BytesMut {
        let fits = |room: usize| (size..=size.saturating_mul(ROOM)).contains(&room);
        let free = |payload: &Payload| payload.is_unique() && fits(payload.len());
        let used = self.0.iter().position(free);
        let used = used.and_then(|at| self.0.remove(at));
        match used.map(Payload::try_into_mut) {
            // What was cut off of a larger one has its room still.
            Some(Ok(mut buffer)) if fits(buffer.capacity()) => {
                buffer.clear();
                buffer
            }
            _ => BytesMut::new(),
        }
    }

    /// Remembers a payload that is handed on.
    pub fn keep(&mut self, payload: &Payload) {
        if payload.len() > LARGEST {
            return;
        }
        if self.0.len() >= KEPT {
            self.0.pop_front();
        }
        self.0.push_back(payload.clone());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_sample_does_not_hold_the_memory_of_a_large_one() {
        let mut spare = Spare::default();
        let large = |spare: &mut Spare| {
            let payload = BytesMut::zeroed(1 << 20).freeze();
            spare.keep(&payload);
        };
        large(&mut spare);
        assert!(spare.take(1 << 14).capacity() <= 1 << 16);
        assert!(
            spare.take(1 << 20).capacity() >= 1 << 20,
            "it is kept for a large one"
        );
        // One that was shortened: it looks small, and is not.
        let mut long = BytesMut::zeroed(1 << 20);
        long.truncate(1 << 14);
        spare.keep(&long.freeze());
        assert!(spare.take(1 << 14).capacity() <= 1 << 16);
    }
}
