//! One verb per file: its arguments, whose text is its help, and what it does.

pub mod activate;
pub mod apply;
pub mod by_hand;
pub mod check;
pub mod completion;
pub mod conf;
pub mod connect;
pub mod controller;
pub mod convert;
pub mod deactivate;
pub mod describe;
pub mod diff;
pub mod disconnect;
pub mod docs;
pub mod down;
pub mod events;
pub mod explain;
pub mod export;
pub mod fmt;
pub mod get;
pub mod idl;
pub mod logs;
pub mod manager;
pub mod node;
pub mod plan;
pub mod port;
pub mod reset;
pub mod schema;
pub mod smoke;
pub mod teardown;
pub mod tick;
pub mod top;
pub mod up;
pub mod version;

use std::io::{BufRead, IsTerminal, Write};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use signal_hook::consts::SIGINT;
use signal_hook::flag;

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::relays;
use crate::session::Session;

/// A time as people write it (`60s`, `2m30s`), more than nothing.
pub fn duration(text: &str) -> Result<Duration, String> {
    let example = "write a time such as `60s` or `2m30s`";
    let parsed: jiff::SignedDuration = text.parse().map_err(|_| example.to_owned())?;
    let duration = Duration::try_from(parsed).map_err(|_| example.to_owned())?;
    if duration.is_zero() {
        return Err("it must be more than nothing".to_owned());
    }
    Ok(duration)
}

/// Waits for something, or for Ctrl-C: then says `said` and ends. A second Ctrl-C ends the program at once, wherever it
/// hangs: it may be writing to somebody who does not read.
pub async fn or_interrupted<T>(
    wait: impl Future<Output = Result<T, CliError>>,
    session: &Session,
    said: &str,
) -> Result<T, CliError> {
    let again = Arc::new(AtomicBool::new(false));
    let code = i32::from(Exit::Interrupted.code());
    // In this order: the first Ctrl-C finds the flag down and puts it up. Without them only the second one is lost.
    let _ = flag::register_conditional_shutdown(SIGINT, code, Arc::clone(&again))
        .and_then(|_| flag::register(SIGINT, again));
    tokio::select! {
        biased;
        signal = tokio::signal::ctrl_c() => {
            if signal.is_ok() && !said.is_empty() {
                session.out.stderr(&format!("rtsctl: {said}"));
            }
            Err(CliError::Interrupted)
        }
        outcome = wait => outcome,
    }
}

/// Prints as things happen, until Ctrl-C, or until nobody reads it any more.
pub async fn while_read<T>(
    print: impl Future<Output = Result<T, CliError>>,
    session: &Session,
) -> Result<T, CliError> {
    let print = async {
        tokio::select! {
            biased;
            outcome = print => outcome,
            unread = session.out.unread() => Err(unread),
        }
    };
    or_interrupted(print, session, "").await
}

/// What is said when the waiting for a system that lies on these nodes ends before the controller does.
pub fn goes_on(system: &str, nodes: &[String]) -> String {
    let nodes = relays::on_demand(nodes);
    let until = match nodes.as_slice() {
        [] => String::new(),
        nodes => format!(
            " (on {}, reached by SSH, only as long as the session is kept)",
            nodes.join(", ")
        ),
    };
    format!(
        "only the waiting ends, the controller goes on with system/{system}{until}: see `rtsctl describe system/{system}` or \
         `rtsctl get systems -w`; `rtsctl teardown {system}` stops it"
    )
}

/// A person can be asked.
pub fn can_ask() -> bool {
    std::io::stdin().is_terminal() && std::io::stderr().is_terminal()
}

/// Asks a yes-or-no question on the terminal; anything but yes is no.
pub fn ask(question: &str) -> bool {
    let mut stderr = std::io::stderr();
    let _ = write!(stderr, "{question} [y/N] ").and_then(|()| stderr.flush());
    let mut answer = String::new();
    let read = std::io::stdin().lock().read_line(&mut answer);
    read.is_ok() && matches!(answer.trim().to_lowercase().as_str(), "y" | "yes")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_as_people_write_them() {
        assert_eq!(duration("60s"), Ok(Duration::from_secs(60)));
        assert_eq!(duration("2m30s"), Ok(Duration::from_secs(150)));
        assert_eq!(duration("250ms"), Ok(Duration::from_millis(250)));
        assert_eq!(duration("1h"), Ok(Duration::from_secs(3600)));
        for wrong in ["", "60", "-5s", "0s", "soon", "5 parsecs"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }
}
