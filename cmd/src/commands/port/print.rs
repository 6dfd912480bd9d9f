//! `rtsctl port print`.

use std::time::Duration;

use rts_schemas::system::Direction;
use tokio::time::{Instant, timeout_at};

use super::end::World;
use super::samples::Samples;
use super::types::{Codec, NotASample, TypeArgs, Types};
use crate::commands::{duration, while_read};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Print what an out-port writes, one JSON value for each sample (rtprint)
///
/// The component does not notice: whoever reads too slowly misses samples, and is told how many.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The out-port (`Sine0.out`)
    #[arg(value_name = "COMPONENT.PORT")]
    port: String,
    /// End after so many samples [default: Ctrl-C ends it]
    #[arg(short = 'n', long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// End after this time
    #[arg(long = "for", value_name = "TIME", value_parser = duration)]
    time: Option<Duration>,
    /// Give up (exit 6) when no sample comes for this time
    #[arg(long, value_name = "TIME", value_parser = duration)]
    timeout: Option<Duration>,
    /// Where its type is defined.
    #[command(flatten)]
    types: TypeArgs,
}

/// Prints until there is enough.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let types = Types::read(&args.types, &session.out)?;
    let controller = session.connect().await?;
    let port = World::of(&controller)
        .await?
        .port(&args.port, Direction::Out)?;
    let codec = types.codec(&port.data_type, &port.shown())?;
    let print = async {
        let samples = Samples::of(&controller, &port, session.out).await?;
        print(samples, &codec, &args, &port.shown(), session).await
    };
    while_read(print, session).await
}

async fn print(
    mut samples: Samples,
    codec: &Codec<'_>,
    args: &Args,
    shown: &str,
    session: &Session,
) -> Result<Exit, CliError> {
    let end = args.time.map(|time| Instant::now() + time);
    let mut left = args.count;
    while left != Some(0) {
        let patience = args.timeout.map(|time| Instant::now() + time);
        let first = end.into_iter().chain(patience).min();
        let sample = match first {
            None => samples.next().await?,
            Some(first) => match timeout_at(first, samples.next()).await {
                Ok(sample) => sample?,
                Err(_) if end == Some(first) => break,
                Err(_) => return Err(silent(shown, args.timeout.unwrap_or_default())),
            },
        };
        let json = codec.json(&sample.data);
        session
            .out
            .result(&json.map_err(|e| unreadable(shown, &e))?)?;
        left = left.map(|left| left - 1);
    }
    Ok(Exit::Ok)
}

fn silent(shown: &str, time: Duration) -> CliError {
    CliError::Port {
        message: format!("no sample of {shown} came for {time:?}"),
        help: Some("is its component Active? see `rtsctl get components`".to_owned()),
        exit: Exit::Deadline,
    }
}

/// The error for a sample that is not what its type says.
pub(super) fn unreadable(shown: &str, error: &NotASample) -> CliError {
    CliError::Port {
        message: format!("a sample of {shown} does not fit its type: {error}"),
        help: Some("is it the same IDL that the component was built from?".to_owned()),
        exit: Exit::Invalid,
    }
}
