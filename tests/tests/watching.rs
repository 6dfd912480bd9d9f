//! What stays and looks on: logs that are followed, events and objects that are watched, waits that are interrupted.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use rts_tests::{Stack, kill, processes_of};
use serde_json::Value;

const HELLO: &str = "manifests/hello/system.xml";

/// `rtsctl` that runs beside the test; killed with it.
struct Beside {
    child: Child,
    out: PathBuf,
    err: PathBuf,
}

impl Beside {
    fn start(stack: &Stack, name: &str, arguments: &[&str]) -> Self {
        let out = stack.write(&format!("{name}.out"), "");
        let err = stack.write(&format!("{name}.err"), "");
        let mut command = stack.command(arguments);
        command
            .stdout(File::create(&out).expect("a file"))
            .stderr(File::create(&err).expect("a file"));
        Self {
            child: command.spawn().expect("rtsctl starts"),
            out,
            err,
        }
    }

    fn out(&self) -> String {
        fs::read_to_string(&self.out).expect("text")
    }

    fn err(&self) -> String {
        fs::read_to_string(&self.err).expect("text")
    }

    #[track_caller]
    fn until(&self, what: &str, done: impl Fn(&Self) -> bool) {
        let end = Instant::now() + Duration::from_secs(30);
        while !done(self) {
            assert!(
                Instant::now() < end,
                "after 30 s still not: {what}\n{}\n{}",
                self.out(),
                self.err()
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn signal(&self, name: &str) {
        let kill = Command::new("kill")
            .args([format!("-{name}"), self.child.id().to_string()])
            .status();
        assert!(kill.expect("kill starts").success());
    }

    /// The exit code; -1 when a signal ended it.
    #[track_caller]
    fn end(&mut self) -> i32 {
        let end = Instant::now() + Duration::from_secs(20);
        loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                return status.code().unwrap_or(-1);
            }
            assert!(Instant::now() < end, "it does not end: {}", self.err());
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn daemon(stack: &Stack, name: &str) -> u32 {
    let named = |pid: &u32| {
        fs::read_to_string(format!("/proc/{pid}/comm")).is_ok_and(|comm| comm.trim() == name)
    };
    let mut all = processes_of(&stack.home()).into_iter();
    all.find(named).expect("a daemon")
}

fn pid(stack: &Stack, component: &str) -> u32 {
    let pid = stack.named("components", component)["status"]["pid"].as_u64();
    pid.and_then(|pid| pid.try_into().ok()).expect("a pid")
}

fn log(stack: &Stack, component: &str) -> PathBuf {
    let name = format!("logs/local/components/{component}.log");
    stack.home().join(name)
}

/// Restarts what was killed, and waits until all run.
fn heal(stack: &Stack) {
    stack.expect(0, &["up"]);
    stack.until("components", "all are Active", |components| {
        components.len() == 3 && components.iter().all(|c| c["status"]["state"] == "Active")
    });
}

#[test]
fn a_log_that_is_followed_comes_whole_through_rotation_and_kill_9() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let path = log(&stack, "Printer0");
    let mut beside = Beside::start(&stack, "logs", &["logs", "-f", "Printer0", "--tail", "1"]);
    let lines = |beside: &Beside| beside.out().lines().count();
    let more = |what: &str| {
        let before = lines(&beside);
        beside.until(what, |beside| lines(beside) > before + 3);
    };
    more("lines come");
    // By somebody else, such as logrotate.
    let moved = stack.write("moved.log", "");
    fs::rename(&path, &moved).expect("a log");
    beside.until("the component begins a new file", |beside| {
        let text = fs::read_to_string(&path).unwrap_or_default();
        text.lines()
            .last()
            .is_some_and(|line| text.ends_with('\n') && beside.out().contains(line))
    });
    kill(pid(&stack, "Printer0"));
    beside.until("a new incarnation is marked", |beside| {
        beside.out().contains("a new incarnation of Printer0")
    });
    more("lines come from the new process");
    for name in ["rts-agent", "rts-controller"] {
        kill(daemon(&stack, name));
        beside.until("it says that it broke", |beside| {
            beside.err().contains("broke off")
        });
        std::thread::sleep(Duration::from_millis(500));
        heal(&stack);
        more("lines come from the new daemons");
    }
    assert!(beside.err().contains("goes on"), "{}", beside.err());
    beside.signal("INT");
    assert_eq!(beside.end(), 130, "{}", beside.err());
    // Each line of the files, from the first one that came, once and in order.
    let files = [moved, path];
    let written = files
        .map(|file| fs::read_to_string(file).expect("text"))
        .concat();
    let out = beside.out();
    let first = out.lines().next().expect("a line");
    let from = written.find(first).expect("it was written");
    let missing = out
        .lines()
        .zip(written[from..].lines())
        .find(|(a, b)| a != b);
    assert_eq!(missing, None, "{out}");
    stack.leaves_nothing();
}

#[test]
fn logs_are_chosen_by_incarnation_time_number_and_name() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let said = stack.expect(2, &["logs", "Printer0", "-p"]);
    assert!(said.err.contains("previous"), "{said:#?}");
    let path = log(&stack, "Printer0");
    let end = Instant::now() + Duration::from_secs(10);
    while fs::read_to_string(&path).map_or(0, |text| text.lines().count()) < 5 {
        assert!(Instant::now() < end, "it logs nothing");
        std::thread::sleep(Duration::from_millis(50));
    }
    let before = stack.expect(0, &["logs", "Printer0", "--tail", "2"]).out;
    assert_eq!(before.lines().count(), 2);
    let printer = pid(&stack, "Printer0");
    kill(printer);
    stack.until("components", "Printer0 is back", |components| {
        components.iter().any(|c| {
            c["metadata"]["name"] == "Printer0"
                && c["status"]["state"] == "Active"
                && c["status"]["pid"] != printer
        })
    });
    let previous = stack.expect(0, &["logs", "Printer0", "--previous"]).out;
    assert!(previous.contains(&before), "{previous}\nlacks\n{before}");
    assert!(!previous.contains("a new incarnation"), "{previous}");
    let now = stack.expect(0, &["logs", "Printer0", "--since", "1h"]).out;
    assert!(now.starts_with(&previous), "{now}");
    let time = now
        .lines()
        .find(|line| line.contains("a new incarnation"))
        .and_then(|line| line.split(' ').next())
        .expect("a mark with a time");
    let since = stack.expect(0, &["logs", "Printer0", "--since", time]).out;
    assert!(
        !since.contains(before.as_str()) && since.starts_with(time),
        "{since}"
    );
    stack.expect(2, &["logs", "Printer0", "--since", "yesterday"]);

    let all = stack.expect(0, &["logs", "--system", "hello"]).out;
    assert!(all.lines().all(|line| line.starts_with('[')), "{all}");
    let times: Vec<_> = all.lines().filter_map(|l| l.split(' ').nth(1)).collect();
    assert!(times.is_sorted(), "{all}");
    let one = stack
        .expect(0, &["logs", "Printer0", "--prefix", "--tail", "1"])
        .out;
    assert!(one.starts_with("[Printer0] 2"), "{one}");
    let said = stack.expect(2, &["logs", "Nobody0", "Printer0"]);
    assert!(
        said.err.contains("there are: Filter0, Printer0, Sine0"),
        "{said:#?}"
    );
    let said = stack.expect(2, &["logs", "--system", "nothing"]);
    assert!(said.err.contains("there are: hello"), "{said:#?}");
    stack.leaves_nothing();
}

#[test]
fn followers_are_bounded_and_leave_nothing_behind() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let follow = || -> (UnixStream, String) {
        let socket = stack.home().join("run/local/agent.sock");
        let mut stream = UnixStream::connect(socket).expect("an agent");
        stream
            .set_read_timeout(Some(Duration::from_secs(10)))
            .expect("a socket");
        let request = "GET /v1/components/Sine0/log?follow=true HTTP/1.1\r\nHost: x\r\n\r\n";
        stream.write_all(request.as_bytes()).expect("a request");
        let mut status = [0; 12];
        stream.read_exact(&mut status).expect("an answer");
        (stream, String::from_utf8_lossy(&status[9..]).into_owned())
    };
    let mut all: Vec<_> = (0..64).map(|_| follow()).collect();
    assert!(all.iter().all(|(_, status)| status == "200"));
    assert_eq!(follow().1, "503");
    all.clear();
    let end = Instant::now() + Duration::from_secs(10);
    while follow().1 != "200" {
        assert!(Instant::now() < end, "those that went away still count");
        std::thread::sleep(Duration::from_millis(50));
    }
    let open = fs::read_dir(format!("/proc/{}/fd", daemon(&stack, "rts-agent")));
    let open = open.expect("a process").flatten();
    let logs = open.filter(|fd| {
        fs::read_link(fd.path()).is_ok_and(|file| file.ends_with("components/Sine0.log"))
    });
    assert!(logs.count() <= 1, "files are left open");
    stack.leaves_nothing();
}

/// The objects of a stream of JSON Lines, whose first line must say what they are.
fn changes(text: &str) -> Vec<Value> {
    let mut lines = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON on each line"));
    let first = lines.next().expect("a first line");
    assert_eq!(first["apiVersion"], "rtsctl.dev/v1");
    lines.collect()
}

#[test]
fn objects_are_watched_through_kill_9_of_the_controller() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let arguments = ["get", "components", "-w", "-o", "json"];
    let mut json = Beside::start(&stack, "json", &arguments);
    let mut only = Beside::start(&stack, "only", &["get", "comp", "Printer0", "--watch-only"]);
    let mut table = Beside::start(&stack, "table", &["get", "components", "-w"]);
    table.until("the list comes", |table| table.out().lines().count() == 4);
    json.until("the list comes", |json| json.out().lines().count() == 4);
    assert!(changes(&json.out()).iter().all(|c| c["type"] == "ADDED"));
    kill(daemon(&stack, "rts-controller"));
    for beside in [&json, &only, &table] {
        beside.until("it says so", |beside| beside.err().contains("trying again"));
    }
    heal(&stack);
    for beside in [&json, &only, &table] {
        beside.until("it says so", |beside| {
            beside.err().contains("answers again")
        });
    }
    let before = pid(&stack, "Printer0");
    kill(before);
    let back = |c: &Value| {
        let status = &c["object"]["status"];
        c["object"]["metadata"]["name"] == "Printer0"
            && status["state"] == "Active"
            && status["pid"].as_u64() != Some(before.into())
    };
    json.until("Printer0 is told to be back", |json| {
        changes(&json.out()).iter().any(back)
    });
    only.until("its rows come", |only| {
        only.out().lines().skip(1).any(|row| row.contains("Active"))
    });
    assert!(!only.out().contains("Sine0"), "{}", only.out());
    for beside in [&mut json, &mut only, &mut table] {
        beside.signal("INT");
        assert_eq!(beside.end(), 130);
    }
    assert!(table.out().starts_with("NAME "), "{}", table.out());
    assert_eq!(table.out().matches("NAME ").count(), 1);
    stack.expect(2, &["get", "components", "Nobody0", "-w"]);
    stack.leaves_nothing();
}

