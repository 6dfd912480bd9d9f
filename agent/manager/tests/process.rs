//! The manager as a process: start, readiness, files, signals, and what strangers send.

mod support;

use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::net::UnixStream;
use std::process::Stdio;
use std::time::Duration;

use rts_manager_api::client::Client;
use rts_manager_api::control::*;
use rts_manager_api::files::ManagerFile;
use rts_manager_api::frame;
use support::*;

#[test]
fn a_socket_as_standard_input_is_the_first_connection_and_says_when_it_is_ready() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let dir = home.path().join("m");
    let (ours, theirs) = UnixStream::pair().unwrap();
    let mut child = command(&dir, "m")
        .args(["--system-name", "s", "--system-uid", "u"])
        .stdin(Stdio::from(OwnedFd::from(theirs)))
        .spawn()
        .unwrap();
    let mut client = Client::greet(ours, SOON).unwrap();
    let hello = client.hello().clone();
    assert_eq!(hello.pid, child.id());
    let file: ManagerFile =
        serde_json::from_slice(&std::fs::read(dir.join("manager.json")).unwrap()).unwrap();
    assert_eq!(file.system.as_ref().unwrap().name, "s");
    assert_eq!((file.system, file.pid), (hello.system, hello.pid));
    assert_eq!(file.incarnation, "i-1");
    assert_eq!(file.started, hello.started);
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
    let ticks = stat
        .rsplit(')')
        .next()
        .unwrap()
        .split_whitespace()
        .nth(19)
        .unwrap();
    assert_eq!(file.start_ticks.to_string(), ticks);
    assert_eq!(file.boot_id.len(), 36);
    let stdin = std::fs::read_link(format!("/proc/{}/fd/0", child.id())).unwrap();
    assert_eq!(stdin.to_str(), Some("/dev/null"));
    for name in ["control.sock", "manager.json", "lock"] {
        let mode = dir.join(name).metadata().unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{name}");
    }

    ok(&mut client, RequestBody::Shutdown);
    assert!(child.wait().unwrap().success());
    assert!(!dir.join("control.sock").exists());
    assert!(!dir.join("manager.json").exists());
}

#[test]
fn the_end_of_its_parent_s_connection_does_not_end_it() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let dir = home.path().join("m");
    let (ours, theirs) = UnixStream::pair().unwrap();
    let mut child = command(&dir, "m")
        .stdin(Stdio::from(OwnedFd::from(theirs)))
        .spawn()
        .unwrap();
    drop(Client::greet(ours, SOON).unwrap());
    let mut client = Client::connect(&dir.join("control.sock"), SOON).unwrap();
    ok(&mut client, RequestBody::Shutdown);
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_signal_ends_it_in_order() {
    for signal in ["-TERM", "-INT"] {
        let mut manager = start("m");
        let mut client = manager.client();
        manager.create("A", &[]);
        ok(&mut client, activate("A"));
        manager.signal("-HUP");
        ok(&mut client, RequestBody::Inventory);
        manager.signal(signal);
        assert_eq!(manager.wait().code(), Some(0));
        let log = manager.log("A");
        assert!(
            log.contains("on_deactivated") && log.contains("on_finalize"),
            "{log}"
        );
        assert!(!manager.socket().exists());
        assert!(!manager.dir.join("manager.json").exists());
    }
}

#[test]
fn a_component_that_hangs_does_not_keep_it_from_ending() {
    let mut manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("hang", "on_deactivated"), ("hang_ms", "60000")]);
    ok(&mut client, activate("A"));
    let start = std::time::Instant::now();
    manager.signal("-TERM");
    assert_eq!(manager.wait().code(), Some(0));
    assert!(start.elapsed() < Duration::from_secs(15));
    assert!(!manager.socket().exists());
}

#[test]
fn a_second_manager_in_the_same_folder_is_refused_and_harms_nothing() {
    let manager = start("m");
    let output = command(&manager.dir, "other").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.contains("held by another manager that still runs"),
        "{error}"
    );
    assert_eq!(manager.client().hello().name, "m");
}

#[test]
fn what_a_killed_manager_left_is_no_obstacle() {
    let manager = start("m");
    manager.signal("-KILL");
    until("it is dead", || {
        UnixStream::connect(manager.socket()).is_err()
    });
    assert!(manager.socket().exists());
    let mut again = command(&manager.dir, "again").spawn().unwrap();
    until("the next one serves", || {
        UnixStream::connect(manager.socket()).is_ok()
    });
    let mut client = manager.client();
    assert_eq!(client.hello().name, "again");
    ok(&mut client, RequestBody::Shutdown);
    assert!(again.wait().unwrap().success());
}

