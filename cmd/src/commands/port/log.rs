//! `rtsctl port log`.

mod play;
mod record;

use std::path::PathBuf;
use std::time::Duration;

use super::inject::rate;
use super::types::{TypeArgs, Types};
use crate::commands::duration;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Record what out-ports write, or play a recording back to in-ports (rtlog)
///
/// A recording has one line of JSON for each sample: {time, port, type, value}.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Out-ports to record (`Sine0.out`). With --play in-ports (`Filter0.in`); when several ports were recorded, which one
    /// goes there as well (`Sine0.out=Filter0.in`)
    #[arg(value_name = "COMPONENT.PORT", required = true)]
    ports: Vec<String>,
    /// File to write, which must not be there yet; `-` for stdout
    #[arg(
        short,
        long,
        value_name = "FILE",
        default_value = "-",
        conflicts_with = "play"
    )]
    out: PathBuf,
    /// End after so many samples, of all ports together [default: Ctrl-C, or the end of the recording]
    #[arg(short = 'n', long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// End after this time
    #[arg(long = "for", value_name = "TIME", value_parser = duration)]
    time: Option<Duration>,
    /// Play this recording; `-` is standard input
    #[arg(long, value_name = "FILE")]
    play: Option<PathBuf>,
    /// Play so many times as fast as it was recorded
    #[arg(long, value_name = "FACTOR", requires = "play", value_parser = rate, conflicts_with = "rate")]
    speed: Option<f64>,
    /// Play so many samples per second, of all ports together, whatever their times
    #[arg(short, long, value_name = "HZ", requires = "play", value_parser = rate)]
    rate: Option<f64>,
    /// Longest wait for room in an in-port's buffer, and until the last sample was read; then exit 6
    #[arg(long, value_name = "TIME", default_value = "5s", value_parser = duration)]
    timeout: Duration,
    /// Where their types are defined.
    #[command(flatten)]
    types: TypeArgs,
}

/// Records or plays.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let types = Types::read(&args.types, &session.out)?;
    match &args.play {
        None => record::record(&args, &types, session).await,
        Some(file) => play::play(file, &args, &types, session).await,
    }
}
