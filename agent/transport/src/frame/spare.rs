//! Payload buffers that are used again once their readers have let go of them.

use std::collections::VecDeque;

use bytes::BytesMut;

use crate::Payload;

/// So many are kept.
const KEPT: usize = 2;

/// Larger ones are not kept, as they would be held as long as the connection.
const LARGEST: usize = 8 * 1024 * 1024;

/// Buffers of samples that were handed on.
#[derive(Debug, Default)]
pub struct Spare(VecDeque<Payload>);

impl Spare {
    /// An empty buffer: a used one that has room for so much, or one without memory.
    pub fn take(&mut self, size: usize) -> BytesMut {
        let free = |payload: &Payload| payload.is_unique() && payload.len() >= size;
        let used = self.0.iter().position(free);
        let used = used.and_then(|at| self.0.remove(at));
        match used.map(Payload::try_into_mut) {
            Some(Ok(mut buffer)) => {
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