#[test]
fn events_come_once_each_also_from_a_new_controller() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    let mut watch = Beside::start(&stack, "events", &["events", "-w", "-o", "json"]);
    let arguments = ["events", "-w", "--for", "comp/Printer0", "-o", "json"];
    let about = Beside::start(&stack, "about", &arguments);
    let of_controller = ["get", "events", "-o", "name"];
    let first = stack.expect(0, &of_controller).out;
    watch.until("they come", |watch| {
        watch.out().lines().count() > first.lines().count()
    });
    kill(daemon(&stack, "rts-controller"));
    watch.until("it says so", |watch| watch.err().contains("trying again"));
    heal(&stack);
    kill(pid(&stack, "Printer0"));
    watch.until("what happens then is told", |watch| {
        let all = changes(&watch.out());
        let died = |c: &Value| c["object"]["spec"]["object"] == "component/Printer0";
        all.iter().skip(first.lines().count()).any(died)
    });
    heal(&stack);
    let now = stack.expect(0, &of_controller).out;
    watch.until("all are told", |watch| {
        let told = changes(&watch.out());
        let name = |c: &Value| {
            format!(
                "event/{}",
                c["object"]["metadata"]["name"].as_str().unwrap_or("")
            )
        };
        let told: Vec<_> = told.iter().map(name).collect();
        now.lines()
            .all(|event| told.iter().any(|name| name == event))
    });
    let all = changes(&watch.out());
    let mut names: Vec<_> = all
        .iter()
        .map(|c| c["object"]["metadata"]["uid"].to_string())
        .collect();
    let told = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), told, "no event twice");
    about.until("its events are told", |about| {
        about.out().lines().count() > 1
    });
    let other = |c: &Value| c["object"]["spec"]["object"] != "component/Printer0";
    assert!(!changes(&about.out()).iter().any(other), "{}", about.out());
    watch.signal("INT");
    assert_eq!(watch.end(), 130);
    stack.leaves_nothing();
}

