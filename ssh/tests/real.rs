//! What a session says and does at a real SSH server on loopback: every class of error is provoked there.

#![allow(
    clippy::unwrap_used,
    reason = "what cannot go on fails the test that called it"
)]

use std::path::{Path, PathBuf};
use std::time::Duration;

use rts_ssh::{Destination, HostKeys, Kind, LocalFile, Session, SshError};
use rts_test_sshd::{HOST, Server, Setup, for_test};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

/// A server whose sessions have a home of their own, and that home.
struct Robot {
    server: Server,
    folder: tempfile::TempDir,
}

impl Robot {
    fn new() -> Option<Self> {
        Self::with(|setup| setup)
    }

    fn with(change: impl FnOnce(Setup) -> Setup) -> Option<Self> {
        let folder = tempfile::Builder::new()
            .prefix("rtsh")
            .tempdir_in("/tmp")
            .unwrap();
        std::fs::create_dir(folder.path().join("home")).unwrap();
        let server = for_test(change(Setup::home(&folder.path().join("home"))))?;
        Some(Self { server, folder })
    }

    fn home(&self) -> PathBuf {
        self.folder.path().join("home")
    }

    fn root(&self) -> String {
        self.home().join("store").display().to_string()
    }

    fn destination(&self) -> Destination {
        let mut destination = Destination::new(HOST).unwrap();
        destination.config = Some(self.server.config());
        destination
    }

    async fn open(&self) -> Result<Session, SshError> {
        Session::open(&self.destination(), self.folder.path()).await
    }

    fn file(&self, name: &str, bytes: &[u8]) -> LocalFile {
        let path = self.folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        LocalFile::data(path)
    }
}

/// Runs it with an end: nothing here may take a minute.
fn run(test: impl Future<Output = ()>) {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    runtime.block_on(async {
        tokio::time::timeout(Duration::from_secs(120), test)
            .await
            .unwrap();
    });
}

/// Every file below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut all: Vec<PathBuf> = Vec::new();
    for entry in entries.map(Result::unwrap) {
        match entry.file_type().unwrap().is_dir() {
            true => all.extend(files(&entry.path())),
            false => all.push(entry.path()),
        }
    }
    all
}

#[test]
fn a_session_surveys_stores_and_spawns_whatever_the_shell_prints() {
    let Some(robot) = Robot::with(|setup| setup.with("SHLVL", "0")) else {
        return;
    };
    // Bash reads this for each command of a session, as it takes it for the first one.
    std::fs::write(
        robot.home().join(".bashrc"),
        "echo welcome; printf 'no newline'\n",
    )
    .unwrap();
    run(async {
        let session = robot.open().await.unwrap();
        let survey = session.survey().await.unwrap();
        assert_eq!(survey.home, robot.home().display().to_string());
        assert_eq!(
            (survey.kernel.as_str(), survey.machine_name().as_str()),
            ("Linux", std::env::consts::ARCH)
        );
        assert!(survey.free.is_some() && !survey.user.is_empty());

        let big = vec![7; 300_000];
        let files = [
            robot.file("it's a.bin", b"x"),
            robot.file("big.bin", &big),
            robot.file("empty", b""),
        ];
        let bad = session.store(&files[..1], &robot.root()).await.unwrap_err();
        assert!(bad.to_string().contains("of this name"), "{bad}");
        let first = session.store(&files[1..], &robot.root()).await.unwrap();
        assert_eq!((first.sent_files(), first.sent_bytes()), (2, 300_000));
        assert_eq!(std::fs::read(first.path("big.bin").unwrap()).unwrap(), big);
        let again = session.store(&files[1..], &robot.root()).await.unwrap();
        assert_eq!((again.sent_files(), again.sent_bytes()), (0, 0));

        let script = robot.file(
            "echo.sh",
            b"#!/bin/sh\necho \"$1\"; cat; echo over >&2; exit 7\n",
        );
        let script = LocalFile {
            executable: true,
            ..script
        };
        let stored = session.store(&[script], &robot.root()).await.unwrap();
        let mut child = session
            .spawn(stored.path("echo.sh").unwrap(), &["a 'b' $HOME !x \n\"`"])
            .await
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        stdin.write_all(b"\0\xffbytes").await.unwrap();
        drop(stdin);
        let (mut out, mut err) = (Vec::new(), String::new());
        child.stdout.read_to_end(&mut out).await.unwrap();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut err)
            .await
            .unwrap();
        assert_eq!(out, b"a 'b' $HOME !x \n\"`\n\0\xffbytes");
        assert_eq!(
            (err.as_str(), child.wait().await.unwrap()),
            ("over\n", Some(7))
        );

        let plain = again.path("big.bin").unwrap();
        let error = session.spawn(plain, &[]).await.unwrap_err();
        assert!(matches!(error, SshError::NotPermitted { .. }), "{error}");
        let error = session.spawn("/nothing/there", &[]).await.unwrap_err();
        assert!(matches!(error, SshError::Missing { .. }), "{error}");
        session.close().await;
        // The server's side of it ends a moment later.
        let end = tokio::time::Instant::now() + Duration::from_secs(30);
        while !robot.server.sessions().is_empty() {
            assert!(tokio::time::Instant::now() < end, "it never ends");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    });
}

