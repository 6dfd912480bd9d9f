//! Bytes → text. Nothing in the file declares its encoding.

use encoding_rs::{EUC_JP, Encoding, SHIFT_JIS, UTF_8};

use crate::diagnostic::{Finding, Source};

/// Largest file that is read, in bytes. The largest known one has 51 kB.
pub const SIZE_LIMIT: usize = 1 << 20;

/// The text of a file, and the name of its encoding.
pub(super) fn decode(name: &str, bytes: &[u8]) -> Result<(String, &'static str), Box<Finding>> {
    if bytes.len() > SIZE_LIMIT {
        let message = format!(
            "{name} has {} bytes; at most {SIZE_LIMIT} are read",
            bytes.len()
        );
        let finding = Finding::error("too-large", message).help("is this the right file?");
        return Err(Box::new(finding));
    }
    text(bytes).ok_or_else(|| not_text(name, bytes))
}

/// The text that bytes are, and the name of its encoding: that of a byte order mark, UTF-8, Shift_JIS or EUC-JP.
pub(crate) fn text(bytes: &[u8]) -> Option<(String, &'static str)> {
    if let Some((encoding, mark)) = Encoding::for_bom(bytes) {
        return strict(encoding, &bytes[mark..]);
    }
    if bytes.contains(&0) {
        return None;
    }
    strict(UTF_8, bytes).or_else(|| japanese(bytes))
}

fn strict(encoding: &'static Encoding, bytes: &[u8]) -> Option<(String, &'static str)> {
    let text = encoding.decode_without_bom_handling_and_without_replacement(bytes)?;
    Some((text.into_owned(), encoding.name()))
}

/// Most texts in one of the two encodings can be read in the other, but then they are full of half-width katakana.
fn japanese(bytes: &[u8]) -> Option<(String, &'static str)> {
    let half_width = |text: &str| {
        text.chars()
            .filter(|c| ('\u{ff61}'..='\u{ff9f}').contains(c))
            .count()
    };
    match (strict(SHIFT_JIS, bytes), strict(EUC_JP, bytes)) {
        (Some(sjis), Some(euc)) if half_width(&euc.0) < half_width(&sjis.0) => Some(euc),
        (Some(sjis), _) => Some(sjis),
        (None, euc) => euc,
    }
}

fn not_text(name: &str, bytes: &[u8]) -> Box<Finding> {
    let valid = String::from_utf8_lossy(bytes);
    let at = valid.find([char::REPLACEMENT_CHARACTER, '\0']).unwrap_or(0);
    let place = Source::new(name, valid.as_ref()).place(at, at + 1);
    let message = format!("{name} is no text, so it is no configuration file");
    let help = "it must be text in UTF-8, Shift_JIS or EUC-JP";
    Box::new(
        Finding::error("conf-not-text", message)
            .at(Some(place))
            .help(help),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn japanese_comments_are_read_in_any_encoding() {
        let text = "# 設定ファイルです。カタカナも。\nnaming.enable: YES\n";
        let encodings = [
            (UTF_8, "UTF-8"),
            (SHIFT_JIS, "Shift_JIS"),
            (EUC_JP, "EUC-JP"),
        ];
        for (encoding, name) in encodings {
            let bytes = encoding.encode(text).0;
            assert_eq!(decode("rtc.conf", &bytes).unwrap(), (text.to_owned(), name));
        }
        let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
        assert_eq!(decode("rtc.conf", &marked).unwrap().0, text);
    }

    #[test]
    fn what_is_no_text_is_refused() {
        for bytes in [&b"a\0b"[..], b"\xff\xff\xff"] {
            assert_eq!(
                decode("order.conf", bytes).unwrap_err().code,
                "conf-not-text"
            );
        }
        let large = vec![b'#'; SIZE_LIMIT + 1];
        assert_eq!(decode("rtc.conf", &large).unwrap_err().code, "too-large");
    }
}
