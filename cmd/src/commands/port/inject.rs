//! `rtsctl port inject`.

use std::io::{BufRead, Read};
use std::thread;
use std::time::Duration;

use rts_agent_api::messages::{InjectLine, InjectQuery, Injected};
use rts_controller_api::client::Controller;
use rts_schemas::system::Direction;
use serde_json::Value;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until};

use super::end::{Port, World};
use super::types::{Codec, TypeArgs, Types};
use crate::commands::{duration, or_interrupted};
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::plural;
use crate::session::Session;

/// Samples on their way that wait to be sent.
const QUEUE: usize = 16;
/// Longest line of input in bytes.
const MAX_LINE: u64 = 64 * 1024 * 1024;

/// Write samples to an in-port, as JSON values (rtinject)
///
/// Ends when the component has read all of them. Of a type that begins with a time, `tm` may be left out: then it is that
/// of now. Members that are left out are zero.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The in-port (`Filter0.in`)
    #[arg(value_name = "COMPONENT.PORT")]
    port: String,
    /// The value, as JSON (`{"data": 1.5}`); `-`, or none, reads one from each line of standard input
    #[arg(value_name = "JSON")]
    value: Option<String>,
    /// Samples per second [default: as fast as the component reads them]
    #[arg(short, long, value_name = "HZ", value_parser = rate)]
    rate: Option<f64>,
    /// Write so many samples: the value over and over, or lines of standard input [default: 1, or all lines]
    #[arg(short = 'n', long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Write the value over and over for this time
    #[arg(long = "for", value_name = "TIME", value_parser = duration)]
    time: Option<Duration>,
    /// Longest wait for room in the port's buffer, and until the last sample was read; then exit 6
    #[arg(long, value_name = "TIME", default_value = "5s", value_parser = duration)]
    timeout: Duration,
    /// Where its type is defined.
    #[command(flatten)]
    types: TypeArgs,
}

/// A rate in Hz.
pub(super) fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if rate.is_finite() && (0.001..=1_000_000.0).contains(&rate) => Ok(rate),
        _ => Err("write a rate in Hz, such as 10".to_owned()),
    }
}

/// Writes them.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let types = Types::read(&args.types, &session.out)?;
    let controller = session.connect().await?;
    let port = World::of(&controller)
        .await?
        .port(&args.port, Direction::In)?;
    let codec = types.codec(&port.data_type, &port.shown())?;
    let values = match args.value.as_deref() {
        None | Some("-") => Values::Lines(lines()),
        Some(text) => {
            let value = parse(text).map_err(|why| invalid("the value", &why))?;
            Values::Same(value)
        }
    };
    // Before anything is asked for.
    if let Values::Same(value) = &values {
        let fits = codec.data(value);
        fits.map_err(|e| invalid("the value", &e.to_string()))?;
    }
    let (sender, receiver) = mpsc::channel(QUEUE);
    let work = async {
        let send = send(values, &args, &codec, sender);
        let answer = inject(&controller, &port, args.timeout, receiver);
        tokio::pin!(send, answer);
        let (sent, injected) = tokio::select! {
            biased;
            injected = &mut answer => (Ok(()), injected?),
            sent = &mut send => (sent, answer.await?),
        };
        let told = tell(&injected, &port, args.timeout, session);
        sent.and(told)
    };
    or_interrupted(work, session, "").await?;
    Ok(Exit::Ok)
}

/// Writes to a port what comes from `samples`, until that ends.
pub(super) async fn inject(
    controller: &Controller,
    port: &Port,
    patience: Duration,
    samples: mpsc::Receiver<InjectLine>,
) -> Result<Injected, CliError> {
    let patience = patience.as_millis().try_into().unwrap_or(u64::MAX);
    let query = InjectQuery {
        data_type: port.data_type.clone(),
        wait_ms: patience,
        linger_ms: patience,
    };
    let injected = controller
        .inject(&port.node, &port.instance, &port.name, &query, samples)
        .await;
    injected.map_err(CliError::request(format!("write to {}", port.shown())))
}

/// Says what became of the samples.
pub(super) fn tell(
    injected: &Injected,
    port: &Port,
    patience: Duration,
    session: &Session,
) -> Result<(), CliError> {
    let shown = port.shown();
    let taken = plural("sample", injected.taken as usize);
    if let Some(reason) = &injected.ended {
        return Err(CliError::Port {
            message: format!("{shown} takes no more after {taken}: {reason}"),
            help: None,
            exit: Exit::Unreachable,
        });
    }
    if injected.read >= injected.taken {
        session
            .out
            .say(&format!("rtsctl: {taken} written to {shown}, and read"));
        return Ok(());
    }
    let unread = injected.taken - injected.read;
    let help = match port.state.as_str() {
        "Active" => format!(
            "component/{} reads too slowly, or does not read this port",
            port.instance
        ),
        "Inactive" => format!("activate it first: `rtsctl activate {}`", port.instance),
        state => format!("component/{} is {state}", port.instance),
    };
    Err(CliError::Port {
        message: format!(
            "{unread} of {taken} written to {shown} were not read within {patience:?}"
        ),
        help: Some(help),
        exit: Exit::Deadline,
    })
}

