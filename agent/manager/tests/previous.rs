//! The previous version of the protocol: what a manager of then said is understood, and it can be used.
//!
//! `recorded/v1.jsonl` holds frames of a real manager of version 1, with neutral names, pids and ids. They never change.

#![allow(
    clippy::unwrap_used,
    reason = "a failure here is a failed test; clippy only knows test functions"
)]

mod support;

use std::path::Path;
use std::process::{Child, Command, Stdio};

use rts_manager_api::client::Client;
use rts_manager_api::control::*;
use rts_manager_api::files::ManagerFile;
use rts_manager_api::speaks;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use support::*;

/// Step, sender, frame.
fn recorded() -> Vec<(String, String, Value)> {
    include_str!("recorded/v1.jsonl")
        .lines()
        .map(|line| {
            let mut line: Value = serde_json::from_str(line).unwrap();
            let text = |value: &Value| value.as_str().unwrap().to_owned();
            let frame = line["frame"].take();
            (text(&line["step"]), text(&line["from"]), frame)
        })
        .collect()
}

/// It is understood, and nothing of it is lost: written again, all that was recorded is still there.
fn is_understood<T: Serialize + DeserializeOwned>(what: &str, frame: &Value) -> T {
    let value: T =
        serde_json::from_value(frame.clone()).unwrap_or_else(|e| panic!("{what}: {e}: {frame}"));
    let again = serde_json::to_value(&value).unwrap();
    assert_contains(what, &again, frame);
    value
}

fn assert_contains(what: &str, whole: &Value, part: &Value) {
    match (whole, part) {
        (Value::Object(whole), Value::Object(part)) => {
            for (name, value) in part {
                let whole = whole.get(name);
                let whole = whole.unwrap_or_else(|| panic!("{what}: `{name}` is not known"));
                assert_contains(what, whole, value);
            }
        }
        (Value::Array(whole), Value::Array(part)) if whole.len() == part.len() => {
            for (whole, part) in whole.iter().zip(part) {
                assert_contains(what, whole, part);
            }
        }
        _ => assert_eq!(whole, part, "{what}"),
    }
}

#[test]
fn every_recorded_frame_is_understood() {
    let mut kinds = std::collections::BTreeSet::new();
    for (step, from, frame) in recorded() {
        match (from.as_str(), step.as_str()) {
            ("file", _) => {
                let file: ManagerFile = is_understood(&step, &frame);
                speaks(file.protocol_version).unwrap();
            }
            ("manager", "greeting") => {
                let hello: Hello = is_understood(&step, &frame);
                speaks(hello.version).unwrap();
            }
            ("client", "greeting") => {
                let greeting: Greeting = is_understood(&step, &frame);
                assert_eq!(greeting, Greeting::Control { version: 1 });
            }
            ("client", _) => {
                let request: Request = is_understood(&step, &frame);
                // What is sent to such a manager today is what was sent then.
                let again = request.body.for_version(1);
                assert_eq!(
                    serde_json::to_value(again).unwrap(),
                    frame["body"],
                    "{step}"
                );
            }
            _ => match is_understood::<FromManager>(&step, &frame) {
                FromManager::Changed(_) => {
                    kinds.insert("changed");
                }
                FromManager::Response(response) => {
                    kinds.insert(if response.result.is_ok() {
                        "good"
                    } else {
                        "refusal"
                    });
                }
            },
        }
    }
    assert_eq!(
        kinds.into_iter().collect::<Vec<_>>(),
        ["changed", "good", "refusal"]
    );
}

