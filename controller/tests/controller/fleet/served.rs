//! A controller behind a real Unix socket.

use std::path::PathBuf;
use std::time::Duration;

use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Phase, System};
use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::{ClientError, Problem};
use rts_http::client::Client;
use rts_schemas::system::SystemSpec;

use super::Cluster;

pub struct Served {
    pub cluster: Cluster,
    pub controller: Controller,
    pub http: Client,
    pub socket: PathBuf,
    pub end: tokio::sync::watch::Sender<bool>,
    pub server: tokio::task::JoinHandle<()>,
    _folder: tempfile::TempDir,
}

pub async fn serve(cluster: Cluster) -> Served {
    let folder = tempfile::Builder::new()
        .prefix("rc")
        .tempdir_in("/tmp")
        .unwrap();
    let socket = folder.path().join("c.sock");
    let listener = rts_http::server::bind(&socket).unwrap();
    let (end, ending) = tokio::sync::watch::channel(false);
    let router = rts_controller::router(cluster.core.clone(), ending.clone());
    let mut told = ending.clone();
    let server = tokio::spawn(async move {
        let shutdown = async move {
            let _ = told.wait_for(|end| *end).await;
        };
        rts_http::server::serve(listener, router, shutdown)
            .await
            .unwrap();
    });
    let http = Client::unix(&socket, Duration::from_secs(10)).unwrap();
    Served {
        cluster,
        controller: Controller::new(http.clone()),
        http,
        socket,
        end,
        server,
        _folder: folder,
    }
}

pub fn request(spec: SystemSpec) -> ApplyRequest {
    ApplyRequest::of(spec)
}

pub fn problem<T: std::fmt::Debug>(result: Result<T, ClientError>) -> Problem {
    match result {
        Err(ClientError::Problem(problem)) => problem,
        other => panic!("no problem document: {other:?}"),
    }
}

pub fn text(problem: &Problem) -> String {
    serde_json::to_string_pretty(problem).unwrap()
}

impl Served {
    pub async fn refused(&self, spec: SystemSpec) -> String {
        let before = self.cluster.stored();
        let problem = problem(self.controller.apply(&request(spec)).await);
        let after = self.cluster.stored();
        assert_eq!(before.systems, after.systems, "nothing is stored");
        text(&problem)
    }

    pub async fn until_converged(&self, name: &str) -> System {
        self.cluster.until_phase(name, Phase::Converged).await
    }
}
