//! A JSON client over one Unix socket.

use std::path::{Path, PathBuf};
use std::time::Duration;

use reqwest::{Method, RequestBuilder, Response};
use serde::{Serialize, de::DeserializeOwned};

use crate::problem::Problem;

/// Largest body of an answer that is read, in bytes.
pub const MAX_BODY: usize = 64 * 1024 * 1024;
/// Largest body of an error answer that is read, in bytes; the rest is left out.
const MAX_PROBLEM: usize = 1024 * 1024;

/// A request that failed.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// Nobody answered: no socket, refused, closed, or too late.
    #[error("{socket} does not answer: {reason}")]
    Unreachable {
        /// The socket.
        socket: PathBuf,
        /// Why.
        reason: String,
    },
    /// The server refused.
    #[error(transparent)]
    Problem(#[from] Problem),
    /// The answer is not what was expected: probably another version.
    #[error("the answer of {socket} cannot be understood: {reason}")]
    Protocol {
        /// The socket.
        socket: PathBuf,
        /// Why.
        reason: String,
    },
}

impl ClientError {
    /// The same, unless it says that the server has no such path: then that it is to be upgraded. `who`: the server
    /// (`agent`); for paths that not all versions have.
    #[must_use]
    pub fn or_upgrade(self, who: &str, path: &str) -> Self {
        match &self {
            Self::Problem(problem) if problem.status == 404 && problem.detail.contains(path) => {
                let detail = format!(
                    "the {who} is of an older version, which has no {path}: upgrade it, and start it again"
                );
                Problem::new(501, "upgrade", "not implemented", detail).into()
            }
            _ => self,
        }
    }
}

/// A client of one server.
#[derive(Debug, Clone)]
pub struct Client {
    socket: PathBuf,
    http: reqwest::Client,
    timeout: Duration,
}

impl Client {
    /// A client of the server that listens on a socket. Nothing is dialled yet.
    pub fn unix(socket: impl Into<PathBuf>, timeout: Duration) -> Result<Self, ClientError> {
        let socket = socket.into();
        let http = reqwest::Client::builder()
            .unix_socket(socket.as_path())
            .connect_timeout(timeout)
            .build()
            .map_err(|e| ClientError::Protocol {
                socket: socket.clone(),
                reason: e.to_string(),
            })?;
        Ok(Self {
            socket,
            http,
            timeout,
        })
    }

    /// The same client over the same connections, with another time-out for each request.
    #[must_use]
    pub fn within(&self, timeout: Duration) -> Self {
        Self {
            timeout,
            ..self.clone()
        }
    }

    /// The socket.
    pub fn socket(&self) -> &Path {
        &self.socket
    }

    /// Starts a request. `path` begins with a slash; its segments must be escaped with [`segment`].
    pub fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.http.request(method, format!("http://localhost{path}"))
    }

    /// GET, JSON back.
    pub async fn get<T: DeserializeOwned>(&self, path: &str) -> Result<T, ClientError> {
        self.json(self.request(Method::GET, path)).await
    }

    /// A request with a JSON body, JSON back.
    pub async fn send<B: Serialize + ?Sized, T: DeserializeOwned>(
        &self,
        method: Method,
        path: &str,
        body: &B,
    ) -> Result<T, ClientError> {
        self.json(self.request(method, path).json(body)).await
    }

    /// Sends with the client's time-out and decodes JSON.
    pub async fn json<T: DeserializeOwned>(
        &self,
        request: RequestBuilder,
    ) -> Result<T, ClientError> {
        let response = self.accept(request.timeout(self.timeout)).await?;
        self.decode(response).await
    }

    /// Sends and decodes JSON, however long that takes.
    pub async fn unhurried<T: DeserializeOwned>(
        &self,
        request: RequestBuilder,
    ) -> Result<T, ClientError> {
        let response = self.accept(request).await?;
        self.decode(response).await
    }

    /// Decodes the JSON of an accepted request, however long that takes to come.
    pub async fn decode<T: DeserializeOwned>(&self, response: Response) -> Result<T, ClientError> {
        let body = self.body(response).await?;
        serde_json::from_slice(&body).map_err(|e| self.protocol(&e))
    }

    /// Sends with the client's time-out and gives the body as text.
    pub async fn text(&self, request: RequestBuilder) -> Result<String, ClientError> {
        let response = self.accept(request.timeout(self.timeout)).await?;
        let body = self.body(response).await?;
        Ok(String::from_utf8_lossy(&body).into_owned())
    }

    /// A whole body; one above [`MAX_BODY`] is an error.
    async fn body(&self, response: Response) -> Result<Vec<u8>, ClientError> {
        let (body, whole) = self.read(response, MAX_BODY).await?;
        if whole {
            return Ok(body);
        }
        Err(ClientError::Protocol {
            socket: self.socket.clone(),
            reason: format!("it is longer than {MAX_BODY} bytes"),
        })
    }

    /// At most `limit` bytes of a body, and whether that was all.
    async fn read(
        &self,
        mut response: Response,
        limit: usize,
    ) -> Result<(Vec<u8>, bool), ClientError> {
        let mut body = Vec::new();
        while let Some(chunk) = response.chunk().await.map_err(|e| self.unreachable(&e))? {
            let room = limit - body.len();
            body.extend_from_slice(&chunk[..chunk.len().min(room)]);
            if chunk.len() > room {
                return Ok((body, false));
            }
        }
        Ok((body, true))
    }

    /// Sends and gives the response once its status is a success. Sets no time-out of its own, for streams.
    pub async fn accept(&self, request: RequestBuilder) -> Result<Response, ClientError> {
        let response = request.send().await.map_err(|e| self.unreachable(&e))?;
        let status = response.status();
        if status.is_success() {
            return Ok(response);
        }
        let (text, _) = self.read(response, MAX_PROBLEM).await?;
        Err(serde_json::from_slice::<Problem>(&text)
            .unwrap_or_else(|_| {
                let title = status.canonical_reason().unwrap_or("error");
                Problem::new(
                    status.as_u16(),
                    "http",
                    title,
                    String::from_utf8_lossy(&text).trim(),
                )
            })
            .into())
    }

    /// The error for a transport that failed, with its innermost cause.
    pub fn unreachable(&self, error: &dyn std::error::Error) -> ClientError {
        let mut reason = error;
        while let Some(source) = reason.source() {
            reason = source;
        }
        ClientError::Unreachable {
            socket: self.socket.clone(),
            reason: reason.to_string(),
        }
    }

    fn protocol(&self, error: &dyn std::error::Error) -> ClientError {
        ClientError::Protocol {
            socket: self.socket.clone(),
            reason: error.to_string(),
        }
    }
}

/// Escapes one segment of a path.
pub fn segment(text: &str) -> String {
    use std::fmt::Write;
    let mut out = String::with_capacity(text.len());
    for byte in text.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => {
                out.push(byte.into());
            }
            _ => {
                let _ = write!(out, "%{byte:02X}");
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_without_a_path_is_to_be_upgraded_and_other_refusals_stay() {
        let path = "/v1/components/A/ports/out/samples";
        let error = |detail: &str| ClientError::from(Problem::not_found(detail));
        let lacks = error(&format!("the agent has no {path}")).or_upgrade("agent", path);
        assert_eq!(
            lacks.to_string(),
            format!(
                "the agent is of an older version, which has no {path}: upgrade it, and start it again"
            )
        );
        let absent = error("node local has no component A").or_upgrade("agent", path);
        assert_eq!(absent.to_string(), "node local has no component A");
    }
}
