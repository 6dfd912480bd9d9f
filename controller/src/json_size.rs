//! How long an object is as JSON, without making it.

use std::io;

use serde::Serialize;

/// Bytes of its JSON.
pub fn json_size(value: &impl Serialize) -> usize {
    let mut count = Count(0);
    // Nothing of ours can fail to become JSON, and counting cannot fail.
    let _ = serde_json::to_writer(&mut count, value);
    count.0
}

struct Count(usize);

impl io::Write for Count {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
