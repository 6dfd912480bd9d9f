//! A listener that keeps its path: when its socket file is deleted (a cleaner of old files, a careless hand), it binds
//! anew within a second or two.

use std::future::Future;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use axum::Router;
use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use tokio::net::{UnixListener, UnixStream, unix::SocketAddr};
use tokio::time::{Interval, MissedTickBehavior, interval, sleep, timeout};

use super::{Peer, bind};

/// How often the path is looked at.
const LOOK: Duration = Duration::from_secs(1);
/// How long whoever has taken the path may need to accept a connection.
const RIVAL: Duration = Duration::from_millis(200);
/// Pause after a connection could not be accepted (no file descriptor is left).
const PAUSE: Duration = Duration::from_millis(100);

/// Binds a socket as [`bind`] does, at once, and gives the server to be awaited or spawned. It binds anew when the path
/// no longer is its socket, and removes the path when it ends.
pub fn serve_at(
    path: &Path,
    router: Router,
    shutdown: impl Future<Output = ()> + Send + 'static,
) -> io::Result<impl Future<Output = io::Result<()>> + Send + 'static> {
    let listener = Keeping::bind(path)?;
    let service = router.into_make_service_with_connect_info::<Peer>();
    Ok(async move {
        axum::serve(listener, service)
            .with_graceful_shutdown(shutdown)
            .await
    })
}

/// The listener.
struct Keeping {
    path: PathBuf,
    listener: UnixListener,
    /// Device and inode of the socket file.
    file: (u64, u64),
    look: Interval,
    /// What was complained about last, so that it is said once.
    complaint: String,
}

impl Keeping {
    fn bind(path: &Path) -> io::Result<Self> {
        let listener = bind(path)?;
        let mut look = interval(LOOK);
        look.set_missed_tick_behavior(MissedTickBehavior::Delay);
        Ok(Self {
            path: path.to_owned(),
            file: inode(path)?,
            listener,
            look,
            complaint: String::new(),
        })
    }

    fn is_ours(&self) -> bool {
        inode(&self.path).is_ok_and(|file| file == self.file)
    }

    async fn repair(&mut self) {
        if self.is_ours() {
            return;
        }
        // Two servers must not take the path from each other again and again.
        let rival = timeout(RIVAL, UnixStream::connect(&self.path)).await;
        if matches!(rival, Ok(Ok(_)) | Err(_)) {
            self.complain("another program serves there".to_owned());
            return;
        }
        match bind(&self.path).and_then(|listener| Ok((listener, inode(&self.path)?))) {
            Ok((listener, file)) => {
                self.listener = listener;
                self.file = file;
                self.complaint.clear();
                let path = self.path.display();
                tracing::warn!("{path} was gone or replaced; it was bound anew");
            }
            Err(error) => self.complain(error.to_string()),
        }
    }

    fn complain(&mut self, reason: String) {
        if reason != self.complaint {
            let path = self.path.display();
            tracing::error!("{path} is lost, nobody can connect any more: {reason}");
            self.complaint = reason;
        }
    }
}

impl Drop for Keeping {
    fn drop(&mut self) {
        if self.is_ours() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

impl Listener for Keeping {
    type Io = UnixStream;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, Self::Addr) {
        loop {
            tokio::select! {
                accepted = self.listener.accept() => match accepted {
                    Ok(connection) => return connection,
                    Err(error) => {
                        tracing::debug!("cannot accept a connection: {error}");
                        sleep(PAUSE).await;
                    }
                },
                _ = self.look.tick() => self.repair().await,
            }
        }
    }

    fn local_addr(&self) -> io::Result<Self::Addr> {
        self.listener.local_addr()
    }
}

impl Connected<IncomingStream<'_, Keeping>> for Peer {
    fn connect_info(stream: IncomingStream<'_, Keeping>) -> Self {
        Self::of(stream.io())
    }
}

fn inode(path: &Path) -> io::Result<(u64, u64)> {
    let file = std::fs::symlink_metadata(path)?;
    Ok((file.dev(), file.ino()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::client::Client;
    use crate::server::Principal;
    use axum::routing::get;
    use tokio::sync::oneshot;

    async fn until_answered(path: &Path) {
        let client = Client::unix(path, Duration::from_secs(5)).unwrap();
        let end = tokio::time::Instant::now() + Duration::from_secs(10);
        while client.get::<String>("/").await.is_err() {
            assert!(tokio::time::Instant::now() < end, "nobody answers");
            sleep(Duration::from_millis(20)).await;
        }
    }

    #[tokio::test]
    async fn a_deleted_socket_is_bound_anew_and_removed_in_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.sock");
        let router = Router::new().route("/", get(|_: Principal| async { "\"here\"" }));
        let (stop, stopped) = oneshot::channel::<()>();
        let server = serve_at(&path, router, async {
            let _ = stopped.await;
        });
        let server = tokio::spawn(server.unwrap());
        until_answered(&path).await;
        std::fs::remove_file(&path).unwrap();
        until_answered(&path).await;
        // Another socket that nobody serves.
        std::fs::remove_file(&path).unwrap();
        drop(std::os::unix::net::UnixListener::bind(&path).unwrap());
        until_answered(&path).await;
        stop.send(()).unwrap();
        server.await.unwrap().unwrap();
        assert!(!path.exists());
    }

    #[tokio::test]
    async fn bodies_without_end_are_not_read_to_their_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.sock");
        let endless = || {
            let chunk = bytes::Bytes::from(vec![b'x'; 1024 * 1024]);
            let chunks =
                futures_util::stream::repeat_with(move || Ok::<_, io::Error>(chunk.clone()));
            axum::body::Body::from_stream(chunks)
        };
        let router = Router::new()
            .route("/", get(move || async move { endless() }))
            .route(
                "/bad",
                get(move || async move { (axum::http::StatusCode::IM_A_TEAPOT, endless()) }),
            );
        tokio::spawn(serve_at(&path, router, std::future::pending()).unwrap());
        let client = Client::unix(&path, Duration::from_secs(60)).unwrap();
        let error = client.get::<String>("/").await.unwrap_err();
        assert!(error.to_string().contains("longer than"), "{error}");
        let error = client.get::<String>("/bad").await.unwrap_err();
        let crate::client::ClientError::Problem(problem) = error else {
            panic!("{error}");
        };
        assert_eq!((problem.status, problem.detail.len()), (418, 1024 * 1024));
    }

    #[tokio::test]
    async fn a_path_that_another_server_has_taken_is_left_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.sock");
        let mut keeping = Keeping::bind(&path).unwrap();
        let rival = bind(&path).unwrap();
        keeping.repair().await;
        assert!(!keeping.is_ours());
        drop(keeping);
        assert!(path.exists());
        drop(rival);
    }
}
