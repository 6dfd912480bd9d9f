//! Commands for the far side: words that its shell takes as they are, and short scripts whose answer is found among whatever the
//! shell's start-up files print.

use std::borrow::Cow;
use std::time::Duration;

use openssh::{Session, Stdio};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt};

use crate::answer::{after_mark, tame};

/// Most bytes of a script's answer, and of its complaints.
const MAX_OUTPUT: u64 = 1024 * 1024;
/// Exit code of a shell whose command is not there.
const NOT_FOUND: i32 = 127;

/// What a script on the far side came to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ran {
    /// Exit code; none when a signal ended it.
    pub code: Option<i32>,
    /// Standard output, without what start-up files print. Untrusted; at most 1 MiB.
    pub out: Vec<u8>,
    /// Standard error, fit to be shown.
    pub err: String,
}

/// Why a script did not run to its end.
#[derive(Debug)]
pub(crate) enum NotRun {
    /// The connection is gone, or the multiplexer refuses.
    Mux(openssh::Error),
    /// It took too long.
    Late,
    /// Something ran, but no POSIX shell that answered.
    NoShell(String),
}

/// A line that no start-up file prints.
pub(crate) fn mark() -> String {
    format!("rtsctl-{}", uuid::Uuid::new_v4().simple())
}

/// A command line for whatever shell the account has: `/bin/sh` runs the script, which prints the mark first. The script's own
/// words have no quotes that differ between shells.
pub(crate) fn command_line(script: &str, mark: &str, arguments: &[&str]) -> String {
    let script = format!("echo \"$0\"; {}", one_line(script));
    let words = ["/bin/sh", "-c", &script, mark];
    let mut line = "exec".to_owned();
    for word in words.iter().chain(arguments) {
        line.push(' ');
        line.push_str(&quoted(word));
    }
    line
}

/// A script on one line, without its comments: some shells take no line break within quotes.
fn one_line(script: &str) -> String {
    let lines = script.lines().map(str::trim);
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.collect::<Vec<_>>().join(" ")
}

/// A word as a shell takes it.
fn quoted(word: &str) -> Cow<'_, str> {
    shell_escape::unix::escape(word.into())
}

/// Runs a script with `input` on its standard input.
pub(crate) async fn run(
    session: &Session,
    script: &str,
    arguments: &[&str],
    input: &[u8],
    limit: Duration,
) -> Result<Ran, NotRun> {
    let work = async {
        let mark = mark();
        let mut child = session
            .raw_command(command_line(script, &mark, arguments))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .await
            .map_err(NotRun::Mux)?;
        let stdin = child.stdin().take();
        let (stdout, stderr) = (child.stdout().take(), child.stderr().take());
        let write = async {
            if let Some(mut stdin) = stdin {
                // A script that ends early says itself why.
                let _ = stdin.write_all(input).await;
                let _ = stdin.shutdown().await;
            }
        };
        let ((), out, err) = tokio::join!(write, read_some(stdout), read_some(stderr));
        let code = ended(child.wait().await).map_err(NotRun::Mux)?;
        let err = tame(&String::from_utf8_lossy(&err));
        match after_mark(&out, &mark) {
            Some(out) => Ok(Ran {
                code,
                out: out.to_owned(),
                err,
            }),
            None if code.is_none() => Err(NotRun::Mux(openssh::Error::RemoteProcessTerminated)),
            None => {
                let said = tame(&String::from_utf8_lossy(&out));
                Err(NotRun::NoShell(format!("{said} {err}").trim().to_owned()))
            }
        }
    };
    tokio::time::timeout(limit, work)
        .await
        .unwrap_or(Err(NotRun::Late))
}

/// The exit code of what ended; none for a signal.
pub(crate) fn ended(
    status: Result<std::process::ExitStatus, openssh::Error>,
) -> Result<Option<i32>, openssh::Error> {
    match status {
        Ok(status) => Ok(status.code()),
        Err(openssh::Error::RemoteProcessTerminated) => Ok(None),
        Err(openssh::Error::Remote(e)) if e.kind() == std::io::ErrorKind::NotFound => {
            Ok(Some(NOT_FOUND))
        }
        Err(e) => Err(e),
    }
}

/// Reads to the end, and keeps the beginning.
pub(crate) async fn read_some(stream: Option<impl AsyncRead + Unpin>) -> Vec<u8> {
    let mut kept = Vec::new();
    if let Some(mut stream) = stream {
        let _ = (&mut stream).take(MAX_OUTPUT).read_to_end(&mut kept).await;
        let _ = tokio::io::copy(&mut stream, &mut tokio::io::sink()).await;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::process::Command;

    fn sh(shell: &str, line: &str) -> Vec<u8> {
        Command::new(shell)
            .args(["-c", line])
            .output()
            .unwrap()
            .stdout
    }

    #[test]
    fn a_script_is_one_line_that_prints_its_mark() {
        let line = command_line("# why\necho a;\n\n  echo \"$1\";\n", "m", &["x y"]);
        assert_eq!(
            line,
            r#"exec /bin/sh -c 'echo "$0"; echo a; echo "$1";' m 'x y'"#
        );
        assert_eq!(sh("sh", &line), b"m\na\nx y\n");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn every_word_arrives_as_it_is(words in prop::collection::vec("[ -~\\n\u{e9}]{0,12}", 0..4)) {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let line = command_line("for w in \"$@\"; do printf %s/ \"$w\"; done", "m", &words);
            let want: String = words.iter().map(|word| format!("{word}/")).collect();
            prop_assert_eq!(sh("sh", &line), format!("m\n{want}").into_bytes());
        }
    }
}