#[test]
fn a_socket_that_was_removed_or_replaced_is_bound_anew() {
    let manager = start("m");
    let mut old = manager.client();
    let inode = |path: &std::path::Path| path.metadata().map(|file| file.ino()).ok();
    let first = inode(&manager.socket());
    std::fs::remove_file(manager.socket()).unwrap();
    until("it is bound anew", || {
        UnixStream::connect(manager.socket()).is_ok()
    });
    assert_eq!(manager.client().hello().name, "m");
    std::fs::remove_file(manager.socket()).unwrap();
    std::fs::write(manager.socket(), "x").unwrap();
    until("it is bound once more", || {
        UnixStream::connect(manager.socket()).is_ok()
    });
    assert_ne!(inode(&manager.socket()), first);
    ok(&mut old, RequestBody::Inventory);
}

#[test]
fn nonsense_on_the_socket_does_no_harm() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[]);
    let greeting = frame::encode(&Greeting::Control { version: 1 }).unwrap();
    let framed = |text: &str| [&(text.len() as u32).to_be_bytes()[..], text.as_bytes()].concat();
    let attempts = [
        b"GET / HTTP/1.1\r\n\r\n".to_vec(),
        framed("null"),
        framed(r#"{"role":"king"}"#),
        framed("\u{0}\u{1}"),
        vec![0, 0],
        [greeting.clone(), framed("[]")].concat(),
        [greeting.clone(), framed(r#"{"id":-1}"#)].concat(),
        [greeting.clone(), framed(&"[".repeat(100_000))].concat(),
        [greeting.clone(), u32::MAX.to_be_bytes().to_vec()].concat(),
    ];
    for attempt in attempts {
        let mut stream = manager.connect();
        stream.write_all(&attempt).unwrap();
        let _ = stream.shutdown(std::net::Shutdown::Write);
        // It closes, perhaps after its hello; a reset is an end as well.
        let _ = stream.read_to_end(&mut Vec::new());
    }
    ok(&mut client, activate("A"));

    // A request from a future version is refused, and the connection goes on.
    let mut stream = manager.connect();
    stream.write_all(&greeting).unwrap();
    let _: Hello = frame::read(&mut stream).unwrap();
    stream
        .write_all(&framed(
            r#"{"id":7,"deadlineMs":99999999999999,"body":{"op":"fly"}}"#,
        ))
        .unwrap();
    let FromManager::Response(response) = frame::read(&mut stream).unwrap() else {
        panic!()
    };
    assert_eq!(response.id, 7);
    let failure = response.result.unwrap_err();
    assert_eq!(failure.code, FailureCode::Invalid);
    assert!(
        failure.message.contains("unknown variant `fly`"),
        "{}",
        failure.message
    );

    // The version before this one is served, as if this manager spoke no other.
    let mut stream = manager.connect();
    stream
        .write_all(&framed(r#"{"role":"control","version":1}"#))
        .unwrap();
    let hello: Hello = frame::read(&mut stream).unwrap();
    assert_eq!(hello.version, 1);
    stream
        .write_all(&framed(
            r#"{"id":1,"deadlineMs":1000,"body":{"op":"inventory"}}"#,
        ))
        .unwrap();
    let answer: FromManager = frame::read(&mut stream).unwrap();
    assert!(matches!(
        answer,
        FromManager::Response(Response {
            id: 1,
            result: Ok(_)
        })
    ));

    // Another protocol version is told ours and sent away.
    let mut stream = manager.connect();
    stream
        .write_all(&framed(r#"{"role":"control","version":99}"#))
        .unwrap();
    let hello: Hello = frame::read(&mut stream).unwrap();
    assert_eq!(hello.version, 2);
    assert_eq!(stream.read(&mut [0]).unwrap(), 0);
    assert_eq!(component(&mut client, "A").state, "Active");
}

#[test]
fn one_who_connects_and_stays_silent_is_sent_away() {
    let manager = start("m");
    let mut stream = manager.connect();
    assert_eq!(stream.read(&mut [0]).unwrap(), 0);
}

#[test]
fn wrong_usage_says_what_is_wrong() {
    let output = std::process::Command::new(built("manager"))
        .args(["--name", "x"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        String::from_utf8(output.stderr)
            .unwrap()
            .contains("--dir is missing")
    );
    let long = format!("/tmp/{}", "x".repeat(120));
    let output = command(std::path::Path::new(&long), "m").output().unwrap();
    let _ = std::fs::remove_dir_all(&long);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        String::from_utf8(output.stderr)
            .unwrap()
            .contains("RTSCTL_HOME")
    );
}

#[test]
fn one_who_asks_and_never_reads_is_dropped_alone() {
    let manager = start("m");
    let mut client = manager.client();
    let mut stream = manager.connect();
    stream.set_write_timeout(Some(SOON)).unwrap();
    frame::write(&mut stream, &Greeting::Control { version: 1 }).unwrap();
    let request = frame::encode(&Request {
        id: 1,
        deadline_ms: 1000,
        body: RequestBody::Inventory,
    })
    .unwrap();
    let error = loop {
        if let Err(error) = stream.write_all(&request) {
            break error.kind();
        }
    };
    assert_ne!(error, std::io::ErrorKind::WouldBlock);
    ok(&mut client, RequestBody::Inventory);
}

#[test]
fn a_run_folder_that_was_removed_is_made_again_with_all_that_belongs_in_it() {
    let manager = start("m");
    // An answer means that the folder is complete.
    drop(manager.client());
    let read = |name: &str| std::fs::read(manager.dir.join(name));
    let description = read("manager.json").unwrap();
    std::fs::remove_dir_all(&manager.dir).unwrap();
    until("it is all there again", || {
        read("manager.json").is_ok() && UnixStream::connect(manager.socket()).is_ok()
    });
    assert_eq!(read("manager.json").unwrap(), description);
    assert_eq!(manager.client().hello().name, "m");
    // The lock is held again.
    let output = command(&manager.dir, "other").output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("held by another manager"), "{error}");

    std::fs::write(manager.dir.join("manager.json"), "{}").unwrap();
    until("the description is mended", || {
        read("manager.json").is_ok_and(|text| text == description)
    });
}

#[test]
fn a_hang_up_opens_the_log_anew() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let path = home.path().join("m.log");
    let log = std::fs::File::options()
        .append(true)
        .create(true)
        .open(&path)
        .unwrap();
    let dir = home.path().join("m");
    let mut child = command(&dir, "m")
        .stdout(log.try_clone().unwrap())
        .stderr(log)
        .spawn()
        .unwrap();
    until("the manager serves", || {
        UnixStream::connect(dir.join("control.sock")).is_ok()
    });
    std::fs::rename(&path, home.path().join("old")).unwrap();
    let hang_up = std::process::Command::new("kill")
        .args(["-HUP", &child.id().to_string()])
        .status();
    assert!(hang_up.unwrap().success());
    until("it goes on in a new file", || {
        std::fs::read_to_string(&path).is_ok_and(|text| text.contains("was opened anew"))
    });
    let mut client = Client::connect(&dir.join("control.sock"), SOON).unwrap();
    ok(&mut client, RequestBody::Shutdown);
    assert!(child.wait().unwrap().success());
}

#[test]
fn its_own_log_is_exchanged_when_it_is_full() {
    const FULL: u64 = 16 * 1024 * 1024;
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let path = home.path().join("m.log");
    let mut log = std::fs::File::options();
    let mut log = log.append(true).create(true).open(&path).unwrap();
    let dir = home.path().join("m");
    let mut child = command(&dir, "m")
        .stdout(log.try_clone().unwrap())
        .stderr(log.try_clone().unwrap())
        .spawn()
        .unwrap();
    until("the manager serves", || {
        UnixStream::connect(dir.join("control.sock")).is_ok()
    });
    // Each round as a component that prints without end does it, twice over.
    for round in 0..2 {
        let number = path.metadata().unwrap().ino();
        log.write_all(&vec![b'x'; FULL as usize]).unwrap();
        until("it goes on in a new file", || {
            std::fs::read_to_string(&path).is_ok_and(|text| {
                // Between its two steps there is none.
                text.contains("the log was full")
                    && path.metadata().is_ok_and(|file| file.ino() != number)
            })
        });
        assert!(path.metadata().unwrap().len() < FULL / 2, "{round}");
        let former = home.path().join("m.log.1");
        assert_eq!(former.metadata().unwrap().ino(), number);
        assert!(former.metadata().unwrap().len() >= FULL);
        for fd in ["1", "2"] {
            let link = format!("/proc/{}/fd/{fd}", child.id());
            assert_eq!(std::fs::read_link(link).unwrap(), path);
        }
        log = std::fs::File::options().append(true).open(&path).unwrap();
    }
    let mut client = Client::connect(&dir.join("control.sock"), SOON).unwrap();
    ok(&mut client, RequestBody::Shutdown);
    assert!(child.wait().unwrap().success());
}

fn describe(file: &std::path::Path, type_name: &str) -> std::process::Output {
    std::process::Command::new(built("manager"))
        .arg("--describe")
        .arg(file)
        .args(["--type", type_name])
        .output()
        .expect("it runs")
}

#[test]
fn a_module_is_described_without_a_manager() {
    let module = built("libtestmod.so");
    let output = describe(&module, "Testmod");
    assert!(output.status.success());
    let info: ModuleInfo = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(info.type_name, "Testmod");
    assert_eq!(info.ports[1].direction, "out");
    assert_eq!(info.parameters["code"], "1");

    let output = describe(&module, "Other");
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("not `Other`"), "{error}");
}

#[test]
fn a_module_that_hangs_is_not_described_for_ever() {
    let output = std::process::Command::new(built("manager"))
        .args(["--type", "Testmod", "--describe"])
        .arg(built("libtestmod.so"))
        .env("TESTMOD_INIT_MS", "600000")
        .output()
        .expect("it ends");
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8(output.stderr).unwrap();
    let why = "libtestmod.so was not described within 10 s: an initialiser of the library hangs\n";
    assert!(error.ends_with(why), "{error}");
}
