//! A connection from its greeting to its end.

use std::io;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, BufReader, join};
use tokio::task::JoinHandle;
use tokio::time::timeout;
use yamux::Mode;

use crate::hello::{self, FarHello, HelloError, MARK, NearHello, Outcome};
use crate::mux::{Incoming, Opener, begin};
use crate::{Kind, VERSION, pulse};

/// Longest wait for the other side's first line.
const GREETING: Duration = Duration::from_secs(15);
/// Longest wait until far serves: it takes its node from the one before, and meets the managers that run.
const SERVES: Duration = Duration::from_secs(30);

/// There is no connection.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The other side did not greet.
    #[error(transparent)]
    Hello(#[from] HelloError),
    /// It did not greet in time.
    #[error("the other side did not {what} within {} s", limit.as_secs())]
    Late {
        /// What was waited for.
        what: &'static str,
        /// How long.
        limit: Duration,
    },
    /// It speaks another version.
    #[error(
        "the other side speaks version {there} of the bridge, this one {VERSION}: upgrade the older of the two"
    )]
    Version {
        /// That version.
        there: u32,
    },
    /// Far does not serve.
    #[error("the agent there does not serve: {0}")]
    Refused(String),
    /// The connection ended at once.
    #[error("the connection ended at once")]
    Gone(#[from] crate::mux::Gone),
}

/// A connection. It ends when this is dropped.
#[derive(Debug)]
pub struct Link {
    /// Opens streams.
    pub opener: Opener,
    /// The streams of the other side.
    pub incoming: Incoming,
    driver: JoinHandle<String>,
}

impl Link {
    /// Waits for its end, and says why it ended.
    pub async fn ended(&mut self) -> String {
        match (&mut self.driver).await {
            Ok(why) => why,
            Err(e) => e.to_string(),
        }
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.driver.abort();
    }
}

/// Near's end of a connection.
#[derive(Debug)]
pub struct Near {
    /// The connection.
    pub link: Link,
    /// An agent that lives there keeps the node.
    pub resident: bool,
    /// Signs of life.
    pub pulse: pulse::Near,
}

/// Opens near's end: greets, and waits until far serves.
pub async fn near(
    from: impl AsyncRead + Send + Unpin + 'static,
    mut to: impl AsyncWrite + Send + Unpin + 'static,
    program: &str,
) -> Result<Near, LinkError> {
    let mut from = BufReader::new(from);
    let greeting = hello::read_marked::<FarHello>(&mut from);
    let there = within(GREETING, "greet", greeting).await?;
    check(there.version)?;
    let own = NearHello {
        version: VERSION,
        program: program.to_owned(),
    };
    hello::write(&mut to, "", &own).await?;
    let outcome = hello::read::<Outcome>(&mut from);
    let resident = match within(SERVES, "serve", outcome).await? {
        Outcome::Serves { resident } => resident,
        Outcome::Fails { error } => return Err(LinkError::Refused(error)),
    };
    let link = linked(from, to, Mode::Client);
    let pulse = pulse::Near::new(link.opener.open(Kind::Pulse).await?);
    Ok(Near {
        link,
        resident,
        pulse,
    })
}

/// Far's end of a connection before it serves.
#[derive(Debug)]
pub struct Far<R, W> {
    from: BufReader<R>,
    to: W,
}

/// Opens far's end: greets. It must say then whether it serves.
pub async fn far<R, W>(from: R, mut to: W, program: &str) -> Result<Far<R, W>, LinkError>
where
    R: AsyncRead + Send + Unpin + 'static,
    W: AsyncWrite + Send + Unpin + 'static,
{
    let mut from = BufReader::new(from);
    let own = FarHello {
        version: VERSION,
        program: program.to_owned(),
    };
    hello::write(&mut to, MARK, &own).await?;
    let greeting = hello::read::<NearHello>(&mut from);
    check(within(GREETING, "greet", greeting).await?.version)?;
    Ok(Far { from, to })
}

impl<R, W> Far<R, W>
where
    R: AsyncRead + Send + Unpin + 'static,
    W: AsyncWrite + Send + Unpin + 'static,
{
    /// It serves.
    pub async fn serves(mut self, resident: bool) -> Result<Link, LinkError> {
        hello::write(&mut self.to, "", &Outcome::Serves { resident }).await?;
        Ok(linked(self.from, self.to, Mode::Server))
    }

    /// It does not.
    pub async fn fails(mut self, error: String) -> Result<(), LinkError> {
        Ok(hello::write(&mut self.to, "", &Outcome::Fails { error }).await?)
    }
}

fn linked(
    from: impl AsyncRead + Send + Unpin + 'static,
    to: impl AsyncWrite + Send + Unpin + 'static,
    mode: Mode,
) -> Link {
    let (opener, incoming, driver) = begin(join(from, to), mode);
    Link {
        opener,
        incoming,
        driver,
    }
}

fn check(there: u32) -> Result<(), LinkError> {
    match there == VERSION {
        true => Ok(()),
        false => Err(LinkError::Version { there }),
    }
}

async fn within<T>(
    limit: Duration,
    what: &'static str,
    work: impl Future<Output = Result<T, HelloError>>,
) -> Result<T, LinkError> {
    match timeout(limit, work).await {
        Ok(done) => Ok(done?),
        Err(_) => Err(LinkError::Late { what, limit }),
    }
}

impl From<io::Error> for LinkError {
    fn from(e: io::Error) -> Self {
        Self::Hello(e.into())
    }
}

#[cfg(test)]
mod tests;
