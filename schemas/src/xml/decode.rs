//! Bytes → text: byte order mark, then the XML declaration's encoding, then UTF-8.
//!
//! Windows tools write cp932 and declare UTF-8; such bytes are read as cp932 with a warning.

use encoding_rs::{Encoding, SHIFT_JIS, UTF_8, UTF_16BE, UTF_16LE};

use crate::diagnostic::{Finding, Source};

/// Largest file that is read, in bytes. The largest known profile has 90 kB; a system of 5,000 components has 10 MB.
pub const SIZE_LIMIT: usize = 128 << 20;

/// A text and how it was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decoded {
    /// The text, without byte order mark.
    pub text: String,
    /// Name of the encoding (`UTF-8`, `Shift_JIS`, …).
    pub encoding: &'static str,
    /// Said when the bytes are not what the file declares.
    pub warning: Option<Finding>,
}

/// Decodes a file.
///
/// # Errors
/// `too-large`, or `bad-encoding` with the place of the first byte that means nothing.
pub fn decode(name: &str, bytes: &[u8]) -> Result<Decoded, Box<Finding>> {
    if bytes.len() > SIZE_LIMIT {
        let message = format!(
            "{name} has {} bytes; at most {SIZE_LIMIT} are read",
            bytes.len()
        );
        return Err(Box::new(
            Finding::error("too-large", message).help("is this the right file?"),
        ));
    }
    if let Some((encoding, mark)) = Encoding::for_bom(bytes) {
        return strict(encoding, &bytes[mark..])
            .ok_or_else(|| undecodable(name, bytes, encoding.name()));
    }
    let (encoding, label) = declared(bytes);
    let Some(encoding) = encoding else {
        let label = label.unwrap_or_default();
        return fallback(bytes)
            .map(|mut decoded| {
                let message = format!(
                    "{name} declares the unknown encoding `{label}`; it was read as {}",
                    decoded.encoding
                );
                decoded.warning = Some(mismatch(name, &decoded.text, message));
                decoded
            })
            .ok_or_else(|| undecodable(name, bytes, &label));
    };
    if let Some(decoded) = strict(encoding, bytes) {
        return Ok(decoded);
    }
    match fallback(bytes) {
        Some(mut decoded) => {
            let message = format!(
                "{name} says that it is {}, but it is not; it was read as {}",
                encoding.name(),
                decoded.encoding
            );
            decoded.warning = Some(mismatch(name, &decoded.text, message));
            Ok(decoded)
        }
        None => Err(undecodable(name, bytes, encoding.name())),
    }
}

/// At the declaration, or where it should stand.
fn mismatch(name: &str, text: &str, message: String) -> Finding {
    let head = &text[..text.floor_char_boundary(256)];
    let end = head.find("?>").map_or(0, |at| at + 2);
    let place = Source::new(name, head).place(0, end);
    let finding = Finding::warning("encoding-mismatch", message).at(Some(place));
    finding.help(SAVE_AS_UTF_8)
}

const SAVE_AS_UTF_8: &str = "save the file as UTF-8 and declare `encoding=\"UTF-8\"`";

fn strict(encoding: &'static Encoding, bytes: &[u8]) -> Option<Decoded> {
    let text = encoding.decode_without_bom_handling_and_without_replacement(bytes)?;
    Some(Decoded {
        text: text.into_owned(),
        encoding: encoding.name(),
        warning: None,
    })
}

fn fallback(bytes: &[u8]) -> Option<Decoded> {
    strict(UTF_8, bytes).or_else(|| strict(SHIFT_JIS, bytes))
}

/// The encoding that the XML declaration names, and its label when that is not a known one.
fn declared(bytes: &[u8]) -> (Option<&'static Encoding>, Option<String>) {
    match bytes {
        [b'<', 0, ..] => return (Some(UTF_16LE), None),
        [0, b'<', ..] => return (Some(UTF_16BE), None),
        _ => {}
    }
    let Some(label) = declared_label(bytes) else {
        return (Some(UTF_8), None);
    };
    match Encoding::for_label(label.as_bytes()) {
        // The declaration could be read as ASCII, so the file cannot be UTF-16.
        Some(encoding) if encoding == UTF_16LE || encoding == UTF_16BE => (None, Some(label)),
        Some(encoding) => (Some(encoding), None),
        None => (None, Some(label)),
    }
}

fn declared_label(bytes: &[u8]) -> Option<String> {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(256)]).into_owned();
    let declaration = head.trim_start().strip_prefix("<?xml")?;
    let declaration = &declaration[..declaration.find("?>")?];
    let (_, rest) = declaration.split_once("encoding")?;
    let rest = rest.trim_start().strip_prefix('=')?.trim_start();
    let quote = rest.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    rest[1..]
        .split_once(quote)
        .map(|(label, _)| label.to_owned())
}

fn undecodable(name: &str, bytes: &[u8], encoding: &str) -> Box<Finding> {
    let valid = String::from_utf8_lossy(bytes);
    let at = valid.find(char::REPLACEMENT_CHARACTER).unwrap_or(0);
    let place = Source::new(name, valid.as_ref()).place(at, at + 3);
    let finding =
        Finding::error("bad-encoding", format!("this is not {encoding} text")).at(Some(place));
    Box::new(finding.help(SAVE_AS_UTF_8))
}