/// One component that waits for `ms` before it is activated.
fn slow(stack: &Stack, ms: u32) -> String {
    let text = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:test:slow:1.0" rts:version="0.2" xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:rtsctl:example:ConfigSample:1.0" rts:instanceName="slow0" rts:pathUri="localhost/slow0.rtc" rts:isRequired="true"/>
  <rts:Activation><rts:targets rts:sequence="1"><rts:TargetComponent rts:id="0" rts:instanceName="slow0" rts:componentId=""/><rts:WaitTime rts:waitTime="{ms}"/></rts:targets></rts:Activation>
</rts:RtsProfile>
"#
    );
    stack.write("slow.xml", text).to_string_lossy().into_owned()
}

#[test]
fn ctrl_c_ends_the_waiting_and_the_controller_goes_on() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let file = slow(&stack, 4000);
    let mut apply = Beside::start(&stack, "apply", &["apply", &file]);
    apply.until("it waits", |apply| apply.err().contains("active"));
    apply.signal("INT");
    assert_eq!(apply.end(), 130);
    let err = apply.err();
    assert!(
        err.contains("the controller goes on with system/slow"),
        "{err}"
    );
    assert!(err.contains("rtsctl describe system/slow"), "{err}");
    stack.until("systems", "it converges all the same", |systems| {
        systems.iter().any(|s| s["status"]["phase"] == "Converged")
    });
    stack.leaves_nothing();
}

