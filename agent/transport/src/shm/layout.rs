//! What is where in the shared memory. Both counts only grow; each is written by one side.

use std::ops::RangeInclusive;

/// u64: bytes that the writer has put into the ring.
pub const WRITTEN: usize = 0;
/// u64: bytes that the reader has taken out of it.
pub const TAKEN: usize = 128;
/// u32: how the reader sleeps, if it does.
pub const READER: usize = 256;
/// u32: how the writer sleeps, if it does.
pub const WRITER: usize = 384;
/// Here the ring begins, and goes on to the end.
pub const DATA: usize = 4096;

/// Sizes that a ring may have; powers of two only.
pub const SIZES: RangeInclusive<usize> = 64 * 1024..=64 * 1024 * 1024;

/// It does not sleep.
pub const AWAKE: u32 = 0;
/// It waits for the word to change (futex).
pub const ON_WORD: u32 = 1;
/// It waits for its socket: a byte, [`WAKE`], wakes it.
pub const ON_SOCKET: u32 = 2;

/// Wakes who sleeps on the socket.
pub const WAKE: u8 = b'W';
/// What the sender says when it passes the memory; names this layout.
pub const PASSES: u8 = b'1';
