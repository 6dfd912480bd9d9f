//! What was copied there and nobody needs any more: old versions of programs and modules, and those of homes that have gone.
//!
//! Each home that reaches nodes there has a lease, a file that names the programs that it uses. Kept is what a lease, a service,
//! a ledger or a process names, a module for a week after its last use, and anything that was used within minutes. A lease that
//! was not renewed for a month has ended.

use sha2::{Digest, Sha256};

use crate::error::SshError;
use crate::session::Session;
use crate::store::hex;

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
    let mut name = hex(hash);
    name.truncate(NAME);
    name
}

/// Renews a lease, or ends it when there is nothing to keep, and removes what nobody needs. How many digests were removed.
pub(crate) async fn collect(
    session: &Session,
    home: &str,
    lease: &str,
    keep: &[&str],
) -> Result<usize, SshError> {
    let what = "which copies are needed";
    let verb = if keep.is_empty() { "drop" } else { "keep" };
    let list: String = keep.iter().map(|digest| format!("{digest}\n")).collect();
    let words = [home, lease, verb];
    let ran = session
        .run_with(what, SCRIPT, &words, list.as_bytes())
        .await?;
    let answer = String::from_utf8_lossy(&ran.out);
    if answer.lines().last() != Some("done") {
        let said = answer.lines().last().unwrap_or_default();
        return Err(SshError::Failed {
            host: session.host().to_owned(),
            what: "tell which copies are needed".to_owned(),
            said: crate::answer::tame(&format!("{said} {}", ran.err)),
        });
    }
    let gone = answer.lines().filter(|line| line.starts_with("gone "));
    Ok(gone.count())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use std::process::{Command, Stdio};
    use std::time::{Duration, SystemTime};

    /// What the script does here, and the digests that are left.
    fn run(home: &Path, lease: &str, keep: &[&str]) -> Vec<String> {
        use std::io::Write;
        let verb = if keep.is_empty() { "drop" } else { "keep" };
        let mut sh = Command::new("/bin/sh")
            .args(["-c", SCRIPT, "sh"])
            .arg(home)
            .args([lease, verb])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = sh.stdin.take().unwrap();
        for digest in keep {
            writeln!(stdin, "{digest}").unwrap();
        }
        drop(stdin);
        let out = sh.wait_with_output().unwrap();
        let said = String::from_utf8(out.stdout).unwrap();
        assert!(said.ends_with("done\n"), "{said}");
        let mut left = Vec::new();
        for kind in ["programs", "modules"] {
            let entries = std::fs::read_dir(home.join(kind)).unwrap();
            left.extend(entries.map(|e| e.unwrap().file_name().into_string().unwrap()));
        }
        left.sort();
        left
    }

    #[test]
    fn what_nobody_needs_goes_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("it's home");
        let digest = |n: u8| format!("{n:064x}");
        let day = Duration::from_secs(24 * 3600);
        let put = |kind: &str, n: u8, age: Duration| {
            let folder = home.join(kind).join(digest(n));
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join("file"), "x").unwrap();
            let opened = std::fs::File::open(&folder).unwrap();
            opened.set_modified(SystemTime::now() - age).unwrap();
        };
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
        let left = run(&home, "mine", &[&digest(0x11)]);
        let want = [0x11, 0x12, 0x14, 0x21, 0x23].map(digest);
        assert_eq!(left[..5], want);
        assert_eq!(left[5..], ["by hand"]);
        // Another home needs none of it, and its end takes nothing away.
        assert_eq!(run(&home, "other", &[&digest(0x99)]), left);
        assert_eq!(run(&home, "other", &[]), left);
        // A new version takes the place of the old one.
        let newer = run(&home, "mine", &[&digest(0x14)]);
        assert!(!newer.contains(&digest(0x11)) && newer.contains(&digest(0x14)));
        // With the last lease goes all but what a service or a ledger needs.
        let last = run(&home, "mine", &[]);
        assert_eq!(last, [digest(0x12), digest(0x21), "by hand".to_owned()]);
        assert!(!home.join("leases").exists());
    }

    #[test]
    fn a_lease_is_of_one_home_and_node() {
        let name = lease_name("m", "/h", "arm");
        assert_eq!(name.len(), NAME);
        assert_ne!(name, lease_name("m", "/ha", "rm"));
        assert_eq!(name, lease_name("m", "/h", "arm"));
    }
}