#[test]
fn a_second_ctrl_c_ends_a_program_that_hangs() {
    let stack = Stack::new();
    stack.expect(0, &["apply", HELLO]);
    // Nobody reads: the pipe is full after 64 KiB.
    let (reader, writer) = std::io::pipe().expect("a pipe");
    let text = "2026-01-02T03:04:05.000Z INFO x\n".repeat(9000);
    fs::write(log(&stack, "Sine0"), text).expect("a log");
    let mut command = stack.command(&["logs", "-f", "Sine0", "--tail", "9000"]);
    let mut beside = Beside {
        child: command.stdout(writer).spawn().expect("rtsctl starts"),
        out: stack.write("out", ""),
        err: stack.write("err", ""),
    };
    drop(command);
    std::thread::sleep(Duration::from_secs(2));
    beside.signal("INT");
    std::thread::sleep(Duration::from_millis(500));
    if beside.child.try_wait().expect("a child").is_none() {
        beside.signal("INT");
    }
    assert_eq!(beside.end(), 130);
    drop(reader);
    stack.leaves_nothing();
}

#[test]
fn an_apply_that_was_killed_is_taken_up_by_the_next_one() {
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let file = slow(&stack, 3000);
    for wait in [0, 50, 200, 1000] {
        let mut apply = Beside::start(&stack, "apply", &["apply", &file]);
        std::thread::sleep(Duration::from_millis(wait));
        let _ = apply.child.kill();
        apply.end();
    }
    stack.expect(0, &["apply", &file]);
    stack.expect(0, &["diff", &file]);
    stack.expect(0, &["teardown", "slow", "--yes"]);
    stack.leaves_nothing();
}
