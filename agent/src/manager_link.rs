//! A control connection to a manager: concurrent requests with deadlines, pushed events, and a new connection when it
//! is lost while the process lives.

mod pending;
mod worker;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use rts_manager_api::control::{Changed, Failure, Hello, RequestBody, ResponseBody};
use rts_manager_api::{OLDEST_PROTOCOL_VERSION, PROTOCOL_VERSION};
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::AbortHandle;
use tokio::time::{Instant, timeout};

use crate::machine::{Control, Machine};
use pending::{Call, Pending};
use worker::Worker;

/// What a late manager gets beyond its deadline before it counts as silent.
pub(crate) const GRACE: Duration = Duration::from_secs(1);
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
    /// It speaks no version of the protocol that this agent speaks.
    #[error(
        "manager {manager} speaks version {theirs} of the manager protocol, this agent {OLDEST_PROTOCOL_VERSION} to {PROTOCOL_VERSION}: {}",
        mend(*theirs)
    )]
    Version {
        /// Display name.
        manager: String,
        /// What it speaks.
        theirs: u32,
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

/// Which side is to be upgraded.
fn mend(theirs: u32) -> &'static str {
    if theirs > PROTOCOL_VERSION {
        "upgrade the agent"
    } else {
        "the manager is to be upgraded, end its process, and it is started again from the program that is installed"
    }
}

/// Gets what a manager pushes.
pub(crate) type OnChanged = Arc<dyn Fn(Changed) + Send + Sync>;

/// The Hello of a manager, or why it cannot be spoken to.
type Greeted = Result<Hello, LinkError>;

/// A link to one start of a manager. Ends when dropped.
#[derive(Debug)]
pub(crate) struct Link {
    manager: String,
    calls: mpsc::Sender<Call>,
    hello: watch::Receiver<Option<Greeted>>,
    task: AbortHandle,
}

impl Drop for Link {
    fn drop(&mut self) {
        self.close();
    }
}

impl Link {
    /// Starts a link. `first` is a connection that is open already; later ones are made to the manager of a run
    /// folder. One with another incarnation is not spoken to.
    pub fn start(
        manager: String,
        incarnation: String,
        first: Option<Box<dyn Control>>,
        place: (Arc<dyn Machine>, PathBuf),
        on_changed: OnChanged,
    ) -> Self {
        let (calls, queue) = mpsc::channel(QUEUE);
        let (greeted, hello) = watch::channel(None);
        let worker = Worker {
            manager: manager.clone(),
            incarnation,
            place,
            queue,
            greeted,
            pending: Pending::default(),
            on_changed,
            refused: None,
        };
        let task = tokio::spawn(worker.run(first)).abort_handle();
        Self {
            manager,
            calls,
            hello,
            task,
        }
    }

    /// Waits for the manager's first Hello: its sign of readiness. An error when it cannot be spoken to.
    pub async fn ready(&self) -> Result<Hello, LinkError> {
        let lost = || LinkError::Lost {
            manager: self.manager.clone(),
        };
        let mut hello = self.hello.clone();
        let hello = hello.wait_for(Option::is_some).await.map_err(|_| lost())?;
        hello.clone().unwrap_or_else(|| Err(lost()))
    }

    /// Version of the protocol that both sides speak; none before it has said Hello.
    pub fn version(&self) -> Option<u32> {
        let hello = self.hello.borrow();
        let hello = hello.as_ref()?.as_ref().ok()?;
        Some(hello.version)
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
