//! Requests and their answers.

use futures_util::future::BoxFuture;
use tokio::task::JoinHandle;
use tokio::time::sleep;

use super::{Fate, Net};
use crate::life::Life;

/// Nobody listens, or whoever listened is gone: the connection was reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reset;

/// What came of a request that came back at all.
pub type Asked<T> = Result<T, Reset>;

/// Makes the work that a request means at its receiver; twice when the request comes twice. None when nobody listens.
pub type Serve<T> = Box<dyn Fn() -> Option<(Life, BoxFuture<'static, T>)> + Send>;

impl Net {
    /// Sends a request and waits for the answer, for ever where one of the two is lost.
    pub async fn ask<T: Send + 'static>(
        &self,
        caller: &Life,
        to: &str,
        serve: Serve<T>,
    ) -> Asked<T> {
        let work = self.exchange(caller.host().to_owned(), to.to_owned(), serve);
        caller.call(work).await
    }

    async fn exchange<T: Send + 'static>(
        &self,
        from: String,
        to: String,
        serve: Serve<T>,
    ) -> Asked<T> {
        let fate = self.fate(&from, &to);
        // A message that does not arrive is waited for until the caller gives up.
        if !self.travel(&from, &to, &fate).await {
            return std::future::pending().await;
        }
        if let Some(again) = fate.again {
            self.again(&from, &to, again, &serve);
        }
        let answer = match serve() {
            Some((life, work)) => {
                let mut served = Served {
                    net: self.clone(),
                    ends: (from.clone(), to.clone()),
                    task: Some(tokio::spawn(alive(life, work))),
                };
                let answer = served.answer().await;
                served.task = None;
                answer
            }
            None => Err(Reset),
        };
        let fate = self.fate(&to, &from);
        if !self.travel(&to, &from, &fate).await {
            return std::future::pending().await;
        }
        answer
    }

    /// The second coming of a request: it is handled, and the answer goes nowhere.
    fn again<T: Send + 'static>(
        &self,
        from: &str,
        to: &str,
        after: std::time::Duration,
        serve: &Serve<T>,
    ) {
        let Some((life, work)) = serve() else { return };
        let (net, from, to) = (self.clone(), from.to_owned(), to.to_owned());
        tokio::spawn(async move {
            sleep(after).await;
            if net.is_open(&from, &to) && !life.is_over() {
                let _ = alive(life, work).await;
            }
        });
    }
}

/// What a program does, for as long as it lives.
async fn alive<T>(life: Life, work: impl Future<Output = T>) -> Asked<T> {
    tokio::select! {
        biased;
        () = life.over() => Err(Reset),
        done = life.call(work) => Ok(done),
    }
}

/// Work at the receiver of a request, whose caller may go away.
struct Served<T: Send + 'static> {
    net: Net,
    ends: (String, String),
    task: Option<JoinHandle<Asked<T>>>,
}

impl<T: Send + 'static> Served<T> {
    async fn answer(&mut self) -> Asked<T> {
        match &mut self.task {
            Some(task) => task.await.unwrap_or(Err(Reset)),
            None => Err(Reset),
        }
    }
}

impl<T: Send + 'static> Drop for Served<T> {
    fn drop(&mut self) {
        let Some(task) = self.task.take() else { return };
        if tokio::runtime::Handle::try_current().is_err() {
            return;
        }
        let (net, (from, to)) = (self.net.clone(), self.ends.clone());
        tokio::spawn(async move {
            let fate: Fate = net.fate(&from, &to);
            if net.travel(&from, &to, &fate).await {
                task.abort();
            }
        });
    }
}
