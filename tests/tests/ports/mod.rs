//! Samples of ports: printed, injected, recorded and played, by real programs.

use std::io::{Read, Write};
use std::process::{Child, Stdio};

use rts_tests::{Stack, signal};
use rustix::process::Signal;
use serde_json::{Value, json};

const HELLO: &str = "manifests/hello/system.xml";

/// `rtsctl` that runs beside the test; killed at the end.
struct Beside(Child);

impl Beside {
    fn start(stack: &Stack, arguments: &[&str]) -> Self {
        let mut command = stack.command(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let child = command.stderr(Stdio::piped()).spawn();
        Self(child.expect("rtsctl starts"))
    }

    /// Its exit code, and what it printed.
    fn ends(mut self) -> (i32, String, String) {
        drop(self.0.stdin.take());
        let (mut out, mut err) = (String::new(), String::new());
        let pipes = (self.0.stdout.take(), self.0.stderr.take());
        pipes
            .0
            .expect("it is there")
            .read_to_string(&mut out)
            .expect("it is there");
        pipes
            .1
            .expect("it is there")
            .read_to_string(&mut err)
            .expect("it is there");
        let code = self.0.wait().expect("it is there").code().unwrap_or(-1);
        (code, out, err)
    }

    /// The values that it printed, when it has ended well.
    #[track_caller]
    fn prints(self) -> Vec<Value> {
        let (code, out, err) = self.ends();
        assert_eq!(code, 0, "{err}");
        let value = |line| serde_json::from_str(line).expect("a JSON value on each line");
        out.lines().map(value).collect()
    }

    fn killed(mut self) {
        self.0.kill().expect("it is there");
        self.0.wait().expect("it is there");
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The ports of all managers that are looked at or written to.
fn taps(managers: &[Value]) -> Vec<(String, String)> {
    let all = managers
        .iter()
        .filter_map(|m| m["status"]["taps"].as_array());
    let text = |value: &Value| value.as_str().expect("it is there").to_owned();
    all.flatten()
        .map(|tap| (text(&tap["port"]), text(&tap["way"])))
        .collect()
}

#[track_caller]
fn tapped(stack: &Stack, port: &str, way: &str) {
    let tap = (port.to_owned(), way.to_owned());
    stack.until("managers", "the port is tapped", |managers| {
        taps(managers).contains(&tap)
    });
}

#[track_caller]
fn untapped(stack: &Stack) {
    stack.until("managers", "nothing is left", |managers| {
        !managers.is_empty() && taps(managers).is_empty()
    });
}

/// A filter that passes on what it gets, without a system.
fn echo(stack: &Stack, name: &str) {
    let wish = format!("LowPassFilter?instance_name={name}&alpha=1&manager=bench");
    stack.expect(0, &["manager", "create", &wish]);
    stack.expect(0, &["activate", name]);
}

fn values(count: u64) -> Vec<Value> {
    (1..=count)
        .map(|n| json!({"tm": {"sec": n, "nsec": 7}, "data": n as f64}))
        .collect()
}

/// Writes the values to a port, a line each.
#[track_caller]
fn inject(stack: &Stack, port: &str, values: &[Value]) {
    let mut child = Beside::start(stack, &["port", "inject", port, "--timeout", "60s"]);
    let mut stdin = child.0.stdin.take().expect("it is there");
    for value in values {
        writeln!(stdin, "{value}").expect("it is there");
    }
    drop(stdin);
    let (code, out, err) = child.ends();
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    assert!(
        err.contains(&format!("written to {port}, and read")),
        "{err}"
    );
}

#[test]
fn what_is_injected_comes_out_and_a_recording_plays_the_same() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    echo(&stack, "Echo0");
    echo(&stack, "Echo1");
    let sent = values(5);

    let print = ["port", "print", "Echo0.out", "-n", "5", "--timeout", "60s"];
    let print = Beside::start(&stack, &print);
    tapped(&stack, "Echo0.out", "print");
    inject(&stack, "Echo0.in", &sent);
    assert_eq!(print.prints(), sent);

    let file = stack.write("unused", "").with_file_name("echo.jsonl");
    let file = file.to_str().unwrap();
    let log = [
        "port",
        "log",
        "Echo0.out",
        "Echo1.out",
        "-o",
        file,
        "-n",
        "5",
    ];
    let log = Beside::start(&stack, &log);
    tapped(&stack, "Echo0.out", "print");
    tapped(&stack, "Echo1.out", "print");
    inject(&stack, "Echo0.in", &sent);
    assert!(log.prints().is_empty());
    let recorded = std::fs::read_to_string(file).unwrap();
    let recorded: Vec<Value> = recorded
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    for line in &recorded {
        assert_eq!(line["port"], "Echo0.out");
        assert_eq!(line["type"], "IDL:RTC/TimedDouble:1.0");
        assert!(line["time"].is_string());
    }
    let recorded: Vec<Value> = recorded.iter().map(|line| line["value"].clone()).collect();
    assert_eq!(recorded, sent);
    let said = stack.expect(2, &["port", "log", "Echo0.out", "-o", file]);
    assert!(said.err.contains("is there already"), "{said:#?}");

    let print = ["port", "print", "Echo1.out", "-n", "5", "--timeout", "60s"];
    let print = Beside::start(&stack, &print);
    tapped(&stack, "Echo1.out", "print");
    let play = ["port", "log", "--play", file, "Echo0.out=Echo1.in"];
    stack.expect(
        0,
        &[&play[..], &["--speed", "100", "--timeout", "60s"]].concat(),
    );
    assert_eq!(print.prints(), sent);
    untapped(&stack);
}

#[test]
fn what_cannot_be_looked_at_or_written_says_why() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    echo(&stack, "Echo0");
    for (code, arguments, why) in [
        (2, &["print", "Ecoh0.out"][..], "did you mean `Echo0`?"),
        (2, &["print", "Echo0.ot"], "did you mean `out`?"),
        (2, &["print", "Echo0.in"], "Echo0.in is an in-port"),
        (
            2,
            &["inject", "Echo0.out", "{}"],
            "Echo0.out is an out-port",
        ),
        (
            3,
            &["inject", "Echo0.in", "{\"data\": \"x\"}"],
            "TimedDouble.data: ",
        ),
        (3, &["inject", "Echo0.in", "{\"data\": 1,}"], "column 12"),
        (
            6,
            &["print", "Echo0.out", "--timeout", "100ms"],
            "no sample of Echo0.out came",
        ),
    ] {
        let said = stack.expect(code, &[&["port"], arguments].concat());
        assert!(said.err.contains(why), "{said:#?}");
    }
    let said = stack.expect(0, &["port", "print", "Echo0.out", "--for", "100ms"]);
    assert_eq!(said.out, "");
    // It does not read.
    stack.expect(0, &["deactivate", "Echo0"]);
    let inject = ["port", "inject", "Echo0.in", "{}", "--timeout", "100ms"];
    let said = stack.expect(6, &inject);
    assert!(said.err.contains("rtsctl activate Echo0"), "{said:#?}");
    untapped(&stack);
}

#[test]
fn nothing_is_left_of_who_looks_when_anybody_is_killed() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let before = stack.get("components");

