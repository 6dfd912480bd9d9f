//! A control connection to a manager: concurrent requests with deadlines, pushed events, and a new connection when it
//! is lost while the process lives.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::control::{
    Changed, Failure, FromManager, Greeting, Hello, Request, RequestBody, Response, ResponseBody,
};
use rts_manager_api::frame::{self, FrameError};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::UnixStream;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep, timeout};

use crate::events::lock;

/// What a late manager gets beyond its deadline before it counts as silent.
pub(crate) const GRACE: Duration = Duration::from_secs(1);
/// Bound on connecting and greeting.
const GREETING: Duration = Duration::from_secs(5);
/// First and longest pause between two attempts to connect.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(50), Duration::from_secs(2));
/// Most requests that wait for the connection.
const QUEUE: usize = 256;

/// A request that failed.
#[derive(Debug, Clone, thiserror::Error)]
pub(crate) enum LinkError {
    /// The manager refused.
    #[error(transparent)]
    Refused(#[from] Failure),
    /// No answer in time.
    #[error("manager {manager} did not answer within {} ms", after.as_millis())]
    Silent {
        /// Display name.
        manager: String,
        /// How long was waited.
        after: Duration,
    },
    /// The connection was lost before the answer came.
    #[error("the connection to manager {manager} was lost before it answered")]
    Lost {
        /// Display name.
        manager: String,
    },
    /// It answered with something else.
    #[error(
        "manager {manager} gave an answer that does not fit the request; it may have another version"
    )]
    Unexpected {
        /// Display name.
        manager: String,
    },
}

struct Call {
    body: RequestBody,
    deadline: Instant,
    answer: oneshot::Sender<Result<ResponseBody, LinkError>>,
}

/// Gets what a manager pushes.
pub(crate) type OnChanged = Arc<dyn Fn(Changed) + Send + Sync>;

/// A link to one start of a manager. Ends when dropped.
#[derive(Debug)]
pub(crate) struct Link {
    manager: String,
    calls: mpsc::Sender<Call>,
    hello: watch::Receiver<Option<Hello>>,
    task: AbortHandle,
}

impl Drop for Link {
    fn drop(&mut self) {
        self.close();
    }
}

impl Link {
    /// Starts a link. `first` is a connection that is open already; later ones are made to `socket`. A manager with
    /// another incarnation is not spoken to.
    pub fn start(
        manager: String,
        incarnation: String,
        first: Option<UnixStream>,
        socket: PathBuf,
        on_changed: OnChanged,
    ) -> Self {
        let (calls, queue) = mpsc::channel(QUEUE);
        let (greeted, hello) = watch::channel(None);
        let worker = Worker {
            manager: manager.clone(),
            incarnation,
            socket,
            queue,
            greeted,
            pending: Pending::default(),
            on_changed,
        };
        let task = tokio::spawn(worker.run(first)).abort_handle();
        Self {
            manager,
            calls,
            hello,
            task,
        }
    }

    /// Waits for the manager's first Hello: its sign of readiness.
    pub async fn ready(&self) -> Option<Hello> {
        let mut hello = self.hello.clone();
        let hello = hello.wait_for(Option::is_some).await.ok()?;
        hello.clone()
    }

    /// Ends the link; calls that wait fail.
    pub fn close(&self) {
        self.task.abort();
    }

    /// Sends a request; the manager has `deadline` to answer, and a second more before it counts as silent.
    pub async fn call(
        &self,
        body: RequestBody,
        deadline: Duration,
    ) -> Result<ResponseBody, LinkError> {
        self.call_within(body, deadline, deadline + GRACE).await
    }

    /// The same, with the time after which the manager counts as silent.
    pub async fn call_within(
        &self,
        body: RequestBody,
        deadline: Duration,
        limit: Duration,
    ) -> Result<ResponseBody, LinkError> {
        let (answer, answered) = oneshot::channel();
        let call = Call {
            body,
            deadline: Instant::now() + deadline,
            answer,
        };
        let lost = || LinkError::Lost {
            manager: self.manager.clone(),
        };
        let exchange = async {
            self.calls.send(call).await.map_err(|_| lost())?;
            answered.await.map_err(|_| lost())?
        };
        timeout(limit, exchange).await.unwrap_or_else(|_| {
            Err(LinkError::Silent {
                manager: self.manager.clone(),
                after: limit,
            })
        })
    }

    /// A request whose good answer is `Done`.
    pub async fn done(&self, body: RequestBody, deadline: Duration) -> Result<(), LinkError> {
        match self.call(body, deadline).await? {
            ResponseBody::Done => Ok(()),
            _ => Err(self.unexpected()),
        }
    }

