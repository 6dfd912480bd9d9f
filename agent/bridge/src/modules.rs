//! Modules that far lacks: it asks by type name, near answers with the file that it would load itself, by digest, and far
//! takes its bytes unless it has them.

use std::io;
use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use tokio::fs::File;
use tokio::io::{AsyncBufRead, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::time::timeout;

use crate::hello::{self, HelloError};
use crate::mux::{Gone, Opener, Stream};
use crate::{Kind, hello::MAX_LINE};

/// Largest module in bytes.
pub const MAX_MODULE: u64 = 1 << 30;
/// Longest pause of a side that has something to say.
const PAUSE: Duration = Duration::from_secs(30);
/// Files that were looked for and are told.
const MAX_SEARCHED: usize = 32;

/// Far asks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Question {
    /// Type name of a component.
    pub type_name: String,
}

/// Near answers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "answer", rename_all = "camelCase")]
pub enum Answer {
    /// This file.
    File(Offer),
    /// There is none.
    None {
        /// Files that were looked for.
        searched: Vec<String>,
    },
    /// It cannot be read.
    Fails {
        /// Why.
        error: String,
    },
}

/// A file that near has.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Offer {
    /// Its name, without a folder.
    pub name: String,
    /// SHA-256, 64 hexadecimal digits.
    pub digest: String,
    /// Bytes.
    pub size: u64,
}

/// Whether far wants the bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Wanted {
    wanted: bool,
}

