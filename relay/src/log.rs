//! What the agent over there logs comes home: into this process's own log, line by line.

use std::io::Write;
use std::sync::{Arc, Mutex, PoisonError};

use tokio::io::{AsyncBufReadExt, AsyncRead, AsyncReadExt, BufReader};

/// Longest line in bytes; the rest of a longer one is a line of its own.
const MAX_LINE: u64 = 8 * 1024;

/// The last line that came.
pub(crate) type Last = Arc<Mutex<Option<String>>>;

/// Copies lines to standard error, until there are no more.
pub(crate) async fn bring_home(from: impl AsyncRead + Unpin, last: Last) {
    let mut from = BufReader::new(from);
    let mut line = Vec::new();
    loop {
        line.clear();
        match (&mut from)
            .take(MAX_LINE)
            .read_until(b'\n', &mut line)
            .await
        {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let line = tame(&line);
        if line.is_empty() {
            continue;
        }
        let _ = writeln!(std::io::stderr(), "{line}");
        *last.lock().unwrap_or_else(PoisonError::into_inner) = Some(line);
    }
}

/// The last line that came, if there was one.
pub(crate) fn last(last: &Last) -> Option<String> {
    last.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// A line that can move no cursor.
fn tame(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(line);
    let tamed = text.trim_end().chars().map(|c| match c {
        '\t' => ' ',
        c if c.is_control() => '\u{fffd}',
        c => c,
    });
    tamed.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn lines_come_home_and_cannot_move_a_cursor() {
        let told: Last = Arc::default();
        bring_home(&b"one\n\x1b[2Jtwo\n\n"[..], Arc::clone(&told)).await;
        assert_eq!(last(&told).as_deref(), Some("\u{fffd}[2Jtwo"));
    }
}
