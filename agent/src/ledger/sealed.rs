//! A node spec together with the very text that its sender wrote. Its digest is over that text: a field that one side
//! knows and the other does not yet would change what each makes of the same spec.

use rts_agent_api::messages::{LedgerFence, NodeSpecEnvelope};
use rts_plan::desired::NodeSpec;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

use crate::folders::hex;

/// An envelope that was received or read. Fields of the spec that this version does not know are refused.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(try_from = "Text", into = "Text")]
pub(crate) struct Sealed {
    envelope: NodeSpecEnvelope,
    spec: Box<RawValue>,
}

/// An envelope whose spec is text.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Text {
    cluster_uid: String,
    epoch: u64,
    generation: u64,
    digest: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    take_over: Option<LedgerFence>,
    spec: Box<RawValue>,
}

/// A spec whose systems are text.
#[derive(Deserialize)]
struct Parts {
    #[serde(default)]
    systems: Vec<Box<RawValue>>,
}

impl Sealed {
    /// Seals an envelope as its sender would: by writing it.
    pub fn of(envelope: &NodeSpecEnvelope) -> Result<Self, serde_json::Error> {
        serde_json::from_str(&serde_json::to_string(envelope)?)
    }

    /// What it says.
    pub fn envelope(&self) -> &NodeSpecEnvelope {
        &self.envelope
    }

    /// True when the digest is the text's.
    pub fn is_whole(&self) -> bool {
        digest(&self.spec) == self.envelope.digest
    }

    /// System uid → digest of the text of the system's part.
    pub fn parts(&self) -> BTreeMap<String, String> {
        // It was read as a spec already.
        let parts = serde_json::from_str::<Parts>(self.spec.get());
        let texts = parts.map_or(Vec::new(), |parts| parts.systems);
        let systems = self.envelope.spec.systems.iter();
        systems
            .zip(&texts)
            .map(|(system, text)| (system.system.uid.clone(), digest(text)))
            .collect()
    }

    /// The same; how it came to be accepted is no part of it.
    pub fn accepted(mut self) -> Self {
        self.envelope.take_over = None;
        self
    }
}

impl TryFrom<Text> for Sealed {
    type Error = serde_json::Error;

    fn try_from(text: Text) -> Result<Self, Self::Error> {
        let spec: NodeSpec = serde_json::from_str(text.spec.get())?;
        Ok(Self {
            envelope: NodeSpecEnvelope {
                cluster_uid: text.cluster_uid,
                epoch: text.epoch,
                generation: text.generation,
                digest: text.digest,
                take_over: text.take_over,
                spec,
            },
            spec: text.spec,
        })
    }
}

impl From<Sealed> for Text {
    fn from(sealed: Sealed) -> Self {
        let Sealed { envelope, spec } = sealed;
        Self {
            cluster_uid: envelope.cluster_uid,
            epoch: envelope.epoch,
            generation: envelope.generation,
            digest: envelope.digest,
            take_over: envelope.take_over,
            spec,
        }
    }
}

/// SHA-256 over a JSON text without the blanks between its tokens, hexadecimal: whoever digests a spec writes it so,
/// and a file is written for people too.
fn digest(text: &RawValue) -> String {
    hex(&Sha256::digest(compact(text.get())))
}

/// SHA-256 over a number and all of an envelope, hexadecimal, whatever blanks are between its tokens.
pub(super) fn checksum(number: u64, sealed: &Sealed) -> Result<String, serde_json::Error> {
    let text = compact(&serde_json::to_string(sealed)?);
    Ok(hex(&Sha256::digest(format!("{number}\n{text}"))))
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
impl From<NodeSpecEnvelope> for Sealed {
    fn from(envelope: NodeSpecEnvelope) -> Self {
        Self::of(&envelope).unwrap()
    }
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