/// A module did not come.
#[derive(Debug, thiserror::Error)]
pub enum ModuleError {
    /// The connection.
    #[error(transparent)]
    Gone(#[from] Gone),
    /// A line.
    #[error(transparent)]
    Line(#[from] HelloError),
    /// A file, or the stream.
    #[error("cannot copy a module")]
    Io(#[from] io::Error),
    /// The other side said nothing for long.
    #[error("the other side said nothing for {} s", PAUSE.as_secs())]
    Late,
    /// What came is not what was said.
    #[error("{0}")]
    Wrong(String),
}

impl Offer {
    /// Whether its words can be trusted to name a file.
    pub fn is_sound(&self) -> bool {
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-.+".contains(c);
        !self.name.starts_with('.')
            && (1..=200).contains(&self.name.len())
            && self.name.chars().all(plain)
            && self.digest.len() == 64
            && self
                .digest
                .chars()
                .all(|c| matches!(c, '0'..='9' | 'a'..='f'))
            && self.size <= MAX_MODULE
    }
}

/// A question that was answered; the bytes can be taken now.
#[derive(Debug)]
pub struct Asked {
    /// The answer.
    pub answer: Answer,
    stream: BufReader<Stream>,
}

/// Far asks where the module of a type is.
pub async fn ask(opener: &Opener, type_name: &str) -> Result<Asked, ModuleError> {
    let mut stream = BufReader::new(opener.open(Kind::Module).await?);
    let question = Question {
        type_name: type_name.to_owned(),
    };
    hello::write(&mut stream, "", &question).await?;
    let answer: Answer = line(&mut stream).await?;
    if let Answer::File(offer) = &answer
        && !offer.is_sound()
    {
        let wrong = format!("a module is offered as {offer:?}, which is no file");
        return Err(ModuleError::Wrong(wrong));
    }
    Ok(Asked { answer, stream })
}

impl Asked {
    /// Far has the bytes already.
    pub async fn decline(mut self) -> Result<(), ModuleError> {
        Ok(hello::write(&mut self.stream, "", &Wanted { wanted: false }).await?)
    }

    /// Takes the bytes into a file; an error unless they have the digest that was said.
    pub async fn take(mut self, file: &mut File) -> Result<(), ModuleError> {
        let Answer::File(offer) = &self.answer else {
            return Err(ModuleError::Wrong("no file was offered".to_owned()));
        };
        hello::write(&mut self.stream, "", &Wanted { wanted: true }).await?;
        let mut hash = Sha256::new();
        let mut left = offer.size;
        let mut buffer = vec![0; 64 * 1024];
        while left > 0 {
            let most = usize::try_from(left).map_or(buffer.len(), |n| n.min(buffer.len()));
            let got = timeout(PAUSE, self.stream.read(&mut buffer[..most]));
            let got = got.await.map_err(|_| ModuleError::Late)??;
            if got == 0 {
                let wrong = format!("the module {} ended {left} bytes early", offer.name);
                return Err(ModuleError::Wrong(wrong));
            }
            hash.update(&buffer[..got]);
            file.write_all(&buffer[..got]).await?;
            left -= got as u64;
        }
        file.flush().await?;
        let got = format!("{:x}", hash.finalize());
        if got != offer.digest {
            let wrong = format!(
                "the module {} changed while it was sent: it has digest {got}, and {} was said",
                offer.name, offer.digest
            );
            return Err(ModuleError::Wrong(wrong));
        }
        Ok(())
    }
}

/// Near reads a question.
pub async fn asked(stream: Stream) -> Result<(Question, BufReader<Stream>), ModuleError> {
    let mut stream = BufReader::new(stream);
    let question = line(&mut stream).await?;
    Ok((question, stream))
}

/// Near answers, and sends the file if far wants it.
pub async fn answer(
    mut stream: BufReader<Stream>,
    mut answer: Answer,
    path: &Path,
) -> Result<u64, ModuleError> {
    if let Answer::None { searched } = &mut answer {
        fit(searched);
    }
    hello::write(&mut stream, "", &answer).await?;
    let Answer::File(offer) = answer else {
        return Ok(0);
    };
    let wanted: Wanted = line(&mut stream).await?;
    if !wanted.wanted {
        return Ok(0);
    }
    let mut file = File::open(path).await?.take(offer.size);
    let mut buffer = vec![0; 64 * 1024];
    loop {
        let got = file.read(&mut buffer).await?;
        if got == 0 {
            break;
        }
        let sent = timeout(PAUSE, stream.write_all(&buffer[..got])).await;
        sent.map_err(|_| ModuleError::Late)??;
    }
    stream.shutdown().await?;
    Ok(offer.size)
}

/// Leaves out what would make the line too long.
fn fit(searched: &mut Vec<String>) {
    let mut bytes = 0;
    searched.truncate(MAX_SEARCHED);
    searched.retain(|path| {
        bytes += path.len() * 2 + 8;
        bytes < MAX_LINE / 2
    });
}

async fn line<T: serde::de::DeserializeOwned>(
    from: &mut (impl AsyncBufRead + Unpin),
) -> Result<T, ModuleError> {
    let read = timeout(PAUSE, hello::read(from)).await;
    Ok(read.map_err(|_| ModuleError::Late)??)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(name: &str) -> Offer {
        Offer {
            name: name.to_owned(),
            digest: "0".repeat(64),
            size: 1,
        }
    }

    #[test]
    fn only_plain_names_and_digests_name_a_file() {
        assert!(offer("libconsole_in.so").is_sound());
        for wrong in ["", ".", "..", "../x.so", "a/b.so", "a\nb", ".so"] {
            assert!(!offer(wrong).is_sound(), "{wrong:?}");
        }
        let long = Offer {
            size: MAX_MODULE + 1,
            ..offer("a.so")
        };
        let up = Offer {
            digest: "../".repeat(21) + "x",
            ..offer("a.so")
        };
        assert!(!long.is_sound() && !up.is_sound());
    }

    #[test]
    fn what_was_looked_for_fits_into_a_line() {
        let mut searched = vec!["x".repeat(3000); 100];
        fit(&mut searched);
        let line = serde_json::to_string(&Answer::None { searched }).unwrap();
        assert!(line.len() < MAX_LINE, "{}", line.len());
    }
}
