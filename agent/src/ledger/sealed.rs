//! A node spec together with the very text that its sender wrote. Its digest is over that text: a field that one side
//! knows and the other does not yet would change what each makes of the same spec.

use rts_agent_api::messages::{LedgerFence, NodeSpecEnvelope};
use rts_plan::desired::NodeSpec;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::collections::BTreeMap;

use super::text::{Text, digest};

/// An envelope that was received or read. Fields of the spec that this version does not know are refused.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(try_from = "Text<LedgerFence>", into = "Text<LedgerFence>")]
pub(crate) struct Sealed {
    envelope: NodeSpecEnvelope,
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

impl TryFrom<Text<LedgerFence>> for Sealed {
    type Error = serde_json::Error;

    fn try_from(text: Text<LedgerFence>) -> Result<Self, Self::Error> {
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

impl From<Sealed> for Text<LedgerFence> {
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

#[cfg(test)]
impl From<NodeSpecEnvelope> for Sealed {
    fn from(envelope: NodeSpecEnvelope) -> Self {
        Self::of(&envelope).unwrap()
    }
}
