//! Watching a kind: server-sent events `ADDED`, `MODIFIED`, `DELETED`, `BOOKMARK` with `id:` = resourceVersion.

use rts_http::lines::Lines;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use utoipa::ToSchema;

use crate::ClientError;

/// Kind of a watch event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "UPPERCASE")]
pub enum WatchType {
    /// A new object.
    Added,
    /// A changed object.
    Modified,
    /// An object that is gone; its last state.
    Deleted,
    /// No object: only the version up to which everything was sent.
    Bookmark,
}

/// Data of one server-sent event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct WatchEvent<T> {
    /// What happened.
    #[serde(rename = "type")]
    pub kind: WatchType,
    /// Version after it.
    pub resource_version: String,
    /// The object; none in a bookmark.
    #[serde(default = "none", skip_serializing_if = "Option::is_none")]
    pub object: Option<T>,
}

fn none<T>() -> Option<T> {
    None
}

/// A running watch.
pub struct Watch<T> {
    lines: Lines,
    socket: std::path::PathBuf,
    item: std::marker::PhantomData<T>,
}

impl<T: DeserializeOwned> Watch<T> {
    pub(crate) fn new(response: reqwest::Response, socket: std::path::PathBuf) -> Self {
        Self {
            lines: Lines::of(response),
            socket,
            item: std::marker::PhantomData,
        }
    }

    /// The next event; `None` when the server ended the stream. Comments (keep-alive) are passed over.
    pub async fn next(&mut self) -> Option<Result<WatchEvent<T>, ClientError>> {
        let mut data = String::new();
        loop {
            let line = match self.lines.next().await? {
                Ok(line) => line,
                Err(e) => {
                    let socket = self.socket.clone();
                    return Some(Err(ClientError::Unreachable {
                        socket,
                        reason: e.to_string(),
                    }));
                }
            };
            if let Some(part) = line.strip_prefix("data:") {
                data.push_str(part.trim_start());
            } else if line.is_empty() && !data.is_empty() {
                let socket = self.socket.clone();
                return Some(
                    serde_json::from_str(&data).map_err(|e| ClientError::Protocol {
                        socket,
                        reason: e.to_string(),
                    }),
                );
            }
        }
    }
}