#[test]
fn host_keys_are_checked() {
    let Some(mut robot) = Robot::new() else {
        return;
    };
    robot.server.know_nothing().unwrap();
    run(async {
        let error = robot.open().await.unwrap_err();
        assert!(
            matches!(&error, SshError::UnknownHostKey { key: Some(key), .. } if key.contains("SHA256:")),
            "{error}"
        );
        assert!(error.help().unwrap().contains("--accept-new"));
        assert_eq!(
            std::fs::read_to_string(robot.server.known_hosts()).unwrap(),
            ""
        );

        let accept = Destination {
            host_keys: HostKeys::AcceptNew,
            ..robot.destination()
        };
        Session::open(&accept, robot.folder.path())
            .await
            .unwrap()
            .close()
            .await;
        robot.open().await.unwrap().close().await;

        robot.server.change_host_key().unwrap();
        for destination in [robot.destination(), accept] {
            let error = Session::open(&destination, robot.folder.path())
                .await
                .unwrap_err();
            let SshError::ChangedHostKey {
                key: Some(_),
                known: Some(known),
                ..
            } = &error
            else {
                panic!("{error}")
            };
            assert!(known.ends_with("known_hosts:1"), "{known}");
            assert_eq!(error.kind(), Kind::Forbidden);
        }
    });
}

#[test]
fn who_is_not_let_in_or_not_there_is_told_so() {
    let Some(mut robot) = Robot::with(|setup| Setup {
        stranger: true,
        ..setup
    }) else {
        return;
    };
    run(async {
        let error = robot.open().await.unwrap_err();
        let SshError::Refused {
            offered, methods, ..
        } = &error
        else {
            panic!("{error}")
        };
        assert!(offered[0].contains("user_key"), "{offered:?}");
        assert_eq!(
            (methods.as_deref(), error.kind()),
            (Some("publickey"), Kind::Forbidden)
        );

        robot.server.kill();
        let error = robot.open().await.unwrap_err();
        assert!(
            matches!(error, SshError::Unreachable { .. }) && error.is_passing(),
            "{error}"
        );

        let nowhere = Destination {
            config: None,
            ..Destination::new("no-such-host.invalid").unwrap()
        };
        let error = Session::open(&nowhere, robot.folder.path())
            .await
            .unwrap_err();
        assert!(error.to_string().contains("Could not resolve"), "{error}");

        std::fs::write(robot.server.config(), "Frobnicate yes\n").unwrap();
        let error = robot.open().await.unwrap_err();
        assert!(
            error
                .to_string()
                .contains("Bad configuration option: frobnicate"),
            "{error}"
        );

        // A port that takes connections and says nothing.
        let mute = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let silent: Destination = mute.local_addr().unwrap().to_string().parse().unwrap();
        let error = Session::open(&silent, robot.folder.path())
            .await
            .unwrap_err();
        assert!(matches!(error, SshError::TimedOut { .. }), "{error}");
        assert_eq!(
            std::fs::read_dir(robot.folder.path()).unwrap().count(),
            1,
            "no folder of a session is left"
        );
    });
}