#[test]
fn a_request_of_then_is_carried_out_by_a_manager_of_today() {
    use std::io::Write;
    let manager = start("m");
    manager.create("A", &[]);
    let frames = recorded();
    let frame = |step: &str| {
        let found = frames.iter().find(|f| f.0 == step && f.1 == "client");
        let text = found.unwrap().2.to_string().replace("Faulty0", "A");
        [&(text.len() as u32).to_be_bytes()[..], text.as_bytes()].concat()
    };
    let mut stream = manager.connect();
    stream.write_all(&frame("greeting")).unwrap();
    let hello: Hello = rts_manager_api::frame::read(&mut stream).unwrap();
    assert_eq!(hello.version, 1, "else it would be refused");
    for step in ["activate", "deactivate", "delete", "shutdown"] {
        stream.write_all(&frame(step)).unwrap();
        loop {
            let answer: FromManager = rts_manager_api::frame::read_answer(&mut stream).unwrap();
            if let FromManager::Response(response) = answer {
                assert_eq!(response.result, Ok(ResponseBody::Done), "{step}");
                break;
            }
        }
    }
}

struct Previous(Child);

impl Drop for Previous {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn previous(dir: &Path, arguments: &[&str]) -> Previous {
    let mut command = Command::new(built("previous_manager"));
    command.arg("--dir").arg(dir).args(["--name", "main"]);
    command.args(["--system-name", "s", "--system-uid", "u"]);
    command.args(["--incarnation", "i-1"]).args(arguments);
    let child = command.stdin(Stdio::null()).spawn().unwrap();
    until("it serves", || dir.join("manager.json").exists());
    Previous(child)
}

#[test]
fn a_client_of_today_uses_a_manager_of_then() {
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let dir = home.path().join("m");
    let mut manager = previous(&dir, &["--component", "A", "--component", "B:Inactive"]);
    let file: ManagerFile =
        serde_json::from_slice(&std::fs::read(dir.join("manager.json")).unwrap()).unwrap();
    assert_eq!((file.protocol_version, file.pid), (1, manager.0.id()));

    let mut client = Client::connect(&dir.join("control.sock"), SOON).unwrap();
    assert_eq!(client.hello().version, 1);
    assert_eq!(client.hello().pid, manager.0.id());
    assert_eq!(client.hello().system.as_ref().unwrap().uid, "u");
    let states = |client: &mut Client| {
        let seen = inventory(client).components;
        let state = |c: ComponentInfo| (c.instance, c.state, c.on_disconnect);
        seen.into_iter().map(state).collect::<Vec<_>>()
    };
    let state = |name: &str, state: &str| (name.to_owned(), state.to_owned(), None);
    assert_eq!(
        states(&mut client),
        [state("A", "Active"), state("B", "Inactive")]
    );
    ok(&mut client, deactivate("A"));
    ok(&mut client, activate("B"));
    ok(&mut client, on_disconnect("B", "stop"));
    assert_eq!(
        states(&mut client),
        [state("A", "Inactive"), state("B", "Active")]
    );
    let instance = "A".to_owned();
    ok(&mut client, RequestBody::Delete { instance });
    assert_eq!(states(&mut client), [state("B", "Active")]);
    ok(&mut client, RequestBody::Shutdown);
    assert!(manager.0.wait().unwrap().success());
    assert!(!dir.join("control.sock").exists());
}

#[test]
fn a_manager_of_then_tells_its_version_to_one_that_speaks_no_older() {
    use rts_manager_api::frame;
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let dir = home.path().join("m");
    let _manager = previous(&dir, &[]);
    let mut stream = std::os::unix::net::UnixStream::connect(dir.join("control.sock")).unwrap();
    let greeting = serde_json::json!({"role": "control", "version": 2});
    frame::write(&mut stream, &greeting).unwrap();
    let hello: Hello = frame::read(&mut stream).unwrap();
    assert_eq!(hello.version, 1);
    assert!(matches!(
        frame::read::<Hello>(&mut stream),
        Err(frame::FrameError::Closed)
    ));
}

#[test]
fn data_flows_to_a_manager_of_then_and_its_end_is_a_loss() {
    use rts_manager_api::frame;
    use std::io::Read;
    use std::os::unix::net::UnixListener;
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "1")]);
    ok(&mut client, on_disconnect("A", "deactivate"));
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let socket = home.path().join("control.sock");
    let listener = UnixListener::bind(&socket).unwrap();
    let peer = std::thread::spawn(move || {
        let greeted = || {
            let (mut stream, _) = listener.accept().unwrap();
            let greeting: Value = frame::read(&mut stream).unwrap();
            let reply: Value = serde_json::from_str(r#"{"result":{"Ok":null}}"#).unwrap();
            frame::write_answer(&mut stream, &reply).unwrap();
            (stream, greeting)
        };
        // Neither a puller nor shared memory is connected to it.
        drop(greeted());
        drop(greeted());
        greeted()
    });
    let request = connection("A", "B", "i", Some(&socket));
    let pull = ConnectRequest {
        properties: [("dataport.dataflow_type".to_owned(), "pull".to_owned())].into(),
        ..request.clone()
    };
    let refusal = refused(&mut client, RequestBody::Connect(pull), SOON).message;
    assert!(refusal.contains("cannot fetch samples"), "{refusal}");
    let shm = ConnectRequest {
        properties: [("dataport.interface_type".to_owned(), "shm".to_owned())].into(),
        ..request.clone()
    };
    let refusal = refused(&mut client, RequestBody::Connect(shm), SOON).message;
    let why = "knows no other transport than uds (`dataport.interface_type` asks for shm): restart it with";
    assert!(refusal.contains(why), "{refusal}");
    ok(&mut client, RequestBody::Connect(request));
    ok(&mut client, activate("A"));
    let (mut stream, greeting) = peer.join().unwrap();
    for sequence in [1, 2] {
        let mut frame = [0; 20];
        stream.read_exact(&mut frame).unwrap();
        assert_eq!(frame[..12], [0, 0, 0, 16, 0, 0, 0, 0, 0, 0, 0, sequence]);
    }
    let seen = component(&mut client, "A").connectors.remove(0);
    assert_eq!(
        (seen.state.as_str(), seen.transport.as_str()),
        ("Connected", "uds")
    );
    // It served its own version and the one before only.
    assert_eq!(greeting["version"], 1);
    drop(stream);
    until("the loss is acted on", || {
        component(&mut client, "A").state == "Inactive"
    });
}

