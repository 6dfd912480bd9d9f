//! Playing a recording.

use std::path::Path;
use std::time::Duration;

use jiff::Timestamp;
use rts_agent_api::messages::InjectLine;
use rts_schemas::suggest::listed;
use rts_schemas::system::Direction;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep_until};

use super::Args;
use crate::commands::or_interrupted;
use crate::commands::port::end::{Port, World};
use crate::commands::port::inject::{Pace, inject, invalid, tell};
use crate::commands::port::record::{Reader, Record};
use crate::commands::port::types::{Codec, Types};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Samples of one port on their way that wait to be sent.
const QUEUE: usize = 16;

/// An in-port, and what is played to it.
struct Target<'a> {
    /// The port that was recorded; none for the only one.
    from: Option<String>,
    port: Port,
    codec: Codec<'a>,
    /// None once it takes no more.
    sender: Option<mpsc::Sender<InjectLine>>,
}

/// Plays until the end of the recording.
pub(super) async fn play(
    file: &Path,
    args: &Args,
    types: &Types,
    session: &Session,
) -> Result<Exit, CliError> {
    let reader = Reader::open(file)?;
    let controller = session.connect().await?;
    let world = World::of(&controller).await?;
    let mut targets = Vec::new();
    let mut tasks = JoinSet::new();
    for text in &args.ports {
        let (from, to) = match text.split_once('=') {
            Some((from, to)) => (Some(from.to_owned()), to),
            None => (None, text.as_str()),
        };
        let port = world.port(to, Direction::In)?;
        let (sender, receiver) = mpsc::channel(QUEUE);
        targets.push(Target {
            from,
            codec: types.codec(&port.data_type, &port.shown())?,
            port: port.clone(),
            sender: Some(sender),
        });
        let (controller, patience) = (controller.clone(), args.timeout);
        tasks.spawn(async move {
            let injected = inject(&controller, &port, patience, receiver).await;
            (port, injected)
        });
    }
    let work = async {
        let sent = send(reader, args, &mut targets).await;
        // The end of what each of them gets.
        targets.clear();
        let mut told = sent;
        while let Some(done) = tasks.join_next().await {
            let (port, injected) = done.map_err(|e| CliError::Stdout(std::io::Error::other(e)))?;
            let one = injected.and_then(|it| tell(&it, &port, args.timeout, session));
            // The first fault is the one that is told.
            told = told.and(one);
        }
        told
    };
    or_interrupted(work, session, "").await?;
    Ok(Exit::Ok)
}

async fn send(mut reader: Reader, args: &Args, targets: &mut [Target<'_>]) -> Result<(), CliError> {
    let began = Instant::now();
    let until = args.time.map(|time| began + time);
    let mut pace = Pace::of(args.rate);
    let mut clock = Clock::new(args.speed.unwrap_or(1.0), began);
    let mut left = args.count.unwrap_or(u64::MAX);
    let mut only: Option<String> = None;
    while left > 0
        && let Some((record, place)) = reader.next()?
    {
        // A bare port gets everything, which must then be of one port.
        if targets.iter().any(|target| target.from.is_none()) {
            let only = only.get_or_insert_with(|| record.port.clone());
            if *only != record.port {
                return Err(several(&place, only, &record.port));
            }
        }
        match args.rate {
            Some(_) => pace.wait(until).await,
            None => {
                let due = clock.due(record.time);
                sleep_until(until.map_or(due, |until| due.min(until))).await;
            }
        }
        if until.is_some_and(|until| Instant::now() >= until) {
            break;
        }
        let mut taken = false;
        for target in targets.iter_mut() {
            taken |= target.put(&record, &place).await?;
        }
        // One that nobody takes is not counted.
        left -= u64::from(taken);
        if targets.iter().all(|target| target.sender.is_none()) {
            break;
        }
    }
    Ok(())
}

fn several(place: &str, first: &str, other: &str) -> CliError {
    CliError::usage_help(
        format!(
            "{place}: several ports were recorded: {}",
            listed([first, other])
        ),
        format!("say which of them goes to an in-port: `{first}=Filter0.in`"),
    )
}

impl Target<'_> {
    async fn put(&mut self, record: &Record, place: &str) -> Result<bool, CliError> {
        let Some(sender) = &self.sender else {
            return Ok(false);
        };
        if self.from.as_ref().is_some_and(|from| *from != record.port) {
            return Ok(false);
        }
        let (takes, was) = (&self.port.data_type, &record.data_type);
        if takes != was {
            let shown = self.port.shown();
            let why = format!("{} wrote {was}, but {shown} takes {takes}", record.port);
            return Err(invalid(place, &why));
        }
        let data = self.codec.data(&record.value);
        let data = data.map_err(|e| invalid(place, &e.to_string()))?;
        if sender.send(InjectLine { data }).await.is_err() {
            self.sender = None;
            return Ok(false);
        }
        Ok(true)
    }
}

/// Turns times of a recording into those of its playing.
struct Clock {
    speed: f64,
    began: Instant,
    first: Option<Timestamp>,
}

impl Clock {
    fn new(speed: f64, began: Instant) -> Self {
        Self {
            speed,
            began,
            first: None,
        }
    }

    /// When a sample of this time is due.
    fn due(&mut self, time: Timestamp) -> Instant {
        /// A recording that sleeps for longer was made by a clock that was set.
        const LONGEST: Duration = Duration::from_secs(7 * 24 * 3600);
        let first = *self.first.get_or_insert(time);
        let passed = time.duration_since(first).as_secs_f64() / self.speed;
        let passed = passed.clamp(0.0, LONGEST.as_secs_f64());
        self.began + Duration::from_secs_f64(passed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_keeps_its_own_timing_at_any_speed() {
        let began = Instant::now();
        let mut clock = Clock::new(2.0, began);
        let at = |ms: i64| Timestamp::from_millisecond(1_700_000_000_000 + ms).unwrap();
        assert_eq!(clock.due(at(0)), began);
        assert_eq!(clock.due(at(100)), began + Duration::from_millis(50));
        // A clock that was set back.
        assert_eq!(clock.due(at(-100)), began);
    }
}