#[test]
fn a_session_that_is_killed_is_lost_and_half_a_file_never_counts() {
    let Some(mut robot) = Robot::new() else {
        return;
    };
    run(async {
        let session = robot.open().await.unwrap();
        let small = robot.file("small", b"small");
        let store = robot.home().join("store");
        session
            .store(std::slice::from_ref(&small), &robot.root())
            .await
            .unwrap();
        let before = files(&store);

        let script = include_str!("../src/store_put.sh");
        let digest = "0".repeat(64);
        let words = [
            robot.root(),
            digest,
            "half".to_owned(),
            "1000".to_owned(),
            "400".to_owned(),
        ];
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let mut half = session
            .spawn("sh", &[&["-c", script, "sh"], &words[..]].concat())
            .await
            .unwrap();
        let mut stdin = half.stdin.take().unwrap();
        stdin.write_all(b"half a file").await.unwrap();
        while !files(&store)
            .iter()
            .any(|file| file.extension().is_some_and(|e| e == "part"))
        {
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        robot.server.kill();
        session.lost().await;
        let error = session
            .store(std::slice::from_ref(&small), &robot.root())
            .await
            .unwrap_err();
        assert!(matches!(error, SshError::Lost { .. }), "{error}");
        let error = session.survey().await.unwrap_err();
        assert!(
            matches!(error, SshError::Lost { .. }) && error.is_passing(),
            "{error}"
        );

        robot.server.restart().unwrap();
        let session = robot.open().await.unwrap();
        let again = session.store(&[small], &robot.root()).await.unwrap();
        assert_eq!(again.sent_files(), 0);
        while files(&store) != before {
            // The writer that lost its other end is about to see it.
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    });
}

#[test]
fn a_file_that_is_broken_there_is_sent_again_and_two_at_once_do_no_harm() {
    let Some(robot) = Robot::new() else { return };
    run(async {
        let session = robot.open().await.unwrap();
        let file = robot.file("module.so", &vec![3; 2_000_000]);
        let (one, two) = (robot.root(), robot.root());
        let list = [file.clone()];
        let (a, b) = tokio::join!(session.store(&list, &one), session.store(&list, &two));
        let path = PathBuf::from(a.unwrap().path("module.so").unwrap());
        assert_eq!(
            b.unwrap().path("module.so").unwrap(),
            path.to_str().unwrap()
        );
        assert_eq!(
            files(&robot.home().join("store")),
            std::slice::from_ref(&path)
        );

        std::fs::remove_file(&path).unwrap();
        std::fs::write(&path, b"a half").unwrap();
        std::fs::write(
            path.with_file_name(".module.so.999999999.part"),
            b"of a dead writer",
        )
        .unwrap();
        let mended = session.store(&list, &one).await.unwrap();
        assert_eq!(mended.sent_files(), 1);
        assert_eq!(std::fs::metadata(&path).unwrap().len(), 2_000_000);
        assert_eq!(files(&robot.home().join("store")), [path]);
    });
}

#[test]
fn a_key_that_forces_a_command_is_told_with_its_place() {
    let Some(robot) = Robot::new() else { return };
    let keys = robot.server.folder().join("authorized_keys");
    let key = std::fs::read_to_string(&keys).unwrap();
    std::fs::write(&keys, format!("command=\"echo only this\" {key}")).unwrap();
    run(async {
        let error = robot.open().await.unwrap_err();
        let SshError::Forced {
            place: Some(place),
            said,
            ..
        } = &error
        else {
            panic!("{error}")
        };
        assert!(place.ends_with("authorized_keys:1"), "{place}");
        assert_eq!(
            (said.as_str(), error.kind()),
            ("only this", Kind::Forbidden)
        );
    });
}

#[test]
fn no_permission_and_a_full_disk_are_told_before_anything_counts() {
    if !rustix::process::geteuid().is_root() {
        eprintln!("SKIPPED: needs root (mount, another account)");
        return;
    }
    let folder = tempfile::Builder::new()
        .prefix("rtsh")
        .tempdir_in("/tmp")
        .unwrap();
    let small = folder.path().join("small");
    std::fs::create_dir(&small).unwrap();
    let mount = format!("mount -t tmpfs -o size=1m tmpfs {}", small.display());
    let setup = Setup {
        namespace: Some(mount),
        ..Setup::home(&small)
    };
    let Some(server) = for_test(setup) else {
        return;
    };
    let robot = Robot { server, folder };
    run(async {
        let session = robot.open().await.unwrap();
        let root = small.join("store").display().to_string();
        let error = session
            .store(&[robot.file("big", &vec![1; 3_000_000])], &root)
            .await
            .unwrap_err();
        let SshError::Full {
            needed: 3_000_000,
            free: Some(free),
            ..
        } = error
        else {
            panic!("{error}")
        };
        assert!(free <= 1 << 20, "{free}");
        // As it is when the space goes while the file comes.
        let full = "head -c 2000000 /dev/zero | { cat >\"$1/x\"; } 2>&1";
        let ran = session
            .run("fill", full, &[small.to_str().unwrap()])
            .await
            .unwrap();
        let said = String::from_utf8_lossy(&ran.out).into_owned();
        assert!(said.contains("No space left on device"), "{said}");
        let error = session
            .store(&[robot.file("little", b"little")], &root)
            .await
            .unwrap_err();
        assert!(matches!(error, SshError::Full { .. }), "{error}");
        assert_eq!(
            files(&robot.server.inside(&small).join("store")),
            Vec::<PathBuf>::new()
        );

        session
            .run(
                "free",
                "rm \"$1/x\"; mount -o remount,ro \"$1\"",
                &[small.to_str().unwrap()],
            )
            .await
            .unwrap();
        let error = session
            .store(&[robot.file("little", b"little")], &root)
            .await
            .unwrap_err();
        assert!(
            matches!(&error, SshError::NotPermitted { path, .. } if *path == root),
            "{error}"
        );
    });
}
