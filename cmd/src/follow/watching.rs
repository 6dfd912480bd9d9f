//! A watch that goes on: across a stream that breaks, a version that is too old, and a controller that restarts.

use std::time::Duration;

use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Kind, List};
use rts_controller_api::watch::{Watch, WatchType};
use serde::de::DeserializeOwned;
use tokio::time::{sleep, timeout};

/// First pause before another try; it doubles.
const FIRST: Duration = Duration::from_millis(200);
/// Longest pause.
const LONGEST: Duration = Duration::from_secs(5);
/// How long the controller may take to open a watch.
const OPEN: Duration = Duration::from_secs(10);
/// A watch without a word for so long is broken: a bookmark comes each 10 s.
const SILENCE: Duration = Duration::from_secs(30);

/// What a watch tells.
#[derive(Debug)]
pub enum News<T> {
    /// All objects as they are: at the start, and again when changes may have been missed.
    All(List<T>),
    /// One object was added, changed or deleted.
    Change(WatchType, T),
    /// The controller does not answer; told once, trying goes on.
    Silent(ClientError),
    /// It answers again.
    Back,
}

/// The objects of a kind as they change, for as long as they are asked for.
pub struct Watching<T> {
    controller: Controller,
    kind: Kind,
    /// Everything up to this version was told; none: all must be listed.
    version: Option<String>,
    watch: Option<Watch<T>>,
    /// Pause before the next try, while the controller is silent.
    pause: Option<Duration>,
    pending: Option<News<T>>,
}

impl<T: DeserializeOwned> Watching<T> {
    /// From a version that is known, or from a list.
    pub fn new(controller: &Controller, kind: Kind, version: Option<String>) -> Self {
        Self {
            controller: controller.clone(),
            kind,
            version,
            watch: None,
            pause: None,
            pending: None,
        }
    }

    /// The next news. Fails only when another try would fail as well.
    pub async fn next(&mut self) -> Result<News<T>, ClientError> {
        if let Some(news) = self.pending.take() {
            return Ok(news);
        }
        loop {
            if let Some(pause) = self.pause {
                sleep(pause).await;
            }
            match self.step().await {
                Ok(news) => {
                    let back = self.pause.take().map(|_| News::Back);
                    self.pending = news;
                    if let Some(news) = back.or_else(|| self.pending.take()) {
                        return Ok(news);
                    }
                }
                Err(e) if is_final(&e) => return Err(e),
                Err(e) => {
                    let before = self.pause;
                    self.pause = Some(before.map_or(FIRST, |pause| (pause * 2).min(LONGEST)));
                    if before.is_none() {
                        return Ok(News::Silent(e));
                    }
                }
            }
        }
    }

    /// Lists, opens the watch, or waits for what it tells. None when there is no news yet.
    async fn step(&mut self) -> Result<Option<News<T>>, ClientError> {
        let Some(version) = &self.version else {
            let list: List<T> = self.controller.list(self.kind).await?;
            self.version = Some(list.metadata.resource_version.clone());
            return Ok(Some(News::All(list)));
        };
        let Some(watch) = &mut self.watch else {
            let open = timeout(OPEN, self.controller.watch(self.kind, version));
            match open.await {
                Ok(Ok(watch)) => self.watch = Some(watch),
                // Too old, or of another store.
                Ok(Err(ClientError::Problem(problem))) if problem.status == 410 => {
                    self.version = None;
                }
                Ok(Err(e)) => return Err(e),
                Err(_) => return Err(self.controller.silent("it does not open a watch")),
            }
            return Ok(None);
        };
        match timeout(SILENCE, watch.next()).await {
            Ok(Some(Ok(event))) => {
                self.version = Some(event.resource_version);
                Ok(event.object.map(|object| News::Change(event.kind, object)))
            }
            Ok(Some(Err(e @ ClientError::Protocol { .. }))) => Err(e),
            // Ended, broken or silent: opened again, after a breath.
            _ => {
                self.watch = None;
                sleep(FIRST).await;
                Ok(None)
            }
        }
    }
}

/// Trying again would not help.
fn is_final(error: &ClientError) -> bool {
    match error {
        ClientError::Unreachable { .. } => false,
        ClientError::Protocol { .. } => true,
        ClientError::Problem(problem) => matches!(problem.status, 400..500) && !problem.retryable,
    }
}
