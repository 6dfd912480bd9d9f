//! From what `ssh` said when it gave up to the error that it means. What is not known is shown as it is.

use crate::answer::tame;
use crate::error::SshError;
use crate::log::Log;

/// Words of `ssh` for a machine that is not there.
const UNREACHABLE: [&str; 9] = [
    "Could not resolve hostname",
    "Connection refused",
    "No route to host",
    "Network is unreachable",
    "Connection reset",
    "Broken pipe",
    "Connection closed by",
    "kex_exchange_identification",
    "ssh: connect to host",
];

/// Why a connection did not come about. `said`: what came instead of the answer of our command.
pub(crate) fn refusal(host: &str, log: &Log, seconds: u64, said: &[u8]) -> SshError {
    let host = host.to_owned();
    let key = log.host_key.clone();
    if log.sent {
        return instead(host, log, said);
    }
    if log.has("Host key verification failed") || log.has("host key is known for") {
        let changed = log.has("HOST IDENTIFICATION HAS CHANGED")
            || log.has("has changed and you have requested");
        return match changed {
            true => SshError::ChangedHostKey {
                host,
                key,
                known: offending(log),
            },
            false => SshError::UnknownHostKey { host, key },
        };
    }
    if log.has(": Permission denied (") || log.has("Too many authentication failures") {
        return SshError::Refused {
            host,
            target: log.target.clone(),
            offered: log.offered.clone(),
            methods: log.methods.clone(),
            said: log.text(),
        };
    }
    if log.has("timed out") {
        return SshError::TimedOut {
            host,
            what: log.text(),
            seconds,
        };
    }
    if UNREACHABLE.iter().any(|words| log.has(words)) {
        return SshError::Unreachable {
            host,
            said: log.text(),
        };
    }
    let said = match log.text() {
        said if said.is_empty() => "`ssh` ended without a word".to_owned(),
        said => said,
    };
    SshError::Failed {
        host,
        what: "be reached".to_owned(),
        said,
    }
}

/// Somebody was let in, and what was sent did not run: something else did, or the connection was lost meanwhile.
pub(crate) fn instead(host: String, log: &Log, said: &[u8]) -> SshError {
    if !log.ran && log.forced.is_none() {
        let said = log.last().to_owned();
        return SshError::Lost { host, said };
    }
    let said = tame(&String::from_utf8_lossy(said));
    let words = [said, log.text()];
    let words: Vec<_> = words.into_iter().filter(|said| !said.is_empty()).collect();
    SshError::Forced {
        host,
        place: log.forced.clone(),
        said: words.join("; "),
    }
}

/// `Offending ED25519 key in /home/pi/.ssh/known_hosts:3`.
fn offending(log: &Log) -> Option<String> {
    let line = log.lines().find(|line| line.starts_with("Offending "))?;
    Some(line.split_once(" key in ")?.1.to_owned())
}

