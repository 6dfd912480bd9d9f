//! A controller that only listens to one agent.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};

use axum::extract::State;
use axum::http::StatusCode;
use axum::routing::post;
use rts_agent_api::session::{
    AgentEvent, HEARTBEAT, HEARTBEATS, Heartbeat, SESSIONS, SessionGreeting, SessionReply,
};
use rts_http::problem::Problem;
use rts_http::server::{self, Json, ProblemResponse};
use rts_plan::observed::Inventory;
use tempfile::TempDir;
use tokio::sync::{Mutex, mpsc, oneshot};
use tokio::time::timeout;

use crate::setup::PATIENCE;

struct Ears {
    greetings: mpsc::UnboundedSender<SessionGreeting>,
    heartbeats: mpsc::UnboundedSender<Heartbeat>,
    /// Status of the next answers to heartbeats; 404 once. 503 is answered to greetings too.
    answer: AtomicU16,
    /// Heartbeats that were answered with 503.
    in_vain: AtomicU16,
}

pub struct FakeController {
    folder: TempDir,
    /// Ends the server, and connections that are idle, when dropped.
    _life: oneshot::Sender<()>,
    ears: Arc<Ears>,
    greetings: Mutex<mpsc::UnboundedReceiver<SessionGreeting>>,
    heartbeats: Mutex<mpsc::UnboundedReceiver<Heartbeat>>,
}

impl FakeController {
    pub async fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("controller.sock");
        Self::at(folder, socket).await
    }

    pub async fn at(folder: TempDir, socket: PathBuf) -> Self {
        let (greeted, greetings) = mpsc::unbounded_channel();
        let (beat, heartbeats) = mpsc::unbounded_channel();
        let ears = Arc::new(Ears {
            greetings: greeted,
            heartbeats: beat,
            answer: AtomicU16::new(204),
            in_vain: AtomicU16::new(0),
        });
        let router = axum::Router::new()
            .route(SESSIONS, post(greet))
            .route(HEARTBEATS, post(heartbeat))
            .with_state(ears.clone());
        let listener = server::bind(&socket).unwrap();
        let (life, death) = oneshot::channel();
        tokio::spawn(server::serve(listener, router, async {
            let _: Result<(), _> = death.await;
        }));
        Self {
            _life: life,
            folder,
            ears,
            greetings: Mutex::new(greetings),
            heartbeats: Mutex::new(heartbeats),
        }
    }

    pub fn socket(&self) -> PathBuf {
        self.folder.path().join("controller.sock")
    }

    /// Answers one heartbeat with 404.
    pub fn forget(&self) {
        self.ears.answer.store(404, Ordering::SeqCst);
    }

    /// Answers heartbeats with 409 from now on.
    pub fn supersede(&self) {
        self.ears.answer.store(409, Ordering::SeqCst);
    }

    /// Answers everything with 503 from now on.
    pub fn refuse(&self) {
        self.ears.answer.store(503, Ordering::SeqCst);
    }

    /// Accepts everything from now on.
    pub fn accept(&self) {
        self.ears.answer.store(204, Ordering::SeqCst);
    }

    /// Heartbeats that it refused.
    pub fn beaten_in_vain(&self) -> u16 {
        self.ears.in_vain.load(Ordering::SeqCst)
    }

    /// True when a greeting has come that nobody has asked for yet; now it was.
    pub fn was_greeted(&self) -> bool {
        let greetings = self.greetings.try_lock();
        greetings.is_ok_and(|mut greetings| greetings.try_recv().is_ok())
    }

    pub async fn greeting(&self) -> SessionGreeting {
        let mut greetings = self.greetings.lock().await;
        timeout(PATIENCE, greetings.recv()).await.unwrap().unwrap()
    }

    pub async fn heartbeat(&self) -> Heartbeat {
        let mut heartbeats = self.heartbeats.lock().await;
        timeout(PATIENCE, heartbeats.recv()).await.unwrap().unwrap()
    }

    /// Waits for an event with this reason; those before it are dropped.
    pub async fn event(&self, reason: &str) -> AgentEvent {
        loop {
            let mut events = self.heartbeat().await.events.into_iter();
            if let Some(event) = events.find(|e| e.reason == reason) {
                return event;
            }
        }
    }

    /// Goes the way of the deltas until the inventory is as wanted.
    pub async fn follow(&self, inventory: &mut Inventory, wanted: impl Fn(&Inventory) -> bool) {
        while !wanted(inventory) {
            let heartbeat = self.heartbeat().await;
            if let Some(delta) = heartbeat.delta {
                assert!(inventory.advance(delta), "a delta from another revision");
            }
            assert_eq!(inventory.revision, heartbeat.inventory_revision);
        }
    }

    pub async fn revision_above(&self, revision: u64) {
        while self.heartbeat().await.inventory_revision <= revision {}
    }

    /// Waits for the heartbeat that is answered with 409, and checks that no other follows.
    pub async fn quiet(&self) {
        let mut heartbeats = self.heartbeats.lock().await;
        timeout(PATIENCE, heartbeats.recv()).await.unwrap().unwrap();
        let mut late = 0;
        while timeout(HEARTBEAT * 5 / 2, heartbeats.recv()).await.is_ok() {
            late += 1;
            assert!(late < 3, "heartbeats go on");
        }
    }
}

async fn greet(
    State(ears): State<Arc<Ears>>,
    Json(greeting): Json<SessionGreeting>,
) -> Result<Json<SessionReply>, ProblemResponse> {
    if ears.answer.load(Ordering::SeqCst) == 503 {
        return Err(stuck());
    }
    let _ = ears.greetings.send(greeting);
    Ok(Json(SessionReply {
        cluster_uid: "cluster".to_owned(),
        epoch: 1,
    }))
}

fn stuck() -> ProblemResponse {
    Problem::unavailable("stuck", "nothing is decided").into()
}

async fn heartbeat(
    State(ears): State<Arc<Ears>>,
    Json(heartbeat): Json<Heartbeat>,
) -> Result<StatusCode, ProblemResponse> {
    match ears.answer.load(Ordering::SeqCst) {
        404 => {
            ears.answer.store(204, Ordering::SeqCst);
            Err(Problem::not_found("no such session").into())
        }
        503 => {
            ears.in_vain.fetch_add(1, Ordering::SeqCst);
            Err(stuck())
        }
        409 => {
            let _ = ears.heartbeats.send(heartbeat);
            Err(Problem::conflict("superseded", "a newer session has taken over").into())
        }
        _ => {
            let _ = ears.heartbeats.send(heartbeat);
            Ok(StatusCode::NO_CONTENT)
        }
    }
}