    let print = Beside::start(&stack, &["port", "print", "Sine0.out"]);
    tapped(&stack, "Sine0.out", "print");
    let inject = Beside::start(&stack, &["port", "inject", "Filter0.in"]);
    tapped(&stack, "Filter0.in", "inject");
    let page = stack.expect(0, &["describe", "manager/hello.main"]);
    assert!(page.out.contains("Filter0.in (inject)"), "{page:#?}");
    // Nobody takes it for something to be removed.
    stack.expect(0, &["diff", HELLO]);
    print.killed();
    inject.killed();
    untapped(&stack);

    // Whoever passes samples on may be killed, too.
    let print = Beside::start(&stack, &["port", "print", "Filter0.out"]);
    tapped(&stack, "Filter0.out", "print");
    assert_eq!(stack.kill_9("rts-agent"), 1);
    let (code, out, err) = print.ends();
    assert_eq!(code, 4, "{err}");
    assert!(!out.is_empty() && err.contains("broke off"), "{err}");
    stack.expect(0, &["up"]);
    untapped(&stack);

    let print = Beside::start(&stack, &["port", "print", "Filter0.out"]);
    tapped(&stack, "Filter0.out", "print");
    assert_eq!(stack.kill_9("rts-controller"), 1);
    assert_eq!(print.ends().0, 4);
    stack.expect(0, &["up"]);
    untapped(&stack);

    // No component has noticed.
    let after = stack.get("components");
    for (before, after) in before.iter().zip(&after) {
        for key in ["incarnation", "restarts", "pid"] {
            assert_eq!(before["status"][key], after["status"][key]);
        }
        assert_eq!(after["status"]["state"], "Active");
    }

    // What is looked at is not slowed down.
    let print = Beside::start(&stack, &["port", "print", "Sine0.out"]);
    tapped(&stack, "Sine0.out", "print");
    let said = stack.expect(0, &["top", "-o", "json", "--system", "hello"]);
    let top: Value = serde_json::from_str(&said.out).unwrap();
    let each = |kind: &str, key: &str| {
        let items = top[kind].as_array().unwrap().clone();
        items
            .into_iter()
            .map(|item| item[key].as_f64())
            .collect::<Vec<_>>()
    };
    for (kind, key, count) in [
        ("components", "reachedHz", 3),
        ("connectors", "samplesPerSecond", 2),
        ("managers", "memoryBytes", 2),
    ] {
        let values = each(kind, key);
        assert_eq!(values.len(), count, "{top}");
        assert!(values.iter().all(|value| *value > Some(0.0)), "{top}");
    }
    print.killed();

    // A reader that wants no more ends it without a word; Ctrl-C ends it as it ends all.
    let print = Beside::start(&stack, &["port", "print", "Sine0.out"]);
    tapped(&stack, "Sine0.out", "print");
    signal(print.0.id(), Signal::INT);
    let (code, _, err) = print.ends();
    assert_eq!((code, err.as_str()), (130, ""));
    untapped(&stack);
}
