//! What was copied there and nobody needs any more: old versions of programs and modules, and those of homes that have gone.
//!
//! Each home that reaches nodes there has a lease, a file that names the programs that it uses; so has who installs a service, as long
//! as that lasts. It is written before anything is copied. Kept is what a lease, a service, a ledger, or a process or its command names, a module for a
//! week after its last use, and anything that was used within minutes. A lease that was not renewed for a month has ended. What
//! cannot be read may name anything: then nothing is removed.

use sha2::{Digest, Sha256};

use crate::answer::tame;
use crate::collected::Collected;
use crate::error::SshError;
use crate::session::Session;

const SCRIPT: &str = include_str!("copies.sh");

/// Digits of a lease's name.
const NAME: usize = 16;

/// The name of a lease: one for each home of each machine.
pub fn lease_name(machine: &str, home: &str, node: &str) -> String {
    let mut hash = Sha256::new();
    for part in [machine, home, node] {
        hash.update(part.as_bytes());
        hash.update([0]);
    }
    let mut name = format!("{:x}", hash.finalize());
    name.truncate(NAME);
    name
}

/// The lease of who installs the service of a node: nobody else's clean-up takes away what that does not name yet.
pub(crate) fn service_lease(home: &str, node: &str) -> String {
    lease_name("service", home, node)
}

/// Where a lease lies in a home there.
pub(crate) fn place(home: &str, lease: &str) -> String {
    format!("{}/leases/{lease}", home.trim_end_matches('/'))
}

