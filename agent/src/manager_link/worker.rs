//! The task behind a link: greets, writes requests, reads answers, and connects anew.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use rts_manager_api::control::{FromManager, Greeting, Hello};
use rts_manager_api::frame::{self, FrameError};
use rts_manager_api::{PROTOCOL_VERSION, speaks};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, sleep, sleep_until, timeout, timeout_at};

use super::pending::{Call, Pending, settle};
use super::{Greeted, LinkError, OnChanged};
use crate::machine::{Control, Machine};

/// Bound on connecting and greeting.
const GREETING: Duration = Duration::from_secs(5);
/// For what was answered before a connection could no longer be written to.
const LAST_ANSWERS: Duration = Duration::from_millis(100);
/// Most requests that are written together.
const AT_ONCE: usize = 64;
/// First and longest pause between two attempts to connect.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(50), Duration::from_secs(2));

/// Serves a link.
pub(super) struct Worker {
    pub manager: String,
    pub incarnation: String,
    /// Machine and run folder.
    pub place: (Arc<dyn Machine>, PathBuf),
    pub queue: mpsc::Receiver<Call>,
    pub greeted: watch::Sender<Option<Greeted>>,
    pub pending: Pending,
    pub on_changed: OnChanged,
    /// The version for which it was refused last.
    pub refused: Option<u32>,
}

impl Worker {
    /// Serves one connection after the other until the link is dropped.
    pub async fn run(mut self, mut first: Option<Box<dyn Control>>) {
        let mut pause = BACK_OFF.0;
        loop {
            match self.connect(first.take()).await {
                Ok((stream, version)) => {
                    pause = BACK_OFF.0;
                    let error = self.serve(stream, version).await;
                    tracing::debug!(manager = self.manager, "connection ended: {error}");
                }
                Err(e) => tracing::debug!(manager = self.manager, "cannot connect: {e}"),
            }
            let manager = self.manager.clone();
            self.pending.fail(&LinkError::Lost { manager });
            if self.queue.is_closed() {
                return;
            }
            self.rest(pause).await;
            pause = (pause * 2).min(BACK_OFF.1);
        }
    }

    /// Waits. Meanwhile calls to a manager of a wrong version are told so; others wait for the connection.
    async fn rest(&mut self, pause: Duration) {
        let Some(theirs) = self.refused else {
            return sleep(pause).await;
        };
        let end = Instant::now() + pause;
        while let Ok(Some(call)) = timeout_at(end, self.queue.recv()).await {
            let manager = self.manager.clone();
            // The caller may have given up.
            let _ = call
                .answer
                .send(Err(LinkError::Version { manager, theirs }));
        }
        sleep_until(end).await;
    }

    async fn connect(
        &mut self,
        first: Option<Box<dyn Control>>,
    ) -> Result<(BufReader<Box<dyn Control>>, u32), FrameError> {
        let greet = async {
            let mut stream = match first {
                Some(stream) => stream,
                None => self.place.0.connect(&self.place.1).await?,
            };
            let greeting = Greeting::Control {
                version: PROTOCOL_VERSION,
            };
            stream.write_all(&frame::encode(&greeting)?).await?;
            let mut stream = BufReader::new(stream);
            let hello: Hello = read(&mut stream).await?;
            Ok::<_, FrameError>((stream, hello))
        };
        let (stream, hello) = timeout(GREETING, greet)
            .await
            .map_err(std::io::Error::from)??;
        self.check(&hello)?;
        let version = hello.version;
        self.greeted.send_replace(Some(Ok(hello)));
        Ok((stream, version))
    }

    fn check(&mut self, hello: &Hello) -> Result<(), FrameError> {
        if hello.incarnation != self.incarnation {
            let wrong = format!("it is another start: {}", hello.incarnation);
            return Err(std::io::Error::other(wrong).into());
        }
        let theirs = hello.version;
        if speaks(theirs).is_ok() {
            self.refused = None;
            return Ok(());
        }
        let manager = self.manager.clone();
        let error = LinkError::Version { manager, theirs };
        // It is asked again and again; that is told once.
        if self.refused.replace(theirs) != Some(theirs) {
            tracing::error!("{error}");
            self.greeted.send_replace(Some(Err(error.clone())));
        }
        Err(std::io::Error::other(error).into())
    }

    /// Reads and writes at the same time, so that neither side can block the other. Returns why it ended.
    async fn serve(&mut self, stream: BufReader<Box<dyn Control>>, version: u32) -> FrameError {
        let (mut from, mut to) = tokio::io::split(stream);
        let waiting = self.pending.waiting.clone();
        let on_changed = self.on_changed.clone();
        let reading = async {
            loop {
                match read::<FromManager>(&mut from).await {
                    Ok(FromManager::Response(response)) => settle(&waiting, response),
                    Ok(FromManager::Changed(changed)) => on_changed(changed),
                    Err(e) => return e,
                }
            }
        };
        let writing = async {
            let mut calls = Vec::new();
            let mut bytes = Vec::new();
            while self.queue.recv_many(&mut calls, AT_ONCE).await > 0 {
                // What is asked at once goes out at once: the manager is woken once for all of it.
                let requests = calls.drain(..);
                bytes.extend(
                    requests
                        .flat_map(|call| self.pending.note(call, version))
                        .flatten(),
                );
                if let Err(e) = to.write_all(&bytes).await {
                    return FrameError::from(e);
                }
                if let Err(e) = to.flush().await {
                    return FrameError::from(e);
                }
                bytes.clear();
            }
            FrameError::Closed
        };
        tokio::pin!(reading, writing);
        // Those who call wait for answers: calls come to an end where none are read, answers may not.
        let error = tokio::select! {
            biased;
            error = &mut writing => error,
            error = &mut reading => return error,
        };
        // A manager that ends has answered before: what lies there unread is an answer still.
        let _ = timeout(LAST_ANSWERS, reading).await;
        error
    }
}

async fn read<T: serde::de::DeserializeOwned>(
    from: &mut (impl AsyncRead + Unpin),
) -> Result<T, FrameError> {
    let mut header = [0; 4];
    from.read_exact(&mut header).await?;
    let mut body = vec![0; frame::length(header)?];
    from.read_exact(&mut body).await?;
    frame::decode(&body)
}
