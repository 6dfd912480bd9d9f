//! The text of a ledger's file: an envelope whose spec is text, with a number and sums that tell whether it is whole. What the spec
//! says is left to others. The fuzz target `ledger` includes this file as it is.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};

/// Lengths are multiples of this, in bytes.
pub const BLOCK: usize = 16 * 1024;

/// What is before the fields of the envelope; an agent of before wrote neither.
#[derive(Deserialize)]
struct Head {
    sequence: Option<u64>,
    checksum: Option<String>,
}

/// An envelope whose spec is text. `F` is whose ledger it takes over.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Text<F> {
    /// Store that wrote it.
    pub cluster_uid: String,
    /// Its epoch.
    pub epoch: u64,
    /// Of the node.
    pub generation: u64,
    /// Of the spec.
    pub digest: String,
    /// The ledger that it is to take the place of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub take_over: Option<F>,
    /// What the node should run.
    pub spec: Box<RawValue>,
}

/// Reads a file with its number. An error says what is not whole.
pub fn read<F: Serialize + DeserializeOwned>(bytes: &[u8]) -> Result<(u64, Text<F>), String> {
    let text: Text<F> = serde_json::from_slice(bytes).map_err(|e| e.to_string())?;
    let head: Head = serde_json::from_slice(bytes).map_err(|e| e.to_string())?;
    if digest(&text.spec) != text.digest {
        return Err("its digest does not fit its contents".to_owned());
    }
    let number = head.sequence.unwrap_or(0);
    if head.sequence.is_some() || head.checksum.is_some() {
        let own = checksum(number, &text).map_err(|e| e.to_string())?;
        if head.checksum.as_ref() != Some(&own) {
            return Err("its checksum does not fit its contents".to_owned());
        }
    }
    Ok((number, text))
}

/// What is written, at least so many bytes.
pub fn written(
    number: u64,
    envelope: &impl Serialize,
    least: usize,
) -> serde_json::Result<Vec<u8>> {
    let checksum = checksum(number, envelope)?;
    let fields = serde_json::to_string_pretty(envelope)?;
    let fields = fields.strip_prefix('{').unwrap_or(&fields);
    let head = format!("{{\n  \"sequence\": {number},\n  \"checksum\": \"{checksum}\",");
    let mut text = [head.as_bytes(), fields.as_bytes()].concat();
    let length = least.max((text.len() + 1).next_multiple_of(BLOCK));
    text.resize(length - 1, b' ');
    text.push(b'\n');
    Ok(text)
}

/// SHA-256 over a JSON text without the blanks between its tokens, hexadecimal: whoever digests a spec writes it so,
/// and a file is written for people too.
pub fn digest(text: &RawValue) -> String {
    format!("{:x}", Sha256::digest(compact(text.get())))
}

/// SHA-256 over a number and all of an envelope, hexadecimal, whatever blanks are between its tokens.
fn checksum(number: u64, envelope: &impl Serialize) -> serde_json::Result<String> {
    let text = compact(&serde_json::to_string(envelope)?);
    let hash = Sha256::digest(format!("{number}\n{text}"));
    Ok(format!("{hash:x}"))
}

/// A JSON text without the blanks between its tokens.
fn compact(text: &str) -> String {
    let (mut quoted, mut escaped) = (false, false);
    let keep = |c: &char| {
        match (quoted, *c) {
            _ if escaped => escaped = false,
            (true, '\\') => escaped = true,
            (_, '"') => quoted = !quoted,
            _ => {}
        }
        quoted || !matches!(c, ' ' | '\n' | '\r' | '\t')
    };
    text.chars().filter(keep).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_blanks_between_tokens_are_left_out() {
        let value = serde_json::json!({"a b": ["c \" d\\", 1.5, {"e\n": "\\\" f\t"}], "\\": null});
        let pretty = serde_json::to_string_pretty(&value).unwrap();
        assert_eq!(compact(&pretty), value.to_string());
    }
}
