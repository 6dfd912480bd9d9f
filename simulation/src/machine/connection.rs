//! A control connection at the manager's end: greeting, requests, answers, and what is pushed.

use std::time::Duration;

use rts_manager_api::control::{
    Failure, FailureCode, FromManager, Greeting, Hello, Request, RequestBody, Response,
};
use rts_manager_api::frame::{self, FrameError, MAX_FRAME};
use rts_manager_api::{PROTOCOL_VERSION, speaks};
use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, DuplexStream};
use tokio::sync::mpsc;
use tokio::time::{Instant, timeout};

use super::handle::Handle;
use super::request;
use crate::life::Life;

/// Time for a greeting to arrive.
const GREETING: Duration = Duration::from_secs(2);
/// Longest deadline that is kept.
const MAX_DEADLINE: Duration = Duration::from_secs(3600);
/// Messages that wait to be sent.
const QUEUE: usize = 1024;

/// Serves a connection until one of its ends is no more.
pub(super) fn open(handle: &Handle, stream: DuplexStream, life: Life) {
    let manager = handle.clone();
    handle.spawn(async move {
        tokio::select! {
            biased;
            () = life.over() => {}
            // Whoever is there is gone, or talks nonsense: the connection is closed either way.
            _ = serve(manager, stream) => {}
        }
    });
}

async fn serve(handle: Handle, mut stream: DuplexStream) -> Result<(), FrameError> {
    handle.runs().await;
    let greeting = timeout(GREETING, read(&mut stream)).await;
    let Greeting::Control { version } = greeting.map_err(std::io::Error::from)?? else {
        return Ok(());
    };
    handle.work(50, 1_000).await;
    let Some(hello) = handle.with(|process| process.hello.clone()) else {
        return Ok(());
    };
    let spoken = speaks(version);
    let hello = Hello {
        version: spoken.map_or(PROTOCOL_VERSION, |()| version),
        ..hello
    };
    write(&mut stream, &hello).await?;
    if spoken.is_err() {
        return Ok(());
    }
    let (answers, mut queue) = mpsc::channel(QUEUE);
    handle.with(|process| process.listeners.push(answers.clone()));
    let (mut from, mut to) = tokio::io::split(stream);
    let writing = async {
        while let Some(message) = queue.recv().await {
            handle.runs().await;
            write::<FromManager>(&mut to, &message).await?;
        }
        Ok(())
    };
    tokio::select! {
        biased;
        ended = writing => ended,
        ended = requests(&handle, &mut from, &answers) => ended,
    }
}

async fn requests(
    handle: &Handle,
    from: &mut (impl AsyncRead + Unpin),
    answers: &mpsc::Sender<FromManager>,
) -> Result<(), FrameError> {
    loop {
        let request: Request = read(from).await?;
        handle.runs().await;
        let patience = Duration::from_millis(request.deadline_ms).min(MAX_DEADLINE);
        let deadline = Instant::now() + patience;
        let answer = answer(handle.clone(), request, deadline, answers.clone());
        handle.spawn(answer);
    }
}

async fn answer(
    handle: Handle,
    request: Request,
    deadline: Instant,
    answers: mpsc::Sender<FromManager>,
) {
    let ends = matches!(request.body, RequestBody::Shutdown);
    let result = request::handle(&handle, request.body, deadline).await;
    handle.runs().await;
    let id = request.id;
    // Whoever asked may be gone.
    let _ = answers
        .send(FromManager::Response(Response { id, result }))
        .await;
    if ends {
        handle.work(200, 2_000).await;
        super::shutdown::leave(&handle);
    }
}

async fn read<T: DeserializeOwned>(from: &mut (impl AsyncRead + Unpin)) -> Result<T, FrameError> {
    let mut header = [0; 4];
    from.read_exact(&mut header).await?;
    let length = frame::length(header)?;
    if length > MAX_FRAME {
        let limit = MAX_FRAME;
        return Err(FrameError::TooLong { length, limit });
    }
    let mut body = vec![0; length];
    from.read_exact(&mut body).await?;
    frame::decode(&body)
}

async fn write<T: Serialize>(
    to: &mut (impl AsyncWrite + Unpin),
    message: &T,
) -> Result<(), FrameError> {
    let mut bytes = Vec::new();
    frame::write_answer(&mut bytes, message)?;
    to.write_all(&bytes).await?;
    to.flush().await?;
    Ok(())
}

/// Makes a refusal.
pub(super) fn refuse(code: FailureCode, message: impl Into<String>) -> Failure {
    Failure {
        code,
        message: message.into(),
    }
}
