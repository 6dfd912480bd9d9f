//! `rtsctl logs`.

mod print;
mod targets;

use std::time::Duration;

use jiff::Timestamp;
use rts_agent_api::messages::LogQuery;

use self::print::{Printer, print};
use self::targets::find;
use super::{duration, while_read};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Print the logs of components
///
/// The lines of several components stand in the order of their times, each behind the name of its component.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Instance names of components
    #[arg(value_name = "NAME", required_unless_present = "system")]
    names: Vec<String>,
    /// Of all components of a system
    #[arg(long, value_name = "NAME", conflicts_with = "names")]
    system: Option<String>,
    /// Stay until Ctrl-C, and print what is added; goes on where it was when a stream breaks
    #[arg(short, long)]
    follow: bool,
    /// Of the incarnation before the newest: what a component said before it was made again
    #[arg(short, long, conflicts_with = "follow")]
    previous: bool,
    /// Only lines from a time on: so long ago (`5m`), or a time of RFC 3339
    #[arg(long, value_name = "TIME", value_parser = since)]
    since: Option<Timestamp>,
    /// Number of lines from the end, at most 10000 [default: 200; all with --since or --previous]
    #[arg(long, value_name = "N")]
    tail: Option<usize>,
    /// Begin each line with the name of its component, also when there is but one
    #[arg(long)]
    prefix: bool,
    /// Node that they run on [default: where they are found]
    #[arg(short, long, value_name = "NODE")]
    node: Option<String>,
}

/// Prints the lines.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let targets = find(&args, &controller).await?;
    let query = LogQuery {
        tail: args.tail,
        follow: args.follow,
        previous: args.previous,
        since: args.since.map(|time| time.to_string()),
    };
    let printer = Printer {
        prefix: args.prefix || targets.len() > 1,
        out: session.out,
    };
    let all = print(&controller, &targets, &query, &printer);
    while_read(all, session).await
}

/// A time, or how long ago.
fn since(text: &str) -> Result<Timestamp, String> {
    if let Ok(time) = text.parse() {
        return Ok(time);
    }
    let ago: Duration = duration(text)
        .map_err(|_| "write how long ago (`5m`), or a time (`2026-01-31T12:00:00Z`)".to_owned())?;
    Timestamp::now()
        .checked_sub(ago)
        .map_err(|_| "that is too long ago".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_told_or_how_long_ago_it_was() {
        let noon = since("2026-01-31T12:00:00Z").unwrap();
        assert_eq!(noon.to_string(), "2026-01-31T12:00:00Z");
        let ago = Timestamp::now().duration_since(since("5m").unwrap());
        assert!((299..330).contains(&ago.as_secs()), "{ago}");
        for wrong in ["", "yesterday", "-5m", "9999999999h"] {
            assert!(since(wrong).is_err(), "{wrong}");
        }
    }
}
