//! Recording.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use rts_schemas::system::Direction;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{Instant, timeout_at};

use super::Args;
use crate::commands::port::end::World;
use crate::commands::port::print::unreadable;
use crate::commands::port::record::line;
use crate::commands::port::samples::Samples;
use crate::commands::port::types::Types;
use crate::commands::while_read;
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::plural;
use crate::session::Session;

/// Samples of all ports that wait to be written.
const QUEUE: usize = 64;

/// Records until there is enough.
pub(super) async fn record(
    args: &Args,
    types: &Types,
    session: &Session,
) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let world = World::of(&controller).await?;
    let mut ports = Vec::new();
    for text in &args.ports {
        let port = world.port(text, Direction::Out)?;
        if ports.contains(&port) {
            return Err(CliError::usage(format!("{} is named twice", port.shown())));
        }
        ports.push(port);
    }
    let mut codecs = Vec::new();
    for port in &ports {
        codecs.push(types.codec(&port.data_type, &port.shown())?);
    }
    let mut to = To::open(&args.out, session)?;
    let record = async {
        let (sender, mut receiver) = mpsc::channel(QUEUE);
        // They end with this function.
        let mut tasks = JoinSet::new();
        for (index, port) in ports.iter().enumerate() {
            let mut samples = Samples::of(&controller, port, session.out).await?;
            let sender = sender.clone();
            tasks.spawn(async move {
                loop {
                    let sample = samples.next().await;
                    let last = sample.is_err();
                    if sender.send((index, sample)).await.is_err() || last {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let end = args.time.map(|time| Instant::now() + time);
        let mut left = args.count;
        while left != Some(0) {
            let came = match end {
                None => receiver.recv().await,
                Some(end) => match timeout_at(end, receiver.recv()).await {
                    Ok(came) => came,
                    Err(_) => break,
                },
            };
            let Some((index, sample)) = came else { break };
            let (sample, port) = (sample?, &ports[index]);
            let shown = port.shown();
            let json = codecs[index].json(&sample.data);
            let json = json.map_err(|e| unreadable(&shown, &e))?;
            to.line(&line(&sample.time, &shown, &port.data_type, &json))?;
            left = left.map(|left| left - 1);
        }
        Ok(())
    };
    let recorded = while_read(record, session).await;
    to.tell(session);
    recorded.map(|()| Exit::Ok)
}

/// Where a recording goes.
struct To<'a> {
    file: Option<(File, &'a Path)>,
    session: &'a Session,
    count: usize,
}

impl<'a> To<'a> {
    fn open(path: &'a Path, session: &'a Session) -> Result<Self, CliError> {
        let file = match path.to_str() {
            Some("-") => None,
            _ => Some((create(path)?, path)),
        };
        Ok(Self {
            file,
            session,
            count: 0,
        })
    }

    fn line(&mut self, line: &str) -> Result<(), CliError> {
        match &mut self.file {
            None => self.session.out.result(line)?,
            Some((file, path)) => {
                let written = file.write_all(format!("{line}\n").as_bytes());
                written.map_err(|source| CliError::Write {
                    path: path.to_path_buf(),
                    source,
                })?;
            }
        }
        self.count += 1;
        Ok(())
    }

    fn tell(&self, session: &Session) {
        if let Some((_, path)) = &self.file {
            let count = plural("sample", self.count);
            session
                .out
                .say(&format!("rtsctl: {count} recorded in {}", path.display()));
        }
    }
}

/// A new file: what somebody has recorded is not lost by a slip.
fn create(path: &Path) -> Result<File, CliError> {
    File::create_new(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::AlreadyExists => CliError::usage_help(
            format!("{} is there already", path.display()),
            "name another file, or remove it first",
        ),
        _ => CliError::Write {
            path: path.to_owned(),
            source,
        },
    })
}
