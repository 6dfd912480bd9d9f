//! What both sides say before the first stream: lines of JSON.
//!
//! Far begins with a line that starts with [`MARK`]: what a login shell prints before it is passed over. Near answers; then
//! far says whether it serves.

use serde::{Deserialize, Serialize, de::DeserializeOwned};
use tokio::io::{AsyncBufRead, AsyncBufReadExt, AsyncReadExt, AsyncWrite, AsyncWriteExt};

/// Begins the first line of far.
pub const MARK: &str = "rts-agent-stdio ";
/// Longest line in bytes.
pub const MAX_LINE: usize = 16 * 1024;
/// Most bytes that may come before the mark.
pub const MAX_NOISE: usize = 256 * 1024;

/// What far says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct FarHello {
    /// [`crate::VERSION`].
    pub version: u32,
    /// Version of the program.
    pub program: String,
}

/// What near says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct NearHello {
    /// [`crate::VERSION`].
    pub version: u32,
    /// Version of the program.
    pub program: String,
}

/// Whether far serves.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "camelCase")]
pub enum Outcome {
    /// It does.
    Serves {
        /// An agent that lives there keeps the node; this session only leads to it.
        resident: bool,
    },
    /// It does not.
    Fails {
        /// Why, for people.
        error: String,
    },
}

/// A line that is not what was expected.
#[derive(Debug, thiserror::Error)]
pub enum HelloError {
    /// The stream ended or failed.
    #[error("the stream failed")]
    Io(#[from] std::io::Error),
    /// It ended without a word.
    #[error("the other side ended{}", said(.0))]
    Ended(String),
    /// Too much came before the mark.
    #[error("rts-agent did not begin within {MAX_NOISE} bytes{}", said(.0))]
    Noise(String),
    /// A line that is longer than [`MAX_LINE`], or not the JSON that was expected.
    #[error("a greeting cannot be understood: {0}")]
    Wrong(String),
}

/// The end of what was said instead, for a message.
fn said(noise: &str) -> String {
    match noise.trim() {
        "" => String::new(),
        noise => format!("; it said {noise:?}"),
    }
}

/// Decodes one line, without its end.
pub fn decode<T: DeserializeOwned>(line: &[u8]) -> Result<T, HelloError> {
    serde_json::from_slice(line).map_err(|e| HelloError::Wrong(e.to_string()))
}

/// Reads one line and decodes it.
pub async fn read<T: DeserializeOwned>(
    from: &mut (impl AsyncBufRead + Unpin),
) -> Result<T, HelloError> {
    let line = line(from).await?;
    let line = line.ok_or_else(|| HelloError::Ended(String::new()))?;
    decode(&line)
}

/// Reads the first line of far, and passes over what comes before it.
pub async fn read_marked<T: DeserializeOwned>(
    from: &mut (impl AsyncBufRead + Unpin),
) -> Result<T, HelloError> {
    let mut noise = Noise::default();
    loop {
        // A prompt has no line end: the mark may begin anywhere in a line.
        let Some(line) = line(from).await? else {
            return Err(HelloError::Ended(noise.last));
        };
        match find(&line, MARK.as_bytes()) {
            Some(at) => return decode(&line[at + MARK.len()..]),
            None => noise.add(&line)?,
        }
    }
}

/// Writes one line.
pub async fn write(
    to: &mut (impl AsyncWrite + Unpin),
    mark: &str,
    what: &impl Serialize,
) -> Result<(), HelloError> {
    let json = serde_json::to_string(what).map_err(|e| HelloError::Wrong(e.to_string()))?;
    to.write_all(format!("{mark}{json}\n").as_bytes()).await?;
    Ok(to.flush().await?)
}

/// What came before the mark.
#[derive(Default)]
struct Noise {
    bytes: usize,
    last: String,
}

impl Noise {
    /// Characters that are kept for a message.
    const KEPT: usize = 200;

    fn add(&mut self, line: &[u8]) -> Result<(), HelloError> {
        self.bytes += line.len() + 1;
        let text = String::from_utf8_lossy(line);
        if !text.trim().is_empty() {
            self.last = text.trim().chars().take(Self::KEPT).collect();
        }
        match self.bytes > MAX_NOISE {
            true => Err(HelloError::Noise(std::mem::take(&mut self.last))),
            false => Ok(()),
        }
    }
}

/// The next line without its end; none at the end of the stream.
async fn line(from: &mut (impl AsyncBufRead + Unpin)) -> Result<Option<Vec<u8>>, HelloError> {
    let mut line = Vec::new();
    // One byte more than the longest with its end.
    let limit = u64::try_from(MAX_LINE + 2).unwrap_or(u64::MAX);
    from.take(limit).read_until(b'\n', &mut line).await?;
    match line.pop() {
        None => Ok(None),
        Some(b'\n') => Ok(Some(line)),
        Some(_) if line.len() > MAX_LINE => Err(HelloError::Wrong(format!(
            "a line has more than {MAX_LINE} bytes"
        ))),
        Some(last) => {
            // The last line of a stream that has ended.
            line.push(last);
            Ok(Some(line))
        }
    }
}

fn find(line: &[u8], mark: &[u8]) -> Option<usize> {
    line.windows(mark.len()).position(|window| window == mark)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use tokio::io::BufReader;

    fn hello() -> FarHello {
        FarHello {
            version: 1,
            program: "0.1.0".to_owned(),
        }
    }

    async fn marked(bytes: &[u8]) -> Result<FarHello, HelloError> {
        read_marked(&mut BufReader::new(bytes)).await
    }

    #[tokio::test]
    async fn what_a_shell_prints_before_is_passed_over() {
        let mut bytes = b"Welcome!\n\n$ ".to_vec();
        write(&mut bytes, MARK, &hello()).await.unwrap();
        assert_eq!(marked(&bytes).await.unwrap(), hello());
    }

    #[tokio::test]
    async fn what_was_said_instead_is_told() {
        let error = marked(b"rc\nsh: 1: rts-agent: not found\n").await;
        let error = error.unwrap_err().to_string();
        assert_eq!(
            error,
            "the other side ended; it said \"sh: 1: rts-agent: not found\""
        );
        let noise = vec![b'\n'; MAX_NOISE + 1];
        let error = marked(&noise).await.unwrap_err();
        assert!(matches!(error, HelloError::Noise(_)), "{error}");
        let long = vec![b'x'; MAX_LINE + 2];
        let error = marked(&long).await.unwrap_err();
        assert!(error.to_string().contains("16384 bytes"), "{error}");
    }

    #[tokio::test]
    async fn an_outcome_is_written_as_it_is_read() {
        for outcome in [
            Outcome::Serves { resident: true },
            Outcome::Fails {
                error: "no space left on device".to_owned(),
            },
        ] {
            let mut bytes = Vec::new();
            write(&mut bytes, "", &outcome).await.unwrap();
            let back: Outcome = read(&mut BufReader::new(bytes.as_slice())).await.unwrap();
            assert_eq!(back, outcome);
        }
    }

    proptest! {
        #[test]
        fn a_greeting_is_found_behind_whatever_has_no_mark(noise in "[a-z \n]{0,300}") {
            let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
            runtime.block_on(async {
                let mut bytes = noise.into_bytes();
                write(&mut bytes, MARK, &hello()).await.unwrap();
                prop_assert_eq!(marked(&bytes).await.unwrap(), hello());
                Ok(())
            })?;
        }
    }
}
