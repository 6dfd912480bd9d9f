//! Agents for tests.

use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex};

use futures_util::future::BoxFuture;
use rts_host::clock::{SystemChance, SystemClock};
use rts_host::disk::{Disk, FileDisk};
use tokio::sync::mpsc;

use crate::agent::Agent;
use crate::inputs::Inputs;
use crate::machine::Host;
use crate::peers::HomePeers;

/// An agent in a home of its own, which can start nothing.
pub(crate) async fn agent(home: &Path) -> Arc<Agent> {
    agent_with(home, Arc::new(FileDisk)).await
}

/// The same with a disk.
pub(crate) async fn agent_with(home: &Path, disk: Arc<dyn Disk>) -> Arc<Agent> {
    let config = crate::Config {
        home: home.to_owned(),
        node: "local".to_owned(),
        aliases: Vec::new(),
        module_path: Vec::new(),
        manager_program: "/nonexistent/rts-manager".into(),
        controller_socket: None,
        heal_after: None,
        idle_managers: None,
    };
    let inputs = Inputs {
        clock: Arc::new(SystemClock),
        chance: Arc::new(SystemChance),
        disk,
        machine: Arc::new(Host::take(&config, None).await.unwrap()),
        controller: None,
        peers: Arc::new(HomePeers::new(home)),
    };
    Arc::new(Agent::new(config, inputs).await.unwrap())
}

/// Writes files whose names end so when it is told to; keeps nothing of others.
pub(crate) struct SlowDisk {
    name: &'static str,
    begun: mpsc::UnboundedSender<()>,
    go: tokio::sync::Mutex<mpsc::UnboundedReceiver<()>>,
    /// What was written, in order.
    pub written: Mutex<Vec<Vec<u8>>>,
}

impl SlowDisk {
    /// That of a file. Tells each begin of a write, and writes at each word.
    pub fn new(
        name: &'static str,
    ) -> (
        Arc<Self>,
        mpsc::UnboundedReceiver<()>,
        mpsc::UnboundedSender<()>,
    ) {
        let (begun, begins) = mpsc::unbounded_channel();
        let (go, gone) = mpsc::unbounded_channel();
        let disk = Self {
            name,
            begun,
            go: tokio::sync::Mutex::new(gone),
            written: Mutex::default(),
        };
        (Arc::new(disk), begins, go)
    }
}

impl Disk for SlowDisk {
    fn read<'a>(&'a self, _: &'a Path, _: u64) -> BoxFuture<'a, io::Result<Option<Vec<u8>>>> {
        Box::pin(async { Ok(None) })
    }

    fn write<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async move {
            let name = path.to_string_lossy();
            if name.trim_end_matches(".new").ends_with(self.name) {
                self.begun.send(()).unwrap();
                self.go.lock().await.recv().await.unwrap();
                self.written.lock().unwrap().push(bytes);
            }
            Ok(())
        })
    }

    fn sync<'a>(&'a self, _: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async { Ok(()) })
    }

    fn write_over<'a>(&'a self, path: &'a Path, bytes: Vec<u8>) -> BoxFuture<'a, io::Result<()>> {
        self.write(path, bytes)
    }

    fn rename<'a>(&'a self, _: &'a Path, _: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async { Ok(()) })
    }

    fn sync_folder<'a>(&'a self, _: &'a Path) -> BoxFuture<'a, io::Result<()>> {
        Box::pin(async { Ok(()) })
    }
}
