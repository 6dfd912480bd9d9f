//! Looking at a port of a component, or writing to one: a connection of its own to the manager, which lasts as long as who
//! asked for it.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use rts_http::problem::Problem;
use rts_manager_api::OLDEST_PROTOCOL_VERSION;
use rts_manager_api::control::Greeting;
use rts_manager_api::frame::{self, FrameError};
use rts_manager_api::tap::{END, TapEnd, TapHello, TapOpened, TapReply, TapSample, TapWay};
use serde::de::DeserializeOwned;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt, BufReader, ReadHalf, WriteHalf, split};
use tokio::time::timeout;

use crate::agent::Agent;
use crate::by_hand::answers::refused;
use crate::machine::Control;

/// Bound on connecting and on the manager's answer.
const OPEN: Duration = Duration::from_secs(5);

/// A tap that a manager has opened.
pub(crate) struct Tap {
    /// The port.
    pub opened: TapOpened,
    /// What comes from the manager.
    pub from: Reader,
    /// What goes to it.
    pub to: Writer,
}

/// The reading half.
pub(crate) struct Reader(BufReader<ReadHalf<Box<dyn Control>>>);

/// The writing half.
pub(crate) struct Writer(WriteHalf<Box<dyn Control>>);

/// What comes from a port.
#[derive(Debug)]
pub(crate) enum Came {
    /// A sample, and its bytes.
    Sample(TapSample, Bytes),
    /// No more.
    End(TapEnd),
}

impl Reader {
    /// What comes next. Waits as long as the port is silent.
    pub async fn next(&mut self) -> io::Result<Came> {
        let mut length = [0; 4];
        self.0.read_exact(&mut length).await?;
        let wrong = |text: String| io::Error::new(io::ErrorKind::InvalidData, text);
        let announced = TapSample::announced(length);
        let announced = announced.map_err(|n| wrong(format!("no sample has a length of {n}")))?;
        let Some(bytes) = announced else {
            return Ok(Came::End(self.end().await?));
        };
        let mut rest = vec![0; bytes];
        self.0.read_exact(&mut rest).await?;
        let (sample, payload) =
            TapSample::split(&rest).ok_or_else(|| wrong("a sample is cut".to_owned()))?;
        let head = bytes - payload.len();
        Ok(Came::Sample(sample, Bytes::from(rest).slice(head..)))
    }

    /// The manager's last word.
    pub async fn end(&mut self) -> io::Result<TapEnd> {
        read(&mut self.0).await.map_err(io::Error::other)
    }
}

impl Writer {
    /// Sends a sample.
    pub async fn send(&mut self, payload: &[u8]) -> io::Result<()> {
        let sample = TapSample {
            length: payload.len(),
            time: 0,
            missed: 0,
        };
        self.0.write_all(&sample.head()).await?;
        self.0.write_all(payload).await?;
        self.0.flush().await
    }

    /// Says that this was all.
    pub async fn end(&mut self) -> io::Result<()> {
        self.0.write_all(&END).await?;
        self.0.flush().await
    }
}

impl Agent {
    /// Opens a tap at a port of a component of this node.
    pub async fn tap(
        self: &Arc<Self>,
        instance: &str,
        port: &str,
        way: TapWay,
    ) -> Result<Tap, Problem> {
        let inventory = self.observe().await;
        let (_, manager) = self.find_component(&inventory, instance)?;
        let name = manager.key.display_name();
        let hello = TapHello {
            version: OLDEST_PROTOCOL_VERSION,
            instance: instance.to_owned(),
            port: port.to_owned(),
            way,
        };
        let open = async {
            let mut stream = self.inputs.machine.connect(&manager.folder).await?;
            let greeting = frame::encode(&Greeting::Tap(hello))?;
            stream.write_all(&greeting).await?;
            let (from, to) = split(stream);
            let mut from = BufReader::new(from);
            let reply: TapReply = read(&mut from).await?;
            Ok::<_, FrameError>((reply.result, from, to))
        };
        let silent = |reason: String| {
            Problem::unavailable(
                "manager-silent",
                format!("manager {name} does not answer: {reason}"),
            )
        };
        match timeout(OPEN, open).await {
            Err(_) => Err(silent("it takes too long".to_owned())),
            Ok(Ok((result, from, to))) => {
                let opened = result.map_err(refused)?;
                Ok(Tap {
                    opened,
                    from: Reader(from),
                    to: Writer(to),
                })
            }
            // It was there a moment ago, and hung up on what it was greeted with.
            Ok(Err(FrameError::Io(e))) if e.kind() == io::ErrorKind::UnexpectedEof => {
                Err(Problem::new(
                    501,
                    "upgrade",
                    "not implemented",
                    format!(
                        "manager {name} closed the connection: it has just ended, or is of an older version, whose ports \
                         cannot be looked at or written to; end its process, and it is started again from the program \
                         that is installed"
                    ),
                ))
            }
            Ok(Err(e)) => Err(silent(e.to_string())),
        }
    }
}

async fn read<T: DeserializeOwned>(from: &mut (impl AsyncRead + Unpin)) -> Result<T, FrameError> {
    let mut header = [0; 4];
    from.read_exact(&mut header).await?;
    let mut body = vec![0; frame::length(header)?];
    from.read_exact(&mut body).await?;
    frame::decode(&body)
}