/// What the far side said when it could not write a file; `None` for what is not known.
pub(crate) fn of_file(
    host: &str,
    path: &str,
    needed: u64,
    free: Option<u64>,
    said: &str,
) -> Option<SshError> {
    let (host, path) = (host.to_owned(), path.to_owned());
    let has = |words: &[&str]| words.iter().any(|words| said.contains(words));
    if has(&["No space left", "quota exceeded"]) {
        return Some(SshError::Full {
            host,
            path,
            needed,
            free,
        });
    }
    if has(&[
        "Permission denied",
        "Read-only file system",
        "Operation not permitted",
    ]) {
        return Some(SshError::NotPermitted {
            host,
            path,
            said: said.to_owned(),
        });
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> SshError {
        let mut log = Log::default();
        text.lines().for_each(|line| log.add(line));
        refusal("robot", &log, 10, b"hi\n")
    }

    fn shown(text: &str) -> String {
        let error = of(text);
        format!("{error}\nhelp: {}", error.help().unwrap_or_default())
    }

    // What is tried here was said by OpenSSH 9.2. tests/real.rs provokes each of these at a server.

    #[test]
    fn an_unknown_key_is_named() {
        insta::assert_snapshot!(shown(
            "debug1: Server host key: ssh-ed25519 SHA256:abc\n\
             No ED25519 host key is known for robot and you have requested strict checking.\n\
             Host key verification failed.\n"
        ));
    }

    #[test]
    fn a_changed_key_is_named_with_where_the_old_one_is() {
        insta::assert_snapshot!(shown(
            "debug1: Server host key: ssh-ed25519 SHA256:abc\n\
             @    WARNING: REMOTE HOST IDENTIFICATION HAS CHANGED!     @\n\
             Offending ED25519 key in /home/pi/.ssh/known_hosts:3\n\
             Host key for robot has changed and you have requested strict checking.\n\
             Host key verification failed.\n"
        ));
    }

    #[test]
    fn a_refused_key_is_told_with_what_was_offered() {
        insta::assert_snapshot!(shown(
            "debug1: Authenticating to robot:22 as 'pi'\n\
             debug1: Authentications that can continue: publickey,password\n\
             debug1: Offering public key: /home/me/.ssh/id_ed25519 ED25519 SHA256:abc explicit\n\
             pi@robot: Permission denied (publickey,password).\n"
        ));
    }

    #[test]
    fn a_command_that_is_forced_is_told_with_what_it_said() {
        insta::assert_snapshot!(shown(
            "Authenticated to robot ([10.0.0.5]:22) using \"publickey\".\n\
             debug1: Remote: /home/pi/.ssh/authorized_keys:1: key options: agent-forwarding command pty\n\
             debug1: Sending command: exec /bin/sh\n\
             debug1: client_input_channel_req: channel 0 rtype exit-status reply 0\n\
             Transferred: sent 3480, received 3340 bytes, in 0.5 seconds\n"
        ), @r"
        robot let us in and ran something else than what it was sent, as /home/pi/.ssh/authorized_keys:1 forces it to: hi
        help: the key has a forced command (`command=`), so that nothing else can be run: let in a key without one, or log in as another account
        ");
        let settings = "debug1: Remote: /x:1: key options: pty\ndebug1: Sending command: x\ndebug1: client_input_channel_req: channel 0 rtype exit-status reply 0";
        assert!(
            matches!(of(settings), SshError::Forced { place: None, .. }),
            "it may be the server's settings or the account's shell"
        );
        let cut = "debug1: Sending command: x\nConnection to robot closed by remote host.";
        assert!(matches!(of(cut), SshError::Lost { .. }), "it never ran");
        let early = of("client_loop: send disconnect: Broken pipe");
        assert!(early.was_cut() && early.is_passing(), "{early}");
    }

    #[test]
    fn silence_and_refusal_of_the_network_are_told_apart() {
        assert!(matches!(
            of("ssh: connect to host x port 22: Connection refused"),
            SshError::Unreachable { .. }
        ));
        assert!(matches!(
            of("ssh: connect to host x port 22: Permission denied"),
            SshError::Unreachable { .. }
        ));
        assert!(matches!(
            of("ssh: connect to host x port 22: Connection timed out"),
            SshError::TimedOut { .. }
        ));
        assert!(matches!(
            of("ssh: Could not resolve hostname x: Name or service not known"),
            SshError::Unreachable { .. }
        ));
    }

    #[test]
    fn what_is_not_known_is_shown_as_it_is() {
        insta::assert_snapshot!(shown("/x/config: line 3: Bad configuration option: frob"), @r"
        robot cannot be reached: /x/config: line 3: Bad configuration option: frob
        help: 
        ");
        assert!(of("").to_string().contains("without a word"));
    }

    #[test]
    fn what_a_file_met_is_known_by_its_words() {
        let of = |said| of_file("robot", "/x", 10, Some(4), said);
        assert!(matches!(
            of("cat: write error: No space left on device"),
            Some(SshError::Full { .. })
        ));
        assert!(matches!(
            of("mkdir: /x: Permission denied"),
            Some(SshError::NotPermitted { .. })
        ));
        assert!(of("something else").is_none());
    }
}
