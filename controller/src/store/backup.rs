//! A backup: the whole store as one JSON document that says of itself what it is and whether it is whole.

use jiff::Timestamp;
use rts_controller_api::API_VERSION;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};

use super::{SCHEMA_VERSION, State};

/// What `kind` says.
const KIND: &str = "Backup";
/// Largest backup that is read, in bytes.
pub const MAX_BYTES: usize = 256 * 1024 * 1024;

/// The document.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Backup {
    api_version: String,
    kind: String,
    schema_version: u32,
    /// When it was made.
    pub created: Timestamp,
    /// Version of the program that made it.
    pub program: String,
    sha256: String,
    content: Box<RawValue>,
}

/// The head of a document, to tell what it is before it is understood.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    #[serde(default)]
    api_version: String,
    #[serde(default)]
    kind: String,
    #[serde(default)]
    schema_version: u32,
}

/// A file that is no usable backup.
#[derive(Debug, thiserror::Error)]
pub enum BackupError {
    /// It is no JSON document, or breaks off.
    #[error("it is damaged or no backup at all: {0}")]
    NoDocument(#[source] serde_json::Error),
    /// It is a document of something else.
    #[error(
        "it is no backup of a controller: apiVersion is {api_version:?} and kind {kind:?}, where {API_VERSION:?} and {KIND:?} are wanted"
    )]
    Foreign {
        /// What it says.
        api_version: String,
        /// What it says.
        kind: String,
    },
    /// A later program made it.
    #[error(
        "it has schema version {found}, and this program knows {SCHEMA_VERSION}: upgrade rtsctl"
    )]
    Future {
        /// Its version.
        found: u32,
    },
    /// It was changed since it was made.
    #[error("it is damaged: its contents do not fit its checksum")]
    Changed,
    /// Its contents make no sense, though its checksum fits.
    #[error("its contents cannot be understood")]
    Contents(#[source] serde_json::Error),
    /// It is too large to be one.
    #[error("it has {0} bytes; a backup has at most {MAX_BYTES}")]
    TooLarge(usize),
}

impl Backup {
    /// Of a state.
    pub fn of(state: &State, created: Timestamp) -> Result<Self, serde_json::Error> {
        let content = serde_json::value::to_raw_value(state)?;
        Ok(Self {
            api_version: API_VERSION.to_owned(),
            kind: KIND.to_owned(),
            schema_version: SCHEMA_VERSION,
            created,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            sha256: sha256(content.get()),
            content,
        })
    }

    /// Reads a document and checks it as a whole.
    pub fn read(bytes: &[u8]) -> Result<(Self, State), BackupError> {
        if bytes.len() > MAX_BYTES {
            return Err(BackupError::TooLarge(bytes.len()));
        }
        let head: Head = serde_json::from_slice(bytes).map_err(BackupError::NoDocument)?;
        if head.api_version != API_VERSION || head.kind != KIND {
            let Head {
                api_version, kind, ..
            } = head;
            return Err(BackupError::Foreign { api_version, kind });
        }
        if head.schema_version > SCHEMA_VERSION {
            let found = head.schema_version;
            return Err(BackupError::Future { found });
        }
        let backup: Self = serde_json::from_slice(bytes).map_err(BackupError::NoDocument)?;
        if sha256(backup.content.get()) != backup.sha256 {
            return Err(BackupError::Changed);
        }
        let state = serde_json::from_str(backup.content.get()).map_err(BackupError::Contents)?;
        Ok((backup, state))
    }
}

fn sha256(text: &str) -> String {
    let sum = Sha256::digest(text.as_bytes());
    sum.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document() -> String {
        let state = State {
            cluster_uid: "c".into(),
            epoch: 3,
            ..State::default()
        };
        serde_json::to_string(&Backup::of(&state, Timestamp::UNIX_EPOCH).unwrap()).unwrap()
    }

    #[test]
    fn a_backup_is_read_as_it_was_made() {
        let (backup, state) = Backup::read(document().as_bytes()).unwrap();
        assert_eq!((state.epoch, backup.schema_version), (3, SCHEMA_VERSION));
    }

    #[test]
    fn what_is_no_whole_backup_is_refused() {
        let good = document();
        let half = &good[..good.len() / 2];
        let texts = [
            half.to_owned(),
            good.replace("\"epoch\":3", "\"epoch\":4"),
            good.replace("\"Backup\"", "\"System\""),
            good.replace("\"schemaVersion\":3", "\"schemaVersion\":99"),
            String::new(),
        ];
        let said: Vec<String> = texts
            .iter()
            .map(|text| Backup::read(text.as_bytes()).unwrap_err().to_string())
            .collect();
        insta::assert_snapshot!(said.join("\n"), @r#"
        it is damaged or no backup at all: EOF while parsing a string at line 1 column 140
        it is damaged: its contents do not fit its checksum
        it is no backup of a controller: apiVersion is "rtsctl.dev/v1" and kind "System", where "rtsctl.dev/v1" and "Backup" are wanted
        it has schema version 99, and this program knows 3: upgrade rtsctl
        it is damaged or no backup at all: EOF while parsing a value at line 1 column 0
        "#);
    }
}
