//! Plans in files: what `plan --out` writes and `apply` takes.

use std::path::Path;

use rts_controller_api::requests::{ApplyRequest, Expect, PlanResult};
use rts_plan::plan::Plan;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::error::CliError;
use crate::input::MAX_FILE;
use crate::save::replace;

const API_VERSION: &str = "rtsctl.dev/v1";
const KIND: &str = "Plan";

/// How far into a file its kind is looked for when it is no JSON as a whole, in bytes.
const HEAD: usize = 256;

/// A plan in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SavedPlan {
    api_version: String,
    kind: String,
    metadata: Metadata,
    /// What was planned, without expectations.
    pub request: ApplyRequest,
    /// What must not have changed since.
    pub index: u64,
    /// What the plan must still be.
    pub digest: String,
    /// What would be done.
    pub plan: Plan,
    /// Remarks about the system.
    #[serde(default)]
    pub notes: Vec<String>,
    /// SHA-256 of all the rest: what is read is what was written.
    checksum: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Metadata {
    name: String,
}

/// As much of a file as tells what it is.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    api_version: Option<String>,
    kind: Option<String>,
    changes: Option<IgnoredAny>,
    steps: Option<IgnoredAny>,
}

impl SavedPlan {
    /// Of an answer to a request.
    pub fn of(request: &ApplyRequest, result: &PlanResult) -> Self {
        let mut saved = Self {
            api_version: API_VERSION.to_owned(),
            kind: KIND.to_owned(),
            metadata: Metadata {
                name: request.spec.name.clone(),
            },
            request: ApplyRequest {
                expect: Expect::default(),
                ..request.clone()
            },
            index: result.index,
            digest: result.digest.clone(),
            plan: result.plan.clone(),
            notes: result.notes.clone(),
            checksum: String::new(),
        };
        saved.checksum = checksum(&json!(saved));
        saved
    }

    /// The request, on the terms that nothing has changed since.
    pub fn request(&self) -> ApplyRequest {
        ApplyRequest {
            expect: Expect {
                index: Some(self.index),
                digest: Some(self.digest.clone()).filter(|digest| !digest.is_empty()),
                no_restart: false,
                max_stand_ins: None,
            },
            ..self.request.clone()
        }
    }

    /// As the controller answered.
    pub fn result(&self) -> PlanResult {
        PlanResult {
            plan: self.plan.clone(),
            notes: self.notes.clone(),
            index: self.index,
            digest: self.digest.clone(),
        }
    }

    /// The plan in a file, which is known by its content. None for any other file.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Option<Self>, CliError> {
        let failed = |reason: String, help: Option<&str>| CliError::SavedPlan {
            file: file.to_owned(),
            reason,
            help: help.map(str::to_owned),
        };
        let start = bytes.trim_ascii_start();
        if !start.starts_with(b"{") {
            return Ok(None);
        }
        let head: Head = match serde_json::from_slice(start) {
            Ok(head) => head,
            Err(e) if is_headed(start) => {
                let reason = format!("it is cut off or damaged: {e}");
                return Err(failed(reason, Some(AGAIN)));
            }
            Err(_) => return Ok(None),
        };
        if head.kind.is_none() && head.changes.is_some() && head.steps.is_some() {
            let reason = "it was printed for scripts (`-o json`) and has no request".to_owned();
            return Err(failed(reason, Some(AGAIN)));
        }
        if head.kind.as_deref() != Some(KIND) {
            return Ok(None);
        }
        match head.api_version.as_deref() {
            Some(API_VERSION) => {}
            other => {
                let other = other.unwrap_or("none");
                let reason =
                    format!("its apiVersion is {other}, and this program knows {API_VERSION}");
                return Err(failed(reason, Some(OTHER_VERSION)));
            }
        }
        let damaged = |e| {
            let reason = format!("it is damaged, or of another version: {e}");
            failed(reason, Some(AGAIN))
        };
        let value: Value = serde_json::from_slice(start).map_err(damaged)?;
        let read: Self = serde_json::from_slice(start).map_err(damaged)?;
        if read.checksum != checksum(&value) {
            let reason = "it was changed since it was saved".to_owned();
            return Err(failed(reason, Some(AGAIN)));
        }
        Ok(Some(read))
    }

    /// Writes it as a whole, for its owner alone. What is there is replaced only if it is a plan, or empty.
    pub fn write(&self, path: &Path) -> Result<(), CliError> {
        let failed = |source| CliError::Write {
            path: path.to_owned(),
            source,
        };
        may_replace(path)?;
        let mut bytes = serde_json::to_vec(self).map_err(|e| failed(e.into()))?;
        bytes.push(b'\n');
        if bytes.len() as u64 > MAX_FILE {
            let text =
                format!("the plan has more than {MAX_FILE} bytes, which is more than is read");
            return Err(failed(std::io::Error::other(text)));
        }
        replace(path, &bytes, 0o600).map_err(failed)
    }
}

/// Of a document without its checksum, however its text is laid out: names are sorted.
fn checksum(document: &Value) -> String {
    let mut rest = document.clone();
    if let Some(fields) = rest.as_object_mut() {
        fields.remove("checksum");
    }
    let digest = Sha256::digest(rest.to_string());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

const AGAIN: &str = "plan again with `rtsctl plan FILE --out PLAN`";
const OTHER_VERSION: &str = "use the rtsctl that wrote it, or plan again with this one";

/// What is no JSON as a whole begins as a saved plan does.
fn is_headed(bytes: &[u8]) -> bool {
    let head = bytes.iter().take(HEAD).filter(|b| !b.is_ascii_whitespace());
    let head: Vec<u8> = head.copied().collect();
    let mark = br#""kind":"Plan""#;
    head.windows(mark.len()).any(|part| part == mark)
}

/// Refuses to destroy what is no plan.
fn may_replace(path: &Path) -> Result<(), CliError> {
    let refused = |what: &str| {
        let text = format!("{} exists and {what}: it is not replaced", path.display());
        CliError::usage_help(text, "name another file")
    };
    let failed = |source| CliError::Read {
        path: path.to_owned(),
        source,
    };
    if path.as_os_str() == "-" {
        return Err(CliError::usage(
            "a plan is saved in a file, not on standard output",
        ));
    }
    match std::fs::symlink_metadata(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(failed(e)),
        Ok(meta) if !meta.is_file() => return Err(refused("is no ordinary file")),
        Ok(meta) if meta.len() == 0 => return Ok(()),
        Ok(meta) if meta.len() > MAX_FILE => return Err(refused("is no saved plan")),
        Ok(_) => {}
    }
    let bytes = std::fs::read(path).map_err(failed)?;
    let start = bytes.trim_ascii_start();
    if start.starts_with(b"{") && is_headed(start) {
        return Ok(());
    }
    Err(refused("is no saved plan"))
}

#[cfg(test)]
mod tests;