/// What is done with what keeps copies, before those are removed that nothing keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim<'a> {
    /// The lease of this name is renewed: it keeps the programs with these digests.
    Keep(&'a str, &'a [&'a str]),
    /// The lease of this name ends.
    End(&'a str),
    /// The service and the ledger of this node keep nothing any more: they are about to be removed. Nor does what installed it,
    /// if that did not come to its end.
    Leave {
        /// The node.
        node: &'a str,
        /// The lease of who installs its service.
        lease: &'a str,
    },
}

impl Claim<'_> {
    /// The words of the script behind the home, and its standard input.
    fn words(&self) -> ([&str; 3], String) {
        match self {
            Claim::Keep(lease, digests) => ([lease, "keep", ""], digests.join("\n")),
            Claim::End(lease) => ([lease, "end", ""], String::new()),
            Claim::Leave { node, lease } => ([lease, "end", node], String::new()),
        }
    }
}

/// Removes what nobody needs.
pub(crate) async fn collect(
    session: &Session,
    home: &str,
    claim: Claim<'_>,
) -> Result<Collected, SshError> {
    let what = "which copies are needed";
    let ([lease, verb, node], list) = claim.words();
    let ran = session
        .run_with(what, SCRIPT, &[home, lease, verb, node], list.as_bytes())
        .await?;
    Collected::parse(&ran.out).ok_or_else(|| SshError::Answer {
        host: session.host().to_owned(),
        what: what.to_owned(),
        said: tame(&format!(
            "{} {}",
            String::from_utf8_lossy(&ran.out),
            ran.err
        )),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use std::process::{Command, Stdio};
    use std::time::{Duration, SystemTime};

    /// The answer of the script here, run behind `before`.
    fn answer(before: &str, home: &Path, claim: Claim<'_>) -> String {
        use std::io::Write;
        let (words, list) = claim.words();
        let mut sh = Command::new("/bin/sh")
            .args(["-c", &format!("{before}{SCRIPT}"), "sh"])
            .arg(home)
            .args(words)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = sh.stdin.take().unwrap();
        stdin.write_all(list.as_bytes()).unwrap();
        drop(stdin);
        let out = sh.wait_with_output().unwrap();
        String::from_utf8(out.stdout).unwrap()
    }

    /// The digests that are left.
    fn left(home: &Path) -> Vec<String> {
        let entries = ["programs", "modules"]
            .into_iter()
            .filter_map(|kind| std::fs::read_dir(home.join(kind)).ok());
        let names = entries.flatten().map(|entry| entry.unwrap().file_name());
        let mut left: Vec<_> = names.map(|name| name.into_string().unwrap()).collect();
        left.sort();
        left
    }

    /// The digests that are left when the script has run here.
    fn run(home: &Path, lease: &str, keep: &[&str]) -> Vec<String> {
        let claim = match keep {
            [] => Claim::End(lease),
            keep => Claim::Keep(lease, keep),
        };
        let said = answer("", home, claim);
        assert!(
            Collected::parse(said.as_bytes()).unwrap().told.is_empty(),
            "{said}"
        );
        left(home)
    }

    fn digest(n: u8) -> String {
        format!("{n:064x}")
    }

    fn put(home: &Path, kind: &str, n: u8, age: Duration) {
        let folder = home.join(kind).join(digest(n));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("file"), "x").unwrap();
        let opened = std::fs::File::open(&folder).unwrap();
        opened.set_modified(SystemTime::now() - age).unwrap();
    }

    #[test]
    fn what_nobody_needs_goes_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("it's home");
        let day = Duration::from_secs(24 * 3600);
        let put = |kind: &str, n: u8, age: Duration| put(&home, kind, n, age);
        put("programs", 0x11, day);
        put("programs", 0x12, day);
        put("programs", 0x13, day);
        put("programs", 0x14, Duration::ZERO);
        put("modules", 0x21, 30 * day);
        put("modules", 0x22, 30 * day);
        put("modules", 0x23, day);
        std::fs::create_dir_all(home.join("modules/by hand")).unwrap();
        for (path, text) in [
            ("services/leg.json", digest(0x12)),
            ("state/arm/node-spec.json", format!("\"{}\",", digest(0x21))),
        ] {
            let path = home.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        // Of programs 0x13 is of nobody, of modules 0x22.
        let kept = run(&home, "mine", &[&digest(0x11)]);
        let want = [0x11, 0x12, 0x14, 0x21, 0x23].map(digest);
        assert_eq!(kept[..5], want);
        assert_eq!(kept[5..], ["by hand"]);
        // Another home needs none of it, and its end takes nothing away.
        assert_eq!(run(&home, "other", &[&digest(0x99)]), kept);
        assert_eq!(run(&home, "other", &[]), kept);
        // A new version takes the place of the old one.
        let newer = run(&home, "mine", &[&digest(0x14)]);
        assert!(!newer.contains(&digest(0x11)) && newer.contains(&digest(0x14)));
        // With the last lease goes all but what a service or a ledger needs.
        let last = run(&home, "mine", &[]);
        assert_eq!(last, [digest(0x12), digest(0x21), "by hand".to_owned()]);
        assert!(!home.join("leases").exists());
        // A service that is being removed needs nothing any more.
        // Whoever installed it was cut off.
        run(&home, "installs", &[&digest(0x12)]);
        let (node, lease) = ("leg", "installs");
        answer("", &home, Claim::Leave { node, lease });
        assert_eq!(left(&home), [digest(0x21), "by hand".to_owned()]);
        let node = "arm";
        answer("", &home, Claim::Leave { node, lease });
        assert_eq!(left(&home), ["by hand"]);
        assert!(!home.join("programs").exists());
    }

    #[test]
    fn what_cannot_be_read_may_need_anything() {
        let home = tempfile::tempdir().unwrap();
        let home = home.path();
        put(home, "programs", 0x11, Duration::ZERO);
        // A folder cannot be read as a file, even by root.
        for ledger in ["services/arm.json", "state/arm/node-spec.2.json"] {
            std::fs::create_dir_all(home.join(ledger)).unwrap();
            let said = answer("", home, Claim::End("mine"));
            let told = Collected::parse(said.as_bytes()).unwrap().told.join(" ");
            assert!(
                told.contains(ledger) && told.ends_with("no copy was removed"),
                "{said}"
            );
            assert_eq!(left(home), [digest(0x11)]);
            std::fs::remove_dir(home.join(ledger)).unwrap();
        }
        assert!(run(home, "mine", &[]).is_empty());
    }

    #[test]
    fn a_lease_that_cannot_be_written_is_told_and_holds_up_nothing() {
        let home = tempfile::tempdir().unwrap();
        let home = home.path();
        put(home, "programs", 0x11, Duration::ZERO);
        put(home, "programs", 0x12, Duration::ZERO);
        let own = digest(0x11);
        std::fs::write(home.join("leases"), "in the way").unwrap();
        let said = answer("", home, Claim::Keep("mine", &[&own]));
        let collected = Collected::parse(said.as_bytes()).unwrap();
        assert_eq!(collected.removed, 1);
        assert_eq!(collected.told.len(), 1, "{said}");
        assert_eq!(left(home), [own.as_str()], "what the caller needs stays");
        // As on a full disk, where there is room once something has gone.
        put(home, "programs", 0x12, Duration::ZERO);
        let before =
            r#"rm() { if [ "$1" = -rf ]; then command rm -f "$h/leases"; fi; command rm "$@"; }; "#;
        let said = answer(before, home, Claim::Keep("mine", &[&own]));
        let collected = Collected::parse(said.as_bytes()).unwrap();
        assert_eq!((collected.removed, collected.told.len()), (1, 0), "{said}");
        let lease = std::fs::read_to_string(home.join("leases/mine")).unwrap();
        assert_eq!(lease.trim(), own);
    }

    #[test]
    fn who_names_a_copy_while_it_is_being_removed_gets_it_back() {
        let home = tempfile::tempdir().unwrap();
        let home = home.path();
        let day = Duration::from_secs(24 * 3600);
        put(home, "programs", 0x11, day);
        put(home, "programs", 0x12, day);
        // Somebody else writes a lease after all were read.
        std::fs::write(home.join("named"), digest(0x11)).unwrap();
        let before =
            r#"mv() { mkdir -p "$h/leases"; cp "$h/named" "$h/leases/other"; command mv "$@"; }; "#;
        let said = answer(before, home, Claim::End("mine"));
        assert_eq!(
            Collected::parse(said.as_bytes()).unwrap().removed,
            1,
            "{said}"
        );
        assert_eq!(left(home), [digest(0x11)]);
        assert!(
            home.join("programs")
                .join(digest(0x11))
                .join("file")
                .exists()
        );
        // What a clean-up that was killed has left goes with the next one.
        let killed = home
            .join("programs")
            .join(format!("{}.gone.999999999", digest(0x13)));
        std::fs::create_dir(&killed).unwrap();
        answer("", home, Claim::Keep("mine", &[]));
        assert!(!killed.exists());
    }

    #[test]
    fn what_the_command_of_a_process_names_stays() {
        let home = tempfile::tempdir().unwrap();
        let home = home.path();
        put(home, "programs", 0xa1, Duration::ZERO);
        // As an agent, which starts managers later.
        let manager = format!("{}/programs/{}/rts-manager", home.display(), digest(0xa1));
        let mut agent = Command::new("/bin/sh")
            .args(["-c", "echo; read line", "rts-agent", "--manager-program"])
            .arg(manager)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        // It runs its command.
        let mut out = agent.stdout.take().unwrap();
        std::io::Read::read_exact(&mut out, &mut [0]).unwrap();
        assert_eq!(run(home, "mine", &[]), [digest(0xa1)]);
        drop(agent.stdin.take());
        agent.wait().unwrap();
        assert!(run(home, "mine", &[]).is_empty());
    }

    #[test]
    fn a_lease_is_of_one_home_and_node() {
        let name = lease_name("m", "/h", "arm");
        assert_eq!(name.len(), NAME);
        assert_ne!(name, lease_name("m", "/ha", "rm"));
        assert_eq!(name, lease_name("m", "/h", "arm"));
    }
}
