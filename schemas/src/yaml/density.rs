//! What the parser keeps of a text: a list or mapping in brackets may be a key, so all of it is held until it ends.

/// Bytes of one token in the parser.
const TOKEN: usize = 104;

/// Bytes of tokens for a byte of text, and those that every file may have. JSON with short values takes half of it.
const TIMES: usize = 40;
const AT_LEAST: usize = 512 << 10;

/// True when the tokens within brackets would take many times the memory of the text.
pub(super) fn is_too_dense(text: &str) -> bool {
    let tokens = tokens_in_brackets(text.as_bytes());
    let most = text.len().saturating_mul(TIMES).saturating_add(AT_LEAST);
    // The parser's queue doubles when it is full.
    tokens.next_power_of_two().saturating_mul(TOKEN) > most
}

/// About how many tokens stand within brackets; never much fewer than there are.
fn tokens_in_brackets(text: &[u8]) -> usize {
    let mut depth = 0_usize;
    let mut tokens = 0;
    let mut before = b' ';
    for (at, byte) in text.iter().enumerate() {
        let ends_key = || {
            let next = text.get(at + 1).copied().unwrap_or(b' ');
            matches!(
                next,
                b' ' | b'\t' | b'\r' | b'\n' | b',' | b'[' | b']' | b'{' | b'}'
            ) || matches!(before, b'"' | b'\'' | b']' | b'}')
        };
        tokens += match byte {
            b'[' | b'{' => {
                depth += 1;
                1
            }
            b']' | b'}' => {
                depth = depth.saturating_sub(1);
                1
            }
            _ if depth == 0 => 0,
            // The value before it, and the comma.
            b',' => 2,
            // The key, what it is marked with, and the colon.
            b':' if ends_key() => 3,
            b'&' | b'*' | b'!' | b'?' => 1,
            _ => 0,
        };
        before = *byte;
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_says_nothing_is_too_dense() {
        let json = |pair: &str| format!("{{{}}}", pair.repeat(2_000_000 / pair.len()));
        assert!(!is_too_dense(&json("\"instanceName\": \"Motor0\", ")));
        assert!(!is_too_dense(&"- x: 1\n".repeat(300_000)));
        assert!(is_too_dense(&json("{},")));
        assert!(is_too_dense(&json("a,")));
        assert_eq!(tokens_in_brackets(b"a: [b, {c: d}]"), 9);
    }
}
