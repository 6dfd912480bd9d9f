//! Listening on Unix sockets: mode 0600, peer credentials for every handler, orderly shutdown.

mod handlers;
mod socket;

use std::convert::Infallible;
use std::future::Future;
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use axum::Router;
use axum::extract::connect_info::{ConnectInfo, Connected};
use axum::extract::rejection::JsonRejection;
use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::{HeaderValue, StatusCode, header, request::Parts};
use axum::response::{IntoResponse, Response};
use axum::serve::IncomingStream;
use serde::de::DeserializeOwned;
use tokio::net::{UnixListener, UnixStream};

use crate::problem::{PROBLEM_JSON, Problem};

pub use socket::serve_at;

/// Longest path of a Unix socket on Linux, in bytes.
pub const MAX_SOCKET_PATH: usize = 107;

/// Binds a socket with mode 0600. What lies at the path is removed first: the caller must own it (hold its lock).
pub fn bind(path: &Path) -> io::Result<UnixListener> {
    if path.as_os_str().len() > MAX_SOCKET_PATH {
        let message = format!(
            "{} has {} bytes; a Unix socket path may have {MAX_SOCKET_PATH}: set RTSCTL_HOME to a shorter folder",
            path.display(),
            path.as_os_str().len()
        );
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
        _ => {}
    }
    let listener = UnixListener::bind(path)?;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600))?;
    Ok(listener)
}

/// Serves until `shutdown` is done, then lets open requests end.
pub async fn serve(
    listener: UnixListener,
    router: Router,
    shutdown: impl Future<Output = ()> + Send + 'static,
) -> io::Result<()> {
    let service = router.into_make_service_with_connect_info::<Peer>();
    axum::serve(listener, service)
        .with_graceful_shutdown(shutdown)
        .await
}

/// Credentials of the process at the other end, as the kernel gave them when it connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Peer {
    uid: Option<u32>,
    pid: Option<i32>,
}

impl Connected<IncomingStream<'_, UnixListener>> for Peer {
    fn connect_info(stream: IncomingStream<'_, UnixListener>) -> Self {
        Self::of(stream.io())
    }
}

impl Peer {
    fn of(stream: &UnixStream) -> Self {
        let credentials = stream.peer_cred().ok();
        Self {
            uid: credentials.map(|c| c.uid()),
            pid: credentials.and_then(|c| c.pid()),
        }
    }
}

/// Who sent a request. Only the user that runs the server, and root, get past this extractor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Principal {
    /// User id.
    pub uid: u32,
    /// Process id, when the kernel knows it.
    pub pid: Option<i32>,
}

impl<S: Sync> FromRequestParts<S> for Principal {
    type Rejection = ProblemResponse;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Self::Rejection> {
        let peer = parts
            .extensions
            .get::<ConnectInfo<Peer>>()
            .map(|info| info.0);
        let own = rustix::process::geteuid().as_raw();
        match peer {
            Some(Peer {
                uid: Some(uid),
                pid,
            }) if uid == own || uid == 0 => Ok(Self { uid, pid }),
            _ => Err(Problem::new(
                403,
                "forbidden",
                "forbidden",
                "only the user that runs this server may use it",
            )
            .into()),
        }
    }
}

/// A problem as a response; what handlers return as their error.
#[derive(Debug, Clone)]
pub struct ProblemResponse(pub Problem);

impl From<Problem> for ProblemResponse {
    fn from(problem: Problem) -> Self {
        Self(problem)
    }
}

impl From<Infallible> for ProblemResponse {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl IntoResponse for ProblemResponse {
    fn into_response(self) -> Response {
        let status =
            StatusCode::from_u16(self.0.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, axum::Json(self.0)).into_response();
        response
            .headers_mut()
            .insert(header::CONTENT_TYPE, HeaderValue::from_static(PROBLEM_JSON));
        response
    }
}

/// A JSON body whose faults are answered with a problem document.
#[derive(Debug, Clone)]
pub struct Json<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for Json<T> {
    type Rejection = ProblemResponse;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        match axum::Json::<T>::from_request(request, state).await {
            Ok(axum::Json(value)) => Ok(Self(value)),
            Err(JsonRejection::JsonDataError(e)) => {
                Err(Problem::invalid("invalid-body", e.body_text()).into())
            }
            Err(e) => Err(Problem::new(
                e.status().as_u16(),
                "bad-request",
                "the request cannot be understood",
                e.body_text(),
            )
            .into()),
        }
    }
}

impl<T: serde::Serialize> IntoResponse for Json<T> {
    fn into_response(self) -> Response {
        axum::Json(self.0).into_response()
    }
}