    /// The error for an answer of the wrong kind.
    pub fn unexpected(&self) -> LinkError {
        LinkError::Unexpected {
            manager: self.manager.clone(),
        }
    }
}

/// Those who wait for an answer, by request id.
type Waiting = Mutex<HashMap<u64, oneshot::Sender<Result<ResponseBody, LinkError>>>>;

/// Requests that were sent and not answered.
#[derive(Default)]
struct Pending {
    next_id: u64,
    waiting: Arc<Waiting>,
}

struct Worker {
    manager: String,
    incarnation: String,
    socket: PathBuf,
    queue: mpsc::Receiver<Call>,
    greeted: watch::Sender<Option<Hello>>,
    pending: Pending,
    on_changed: OnChanged,
}

impl Worker {
    /// Serves one connection after the other until the link is dropped.
    async fn run(mut self, mut first: Option<UnixStream>) {
        let mut pause = BACK_OFF.0;
        loop {
            match self.connect(first.take()).await {
                Ok(stream) => {
                    pause = BACK_OFF.0;
                    let error = self.serve(stream).await;
                    tracing::debug!(manager = self.manager, "connection ended: {error}");
                }
                Err(e) => tracing::debug!(manager = self.manager, "cannot connect: {e}"),
            }
            for (_, answer) in lock(&self.pending.waiting).drain() {
                let manager = self.manager.clone();
                let _ = answer.send(Err(LinkError::Lost { manager }));
            }
            if self.queue.is_closed() {
                return;
            }
            sleep(pause).await;
            pause = (pause * 2).min(BACK_OFF.1);
        }
    }

    async fn connect(
        &mut self,
        first: Option<UnixStream>,
    ) -> Result<BufReader<UnixStream>, FrameError> {
        let greet = async {
            let mut stream = match first {
                Some(stream) => stream,
                None => UnixStream::connect(&self.socket).await?,
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
        self.greeted.send_replace(Some(hello));
        Ok(stream)
    }

    fn check(&self, hello: &Hello) -> Result<(), FrameError> {
        let known = PROTOCOL_VERSION.saturating_sub(1).max(1)..=PROTOCOL_VERSION;
        let wrong = if hello.incarnation != self.incarnation {
            format!("it is another start: {}", hello.incarnation)
        } else if !known.contains(&hello.version) {
            format!("it speaks protocol version {}", hello.version)
        } else {
            return Ok(());
        };
        tracing::warn!(manager = self.manager, "cannot use this manager: {wrong}");
        Err(std::io::Error::other(wrong).into())
    }

    /// Reads and writes at the same time, so that neither side can block the other. Returns why it ended.
    async fn serve(&mut self, stream: BufReader<UnixStream>) -> FrameError {
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
            while let Some(call) = self.queue.recv().await {
                let Some(bytes) = self.pending.note(call) else {
                    continue;
                };
                if let Err(e) = to.write_all(&bytes).await {
                    return FrameError::from(e);
                }
                if let Err(e) = to.flush().await {
                    return FrameError::from(e);
                }
            }
            FrameError::Closed
        };
        tokio::select! {
            error = reading => error,
            error = writing => error,
        }
    }
}

impl Pending {
    /// Remembers a call and encodes its request; none when nobody waits for it any more or it cannot be encoded.
    fn note(&mut self, call: Call) -> Option<Vec<u8>> {
        // What waited for the connection has less time left; without any it could only come too late.
        let left = call.deadline.saturating_duration_since(Instant::now());
        if call.answer.is_closed() || left.is_zero() {
            return None;
        }
        let id = self.next_id;
        self.next_id += 1;
        let request = Request {
            id,
            deadline_ms: left.as_millis().max(1).try_into().unwrap_or(u64::MAX),
            body: call.body,
        };
        match frame::encode(&request) {
            Ok(bytes) => {
                let mut waiting = lock(&self.waiting);
                waiting.retain(|_, answer| !answer.is_closed());
                waiting.insert(id, call.answer);
                Some(bytes)
            }
            Err(e) => {
                let failure = Failure {
                    code: rts_manager_api::control::FailureCode::Invalid,
                    message: format!("the request cannot be sent: {e}"),
                };
                let _ = call.answer.send(Err(failure.into()));
                None
            }
        }
    }
}

fn settle(waiting: &Waiting, response: Response) {
    if let Some(answer) = lock(waiting).remove(&response.id) {
        // The caller may have given up.
        let _ = answer.send(response.result.map_err(LinkError::from));
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
