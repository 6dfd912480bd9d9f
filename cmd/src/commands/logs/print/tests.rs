//! Logs of a controller that knows a previous incarnation of some components only.

use std::time::Duration;

use clap::Parser;
use rts_http::client::Client;
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::net::{UnixListener, UnixStream};

use super::*;
use crate::cli::Cli;

const LACKING: &str = r#"{"type":"no-previous","title":"no previous incarnation","status":404}"#;

/// Those whose name begins with `New` have none.
async fn answer(stream: UnixStream) {
    let mut stream = BufReader::new(stream);
    let mut head = String::new();
    while !head.ends_with("\r\n\r\n") && stream.read_line(&mut head).await.unwrap() > 0 {}
    let (status, kind, body) = if head.contains("/New") {
        ("404 Not Found", "application/problem+json", LACKING)
    } else {
        ("200 OK", "text/plain", "2026-01-02T03:04:05.000Z INFO a\n")
    };
    let length = body.len();
    let text = format!(
        "HTTP/1.1 {status}\r\ncontent-type: {kind}\r\ncontent-length: {length}\r\nconnection: close\r\n\r\n{body}"
    );
    stream.write_all(text.as_bytes()).await.unwrap();
}

#[tokio::test]
async fn what_has_no_previous_incarnation_does_not_hide_what_has() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("c.sock");
    let listener = UnixListener::bind(&socket).unwrap();
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            answer(stream).await;
        }
    });
    let controller = Controller::new(Client::unix(socket, Duration::from_secs(5)).unwrap());
    let cli = Cli::try_parse_from(["rtsctl", "version"]).unwrap();
    let printer = Printer {
        prefix: true,
        out: Output::new(&cli.globals),
    };
    let query = LogQuery {
        previous: true,
        ..LogQuery::default()
    };
    let exit = async |names: &[&str]| {
        let target = |name: &&str| Target {
            node: "local".to_owned(),
            instance: (*name).to_owned(),
        };
        let targets: Vec<_> = names.iter().map(target).collect();
        let printed = print(&controller, &targets, &query, &printer).await;
        printed.unwrap_or_else(|e| e.exit()).code()
    };
    assert_eq!(exit(&["New0", "Old0", "New1"]).await, 0);
    assert_eq!(exit(&["New0", "New1"]).await, 2);
    assert_eq!(exit(&["New0"]).await, 2);
    assert_eq!(exit(&["Old0"]).await, 0);
}
