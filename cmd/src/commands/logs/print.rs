//! Prints the lines of several logs: in the order of their times, or as they come.

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use jiff::Timestamp;
use rts_agent_api::messages::LogQuery;
use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use tokio::sync::mpsc;
use tokio::task::JoinSet;

use super::targets::{Target, unknown};
use crate::error::CliError;
use crate::exit::Exit;
use crate::follow::{Log, LogNews, time_of};
use crate::output::Output;

/// Lines of all logs that wait to be printed.
const QUEUE: usize = 64;

/// How lines are printed.
#[derive(Debug, Clone, Copy)]
pub struct Printer {
    /// `[NAME] ` before each line.
    pub prefix: bool,
    /// Where to.
    pub out: Output,
}

impl Printer {
    fn line(&self, target: &Target, line: &str) -> Result<(), CliError> {
        let text = if self.prefix {
            format!("[{}] {line}\n", target.instance)
        } else {
            format!("{line}\n")
        };
        self.out.result(&text)
    }

    fn news(&self, target: &Target, news: LogNews) -> Result<(), CliError> {
        let name = &target.instance;
        match news {
            LogNews::Line(line) => return self.line(target, &line),
            LogNews::Broke(why) => self.out.say(&format!(
                "rtsctl: the log of component/{name} broke off: {why}; trying again"
            )),
            LogNews::Back(gap) => {
                self.out
                    .say(&format!("rtsctl: the log of component/{name} goes on"));
                if gap {
                    let text =
                        format!("lines of component/{name} may be missing: they had no times");
                    self.out.warn(&text);
                }
            }
            LogNews::End => {}
        }
        Ok(())
    }
}

/// Prints until all logs have ended; those that are followed do not. Of several, one that has no previous incarnation is
/// only told of, as long as another one has.
pub async fn print(
    controller: &Controller,
    targets: &[Target],
    query: &LogQuery,
    printer: &Printer,
) -> Result<Exit, CliError> {
    let log = |target: &Target| Log::new(controller, &target.node, &target.instance, query.clone());
    let logs: Vec<Log> = targets.iter().map(log).collect();
    let failure = if query.follow {
        as_they_come(logs, targets, printer).await?
    } else {
        by_time(logs, targets, printer).await?
    };
    match failure {
        None => Ok(Exit::Ok),
        Some((index, error)) => Err(failed(&targets[index].instance, error, controller).await),
    }
}

async fn failed(name: &str, error: ClientError, controller: &Controller) -> CliError {
    match &error {
        ClientError::Problem(problem) if problem.status == 404 && problem.code == "not-found" => {
            unknown(name, controller).await
        }
        _ => CliError::request(format!("read the log of component/{name}"))(error),
    }
}

/// A log that failed, and why.
type Failure = Option<(usize, ClientError)>;

async fn as_they_come(
    logs: Vec<Log>,
    targets: &[Target],
    printer: &Printer,
) -> Result<Failure, CliError> {
    let (sender, mut receiver) = mpsc::channel(QUEUE);
    // Ends with this function.
    let mut tasks = JoinSet::new();
    for (index, mut log) in logs.into_iter().enumerate() {
        let sender = sender.clone();
        tasks.spawn(async move {
            loop {
                let news = log.next().await;
                let end = matches!(news, Err(_) | Ok(LogNews::End));
                if sender.send((index, news)).await.is_err() || end {
                    return;
                }
            }
        });
    }
    drop(sender);
    while let Some((index, news)) = receiver.recv().await {
        match news {
            Ok(news) => printer.news(&targets[index], news)?,
            Err(e) => return Ok(Some((index, e))),
        }
    }
    Ok(None)
}

fn has_no_previous(error: &ClientError) -> bool {
    matches!(error, ClientError::Problem(problem) if problem.code == "no-previous")
}

/// A line without a time belongs to the one before.
async fn by_time(
    mut logs: Vec<Log>,
    targets: &[Target],
    printer: &Printer,
) -> Result<Failure, CliError> {
    let mut times = vec![Timestamp::MIN; logs.len()];
    let mut heads = vec![None; logs.len()];
    let mut order = BTreeSet::new();
    let mut read: Vec<usize> = (0..logs.len()).collect();
    let mut lacking = Vec::new();
    loop {
        for index in read.drain(..) {
            match logs[index].next().await {
                Ok(LogNews::Line(line)) => {
                    // The clock may have been set back, the lines stay in their order.
                    times[index] = time_of(&line).unwrap_or(times[index]).max(times[index]);
                    order.insert((times[index], index));
                    heads[index] = Some(line);
                }
                Ok(_) => {}
                Err(e) if has_no_previous(&e) => lacking.push((index, e)),
                Err(e) => return Ok(Some((index, e))),
            }
        }
        let none = lacking.len() == logs.len();
        let failure = if none { lacking.pop() } else { None };
        for (_, e) in lacking.drain(..) {
            printer.out.say(&format!("rtsctl: {e}"));
        }
        if failure.is_some() {
            return Ok(failure);
        }
        let Some((_, index)) = order.pop_first() else {
            return Ok(None);
        };
        if let Some(line) = heads[index].take() {
            printer.line(&targets[index], &line)?;
        }
        read.push(index);
    }
}