/// Where values come from.
enum Values {
    /// The same, over and over.
    Same(Value),
    /// Lines of standard input, with their numbers.
    Lines(mpsc::Receiver<std::io::Result<String>>),
}

async fn send(
    values: Values,
    args: &Args,
    codec: &Codec<'_>,
    sender: mpsc::Sender<InjectLine>,
) -> Result<(), CliError> {
    let mut pace = Pace::of(args.rate);
    let until = args.time.map(|time| Instant::now() + time);
    let is_over = || until.is_some_and(|until| Instant::now() >= until);
    match values {
        Values::Same(value) => {
            // Without an end it goes on until Ctrl-C, when it is not as fast as can be.
            let endless = args.time.is_some() || args.rate.is_some();
            let mut left = args.count.unwrap_or(if endless { u64::MAX } else { 1 });
            while left > 0 && !is_over() {
                pace.wait(until).await;
                if is_over() || !put(value.clone(), "the value", codec, &sender).await? {
                    break;
                }
                left -= 1;
            }
        }
        Values::Lines(mut lines) => {
            let (mut left, mut number) = (args.count.unwrap_or(u64::MAX), 0);
            while left > 0
                && !is_over()
                && let Some(line) = lines.recv().await
            {
                let line = line.map_err(|source| CliError::Read {
                    path: "standard input".into(),
                    source,
                })?;
                number += 1;
                if line.trim().is_empty() {
                    continue;
                }
                let place = format!("stdin:{number}");
                let value = parse(&line).map_err(|why| invalid(&place, &why))?;
                pace.wait(until).await;
                if !put(value, &place, codec, &sender).await? {
                    break;
                }
                left -= 1;
            }
        }
    }
    Ok(())
}

/// False when nobody takes it any more.
async fn put(
    mut value: Value,
    place: &str,
    codec: &Codec<'_>,
    sender: &mpsc::Sender<InjectLine>,
) -> Result<bool, CliError> {
    codec.stamp(&mut value);
    let data = codec.data(&value);
    let data = data.map_err(|e| invalid(place, &e.to_string()))?;
    Ok(sender.send(InjectLine { data }).await.is_ok())
}

/// JSON, with the place of a fault in it.
pub(super) fn parse(text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|e| format!("this is no JSON: {e}"))
}

/// The error for a value that is no sample.
pub(super) fn invalid(place: &str, why: &str) -> CliError {
    CliError::Port {
        message: format!("{place}: {why}"),
        help: None,
        exit: Exit::Invalid,
    }
}

/// Keeps a rate.
pub(super) struct Pace {
    period: Option<Duration>,
    next: Instant,
}

impl Pace {
    /// So many in a second; none for no rate.
    pub fn of(rate: Option<f64>) -> Self {
        Self {
            period: rate.map(|rate| Duration::from_secs_f64(1.0 / rate)),
            next: Instant::now(),
        }
    }

    /// Waits until the next is due, or `until`. What is late is not made up for.
    pub async fn wait(&mut self, until: Option<Instant>) {
        let Some(period) = self.period else { return };
        let due = self.next;
        sleep_until(until.map_or(due, |until| due.min(until))).await;
        self.next = (due + period).max(Instant::now());
    }
}

/// Lines of standard input, which another thread waits for.
fn lines() -> mpsc::Receiver<std::io::Result<String>> {
    let (sender, receiver) = mpsc::channel(QUEUE);
    // It ends with the input, or with the program.
    let _ = thread::Builder::new()
        .name("stdin".to_owned())
        .spawn(move || {
            let mut stdin = std::io::stdin().lock();
            loop {
                let mut line = String::new();
                let read = stdin.by_ref().take(MAX_LINE).read_line(&mut line);
                let line = match read {
                    Ok(0) => return,
                    Ok(read) if read as u64 == MAX_LINE => {
                        Err(std::io::Error::other("a line is too long"))
                    }
                    Ok(_) => Ok(line),
                    Err(e) => Err(e),
                };
                let last = line.is_err();
                if sender.blocking_send(line).is_err() || last {
                    return;
                }
            }
        });
    receiver
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_more_than_nothing() {
        assert_eq!(rate("10"), Ok(10.0));
        assert_eq!(rate("0.5"), Ok(0.5));
        for wrong in ["0", "-1", "NaN", "inf", "fast", ""] {
            assert!(rate(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_no_json_tells_where() {
        let why = parse("{\"data\": 1,}").unwrap_err();
        assert!(why.contains("line 1 column 12"), "{why}");
    }
}
