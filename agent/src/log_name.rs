//! File names of logs: plain names stay as they are, everything else is escaped, so that two names never share a file.

use sha2::{Digest, Sha256};

/// Longest file name that is made, in bytes; leaves room for `.log.1`.
const MAX: usize = 200;
/// Hexadecimal digits of the hash that ends a name that was cut.
const HASH_DIGITS: usize = 16;

/// The file name, without its ending. Letters and digits of any script and `-_.+:@()` and blanks stay; other bytes, and
/// a dot at the start, become `%` and two hexadecimal digits.
pub(crate) fn log_name(name: &str) -> String {
    use std::fmt::Write;
    let mut file = String::new();
    for (at, c) in name.char_indices() {
        if is_plain(c) && !(at == 0 && c == '.') {
            file.push(c);
        } else {
            for byte in c.encode_utf8(&mut [0; 4]).bytes() {
                // Writing to a string does not fail.
                let _ = write!(file, "%{byte:02X}");
            }
        }
    }
    if file.is_empty() {
        return "%".to_owned();
    }
    if file.len() > MAX {
        let hash = format!("{:x}", Sha256::digest(name));
        file.truncate(file.floor_char_boundary(MAX - HASH_DIGITS - 1));
        file.push('%');
        file.push_str(&hash[..HASH_DIGITS]);
    }
    file
}

fn is_plain(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | '+' | ':' | '@' | '(' | ')' | ' ')
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn plain_names_stay_and_odd_ones_are_escaped() {
        for name in ["Printer0", "hello.main", "カメラ 左", "a+b@c"] {
            assert_eq!(log_name(name), name);
        }
        assert_eq!(log_name("100%"), "100%25");
        assert_eq!(log_name("../x"), "%2E.%2Fx");
        assert_eq!(log_name("a\nb\0"), "a%0Ab%00");
        assert_eq!(log_name("..."), "%2E..");
        assert_eq!(log_name(""), "%");
    }

    #[test]
    fn long_names_are_cut_by_bytes_and_stay_apart() {
        let names = [
            "カ".repeat(128),
            format!("{}x", "カ".repeat(128)),
            "x".repeat(201),
            "/".repeat(90),
        ];
        let files: BTreeSet<_> = names.iter().map(|name| log_name(name)).collect();
        assert_eq!(files.len(), names.len());
        assert!(files.iter().all(|file| file.len() <= MAX), "{files:?}");
        assert_eq!(log_name(&"x".repeat(200)).len(), 200);
    }
}
