//! What is on the disk and what is in memory stay the same: a client that goes away, a disk that is full.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use crate::fleet::{FakeFleet, greeting, systems};
use futures_util::future::BoxFuture;
use rts_controller::clock::{SystemChance, SystemClock};
use rts_controller::simulator::NoSimulator;
use rts_controller::store::{MemoryStore, OffLoop, RedbStore, State, Store, StoreError, Write};
use rts_controller::{Core, Inputs, Reconciler};
use rts_controller_api::client::Controller;
use rts_controller_api::objects::System;
use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::{ClientError, Problem};
use rts_http::client::Client;
use tokio::sync::Semaphore;

fn request() -> ApplyRequest {
    ApplyRequest::of(systems::hello())
}

async fn core(store: impl Store) -> Arc<Core> {
    let fleet = FakeFleet::default();
    let agent = fleet.add("local", &["SineSource", "LowPassFilter", "Printer"]);
    let core = Core::load(Inputs {
        local_node: "local".into(),
        clock: Arc::new(SystemClock),
        rng: Arc::new(SystemChance),
        fleet: Arc::new(fleet),
        store: Arc::new(store),
        simulator: Arc::new(NoSimulator),
    })
    .await
    .unwrap();
    rts_controller::greet(&core, "local", greeting(&agent, "s1")).unwrap();
    core
}

/// A store whose next write of a system waits for a permit.
#[derive(Clone)]
struct SlowStore {
    inner: MemoryStore,
    reached: Arc<Semaphore>,
    go_on: Arc<Semaphore>,
}

impl Store for SlowStore {
    fn load(&self) -> BoxFuture<'_, Result<State, StoreError>> {
        self.inner.load()
    }
    fn write(&self, writes: Vec<Write>) -> BoxFuture<'_, Result<(), StoreError>> {
        Box::pin(async move {
            let of_system = writes.iter().any(|w| matches!(w, Write::PutSystem(_)));
            self.inner.write(writes).await?;
            if of_system {
                self.reached.add_permits(1);
                self.go_on.acquire().await.unwrap().forget();
            }
            Ok(())
        })
    }
}

#[tokio::test]
async fn a_client_that_goes_away_leaves_disk_and_memory_alike() {
    let store = SlowStore {
        inner: MemoryStore::new("cluster"),
        reached: Arc::new(Semaphore::new(0)),
        go_on: Arc::new(Semaphore::new(0)),
    };
    let core = core(store.clone()).await;
    let mut changes = core.view.subscribe();
    {
        let apply = rts_controller::apply(&core, "hello", request(), None);
        tokio::select! {
            _ = apply => panic!("it waits for the disk"),
            permit = store.reached.acquire() => permit.unwrap().forget(),
        }
        // Here the future is dropped, as the server drops a handler whose client has gone.
    }
    store.go_on.add_permits(1);
    let shown = async {
        while core.view.get::<System>("hello").is_none() {
            changes.changed().await.unwrap();
        }
    };
    tokio::time::timeout(Duration::from_secs(10), shown)
        .await
        .expect("what is stored is shown");
    assert_eq!(
        store.inner.held().systems["hello"],
        core.registry().systems["hello"]
    );
}

/// Set for the run of this program that has a small disk of its own.
const SMALL_DISK: &str = "RTSCTL_TEST_SMALL_DISK";

#[test]
fn a_full_disk_is_said_and_passes_without_a_restart() {
    if let Ok(folder) = std::env::var(SMALL_DISK) {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        return runtime.block_on(on_a_small_disk(Path::new(&folder)));
    }
    let folder = tempfile::Builder::new()
        .prefix("full")
        .tempdir_in("/tmp")
        .unwrap();
    let script = r#"mount -t tmpfs -o size=8m,mode=700 none "$0" || exit 77
        exec "$1" --exact durable::a_full_disk_is_said_and_passes_without_a_restart --nocapture"#;
    let output = Command::new("unshare")
        .args(["-m", "sh", "-c", script])
        .arg(folder.path())
        .arg(std::env::current_exe().unwrap())
        .env(SMALL_DISK, folder.path())
        .output();
    match output {
        Ok(output) if output.status.success() => {}
        Ok(output) if cannot_mount(&output) => {
            println!("skipped: a small disk can be mounted by root alone");
        }
        Ok(output) => panic!(
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        ),
        Err(e) => println!("skipped: there is no unshare: {e}"),
    }
}

fn cannot_mount(output: &std::process::Output) -> bool {
    let said = String::from_utf8_lossy(&output.stderr);
    output.status.code() == Some(77) || said.contains("unshare failed")
}

async fn on_a_small_disk(folder: &Path) {
    let path = folder.join("controller.redb");
    let core = core(OffLoop::new(RedbStore::open(&path, "cluster").unwrap())).await;
    tokio::spawn(Reconciler::new(Arc::clone(&core)).run());
    let socket = folder.join("c.sock");
    let listener = rts_http::server::bind(&socket).unwrap();
    let (_end, ending) = tokio::sync::watch::channel(false);
    let router = rts_controller::router(Arc::clone(&core), ending);
    tokio::spawn(rts_http::server::serve(
        listener,
        router,
        std::future::pending(),
    ));
    let http = Client::unix(&socket, Duration::from_secs(10)).unwrap();
    let controller = Controller::new(http.clone());
    ready(&http).await;

    let filler = fill(folder);
    let refused = problem(controller.apply(&request()).await);
    assert_eq!((refused.status, refused.code.as_str()), (507, "store-full"));
    assert!(refused.retryable);
    assert!(refused.errors[0].help.is_some());
    assert!(core.view.get::<System>("hello").is_none());
    assert!(!controller.ready().await, "it cannot store anything");
    let refused = problem(controller.apply(&request()).await);
    assert_eq!(refused.code, "store-full", "no word of an earlier error");

    std::fs::remove_file(filler).unwrap();
    ready(&http).await;
    controller.apply(&request()).await.unwrap();
    assert!(core.view.get::<System>("hello").is_some());
}

/// Fills the disk to its last byte.
fn fill(folder: &Path) -> PathBuf {
    let path = folder.join("filler");
    let mut file = std::fs::File::create(&path).unwrap();
    let mut size = 1 << 20;
    while size > 0 {
        if std::io::Write::write_all(&mut file, &vec![1; size]).is_err() {
            size /= 2;
        }
    }
    path
}

fn problem<T: std::fmt::Debug>(result: Result<T, ClientError>) -> Problem {
    match result {
        Err(ClientError::Problem(problem)) => problem,
        other => panic!("no problem document: {other:?}"),
    }
}

async fn ready(http: &Client) {
    let wait = async {
        loop {
            let request = http.request(reqwest::Method::GET, "/readyz");
            match http.text(request).await {
                Ok(_) => return,
                Err(_) => tokio::time::sleep(Duration::from_millis(20)).await,
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(10), wait)
        .await
        .expect("it gets ready");
}