/// A connection as a source of then makes it, to B in this manager.
fn source_of_then(manager: &Running, incarnation: &str) -> std::os::unix::net::UnixStream {
    use rts_manager_api::{data::DataReply, frame};
    let mut stream = manager.connect();
    let greeting = serde_json::json!({
        "role": "data", "version": 1, "connector": "A.out-B.in", "source": "A.out", "instance": "B", "port": "in",
        "incarnation": incarnation, "dataType": "IDL:RTC/TimedDouble:1.0", "encoding": "cdr-le",
    });
    frame::write(&mut stream, &greeting).unwrap();
    let reply: DataReply = frame::read_answer(&mut stream).unwrap();
    reply.result.unwrap();
    stream
}

#[test]
fn the_end_of_a_source_of_then_is_a_loss_unless_it_is_unbound_first() {
    use std::io::Write;
    let manager = start("m");
    let mut client = manager.client();
    let incarnation = manager.create("B", &[]);
    ok(&mut client, on_disconnect("B", "deactivate"));
    let bind = || binding("A.out-B.in", "B", "in", "A.out");
    ok(&mut client, bind());
    let mut source = source_of_then(&manager, &incarnation);
    ok(&mut client, activate("B"));
    for sequence in [1_u64, 2] {
        source.write_all(&16_u32.to_be_bytes()).unwrap();
        source.write_all(&sequence.to_be_bytes()).unwrap();
        source.write_all(&sequence.to_ne_bytes()).unwrap();
    }
    until("its samples are read", || {
        component(&mut client, "B").bindings[0].samples_received == 2
    });
    ok(&mut client, unbind("A.out-B.in"));
    drop(source);
    let before = component(&mut client, "B").executions;
    until("it goes on", || {
        component(&mut client, "B").executions > before + 5
    });
    assert_eq!(component(&mut client, "B").state, "Active");

    ok(&mut client, bind());
    drop(source_of_then(&manager, &incarnation));
    until("the loss is acted on", || {
        component(&mut client, "B").state == "Inactive"
    });
}
