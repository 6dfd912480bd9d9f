//! A component that misbehaves in every way that is known: what is said of it, that nobody else is touched, and that a
//! teardown leaves nothing.

use std::path::Path;
use std::time::{Duration, Instant};

use rts_host::cgroup::{Cgroups, Choice, VARIABLE};
use rts_tests::{Said, Stack, Witness, alive, kill, kill_9};
use serde_json::Value;

const PROFILE: &str = "manifests/misbehaving/misbehaving.rtsys.xml";
const BAD: &str = "Misbehaving0";

/// What hangs is told after a second.
const PATIENCE: &[(&str, &str)] = &[("startTimeout", "1s"), ("livenessTimeout", "1s")];
/// What hangs is replaced after a second, once.
const ONCE: &[(&str, &str)] = &[
    ("startTimeout", "1s"),
    ("livenessTimeout", "1s"),
    ("onHang", "restart"),
    ("restartLimit", "1"),
];

/// The system of the manifest in a stack of its own.
struct Lab {
    stack: Stack,
    file: String,
    overlay: String,
    /// `RTSCTL_CGROUP`, for whatever starts the agent.
    cgroups: String,
}

impl Lab {
    /// With a fault that comes 0.2 s after the activation, and policies (`restart`) of the component that has it.
    fn new(fault: &str, policies: &[(&str, &str)]) -> Self {
        let stack = Stack::new();
        let overlay = stack.write("policies.yaml", overlay(policies));
        let mut lab = Self {
            overlay: overlay.display().to_string(),
            file: String::new(),
            stack,
            cgroups: "auto".to_owned(),
        };
        lab.set(fault, &[("after", "0.2")]);
        lab
    }

    /// Writes the profile with other parameters.
    fn set(&mut self, fault: &str, parameters: &[(&str, &str)]) {
        let manifest = rts_tests::root().join(PROFILE);
        let mut text = std::fs::read_to_string(manifest).expect("the manifest");
        for (name, value) in parameters.iter().chain([&("fault", fault)]) {
            let begin = format!(r#"rts:name="{name}" rts:data=""#);
            let (before, rest) = text.split_once(&begin).expect("the parameter");
            let (_, rest) = rest.split_once('"').expect("the end of its value");
            text = format!("{before}{begin}{value}\"{rest}");
        }
        let file = self.stack.write("system.xml", text);
        self.file = file.display().to_string();
    }

    /// Applies it. Of several codes (`0|5`), one is of an apply that ended before what comes after the activation.
    #[track_caller]
    fn apply(&self, codes: &str) -> Said {
        let arguments = ["apply", &self.file, "-f", &self.overlay, "--timeout", "20s"];
        let mut command = self.stack.command(&arguments);
        command.env(VARIABLE, &self.cgroups);
        let output = command.output().expect("rtsctl starts");
        let said = Said {
            code: output.status.code().unwrap_or(-1),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        };
        let allowed = codes.split('|').any(|code| number(code) == said.code);
        assert!(allowed, "apply said {said:#?}, not {codes}");
        said
    }

    /// Waits until the component is in a state for a reason that contains `why`.
    #[track_caller]
    fn until(&self, state: &str, why: &str) -> Value {
        let is = |c: &&Value| {
            let waits = c["status"]["waitingOn"].as_str().unwrap_or_default();
            c["metadata"]["name"] == BAD && c["status"]["state"] == state && waits.contains(why)
        };
        let what = format!("{BAD} is {state} and waits for {why:?}");
        let found = self
            .stack
            .until("components", &what, |all| all.iter().any(|c| is(&c)));
        found.iter().find(is).expect("it was found").clone()
    }

    /// Those that have nothing to do with it.
    fn bystanders(&self) -> Witness {
        self.stack.until_seen("the bystanders receive", |now| {
            let names = now.names();
            names.contains(&"Sine0")
                && names.contains(&"Printer0")
                && now.of("Printer0").info.bindings[0].samples_received > 3
        });
        self.stack.witness().without(&[BAD, "Source0", "Sink0"])
    }

    /// Its neighbours live on in the processes in which they were.
    #[track_caller]
    fn neighbours_are_kept(&self, before: &Witness) {
        let now = self.stack.witness();
        for name in ["Source0", "Sink0"] {
            let (now, before) = (now.of(name), before.of(name));
            assert_eq!(now.pid, before.pid, "{name}");
            assert_eq!(now.info.incarnation, before.info.incarnation, "{name}");
            assert_eq!(
                (&*now.info.state, now.info.restarts),
                ("Active", 0),
                "{name}"
            );
        }
    }

    /// Waits until it is told.
    #[track_caller]
    fn event(&self, reason: &str, text: &str) {
        let deadline = Instant::now() + SOON;
        loop {
            let events = self.stack.expect(0, &["events"]).out;
            let is = |line: &str| line.contains(reason) && line.contains(text);
            if events.lines().any(is) {
                return;
            }
            assert!(
                Instant::now() < deadline,
                "no {reason} {text:?} in {events}"
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// A teardown ends within `limit`, and nothing is left.
    #[track_caller]
    fn ends_within(&self, limit: Duration) {
        let begun = Instant::now();
        self.stack.expect(0, &["teardown", "misbehaving", "--yes"]);
        let took = begun.elapsed();
        assert!(took < limit, "the teardown took {took:?}");
        let left = self.stack.witness();
        assert!(left.names().is_empty(), "{:?} are left", left.names());
        self.stack.leaves_nothing();
        let left = family(&self.stack);
        assert!(left.is_empty(), "processes are left: {left:?}");
    }
}

/// What a failed test leaves of those that no stack can end.
impl Drop for Lab {
    fn drop(&mut self) {
        left_by_components(&self.stack).into_iter().for_each(kill);
    }
}

fn overlay(policies: &[(&str, &str)]) -> String {
    let mut text = format!(
        "apiVersion: rtsctl.dev/v1\nkind: Deployment\nmetadata: {{name: lab}}\nspec:\n  components:\n    {BAD}:\n      isolated: true\n"
    );
    for (key, value) in policies {
        text += &format!("      {key}: {value}\n");
    }
    text
}

/// Live processes that were started for this stack, by their environment: also those that components started.
fn family(stack: &Stack) -> Vec<u32> {
    let home = format!("RTSCTL_HOME={}\0", stack.home().display());
    let entries = std::fs::read_dir("/proc").expect("/proc");
    let pids = entries.filter_map(|e| e.ok()?.file_name().to_str()?.parse::<u32>().ok());
    let is_ours = |pid: &u32| {
        let environment = std::fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
        let mut windows = environment.windows(home.len());
        windows.any(|window| window == home.as_bytes())
    };
    pids.filter(is_ours).filter(|pid| alive(*pid)).collect()
}

/// Each line of words in a stack and a thread of its own; the last word is the rest of the line.
fn all<const WORDS: usize>(cases: &[&str], test: impl Fn([&str; WORDS]) + Sync) {
    std::thread::scope(|scope| {
        for case in cases {
            let words: Vec<&str> = case.splitn(WORDS, ' ').collect();
            scope.spawn(|| test(words.try_into().expect("all words")));
        }
    });
}

fn number(word: &str) -> i32 {
    word.parse().expect("a number")
}

const SOON: Duration = Duration::from_secs(6);

#[test]
fn what_fails_or_panics_is_told() {
    let cases = [
        // Fault, exit code of the apply, state, event, reason.
        "error-initialize 5 Unknown CreateFailed told to fail on_initialize",
        "error-startup 5 Unknown CreateFailed told to fail on_startup",
        "sulk 5 Unknown CreateFailed there is no fault `sulk`; there are none, crash-at-once",
        "error-activate 5 Error ComponentError told to fail on_activated",
        "error-execute 0|5 Error ComponentError told to fail on_execute",
        "panic 0|5 Error ComponentError told to panic in on_execute",
    ];
    all(&cases, |[fault, code, state, event, reason]| {
        let lab = Lab::new(fault, &[]);
        let said = lab.apply(code);
        assert_eq!(said.err.contains(reason), said.code == 5, "{said:#?}");
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        let component = lab.until(state, reason);
        assert_eq!(component["status"]["restarts"], 0, "nothing ended");
        lab.event(event, reason);
        let system = lab.stack.named("systems", "misbehaving");
        assert_eq!(system["status"]["healthy"], false, "{fault}");
        let diff = ["diff", &lab.file, "-f", &lab.overlay];
        lab.stack.expect(1, &diff);
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        lab.ends_within(SOON);
    });
}

#[test]
fn what_crashes_is_made_again_as_its_policy_says() {
    let cases = [
        // Fault, policy, exit code of the apply, restarts, why it stays away.
        "crash-at-once restart never 5 0 ended by signal 6",
        "crash-at-once restartLimit 1 5 0 restartLimit 1",
        "crash-later restartLimit 1 0|5 1 restartLimit 1",
        "exit restart on-failure 0|5 0 on-failure",
    ];
    all(&cases, |[fault, key, value, code, restarts, why]| {
        let mut lab = Lab::new(fault, &[(key, value)]);
        lab.set(fault, &[("after", "0.5")]);
        lab.apply(code);
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        let component = lab.until("Unknown", why);
        assert_eq!(component["status"]["restarts"], number(restarts), "{fault}");
        lab.event("ManagerDied", "ended unexpectedly");
        lab.event("NotRestarted", why);
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        lab.ends_within(SOON);
    });
}

#[test]
fn what_crashes_again_and_again_comes_back_each_time() {
    let cases = ["crash-later 0 signal 6", "exit 3 exit status 3"];
    all(&cases, |[fault, exit_code, exit]| {
        let mut lab = Lab::new(fault, &[("restart", "on-failure")]);
        lab.set(fault, &[("after", "0.3"), ("exit_code", exit_code)]);
        lab.apply("0|5");
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        lab.stack.until("components", "it came back twice", |all| {
            all.iter().any(|c| {
                c["metadata"]["name"] == BAD && c["status"]["restarts"].as_u64() >= Some(2)
            })
        });
        lab.event("ManagerDied", exit);
        lab.event("BackOff", "its process ended by itself");
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        // Mended, it stays.
        lab.set("none", &[("after", "0.3")]);
        lab.apply("0|5");
        lab.stack.until_seen("samples go all the way", |now| {
            let end = &now.of("Sink0").info.bindings[0];
            now.all_active(5) && end.connected && end.samples_received > 3
        });
        lab.ends_within(SOON);
    });
}

#[test]
fn what_hangs_is_told() {
    let cases = [
        // Fault, exit code of the apply, state, callback.
        "hang-initialize 5 Created on_initialize",
        "hang-activate 5 Inactive on_activated",
        "hang-execute 0 Active on_execute",
        "hang-state-update 0 Active on_state_update",
        "hang-abort 0|5 Error on_aborting",
        "hang-error 0|5 Error on_error",
    ];
    all(&cases, |[fault, code, state, callback]| {
        let lab = Lab::new(fault, PATIENCE);
        lab.apply(code);
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        let component = lab.until(state, &format!("has been in {callback} for"));
        assert_eq!(component["status"]["restarts"], 0, "it is reported only");
        lab.event("Hangs", callback);
        let system = lab.stack.named("systems", "misbehaving");
        assert_eq!(system["status"]["healthy"], false, "{fault}");
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        // Not asked first, so that the test does not wait for what hangs; the daemons and all else end at once.
        lab.stack.leaves_nothing();
        assert!(family(&lab.stack).is_empty());
    });
}

#[test]
fn what_hangs_is_replaced_as_often_as_its_policy_allows() {
    let cases = [
        "hang-initialize 5 startTimeout",
        "hang-activate 5 startTimeout",
        "hang-execute 0|5 livenessTimeout",
    ];
    all(&cases, |[fault, code, limit]| {
        let lab = Lab::new(fault, ONCE);
        lab.apply(code);
        let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
        let component = lab.until("Unknown", "restartLimit 1");
        assert_eq!(component["status"]["restarts"], 1);
        lab.event("ManagerExpired", limit);
        lab.event("NotRestarted", "restartLimit 1");
        bystanders.goes_on_undisturbed(&lab.stack);
        lab.neighbours_are_kept(&before);
        lab.ends_within(SOON);
    });
}

#[test]
fn a_teardown_ends_whatever_a_component_does_then() {
    let cases = [
        // Fault, seconds, event.
        "ignore-deactivate 6 ComponentError on_deactivated: told to fail on_deactivated",
        "hang-deactivate 19 DeactivateFailed has been in on_deactivated for 1",
        "hang-shutdown 19 DeleteFailed has been in on_shutdown for 1",
        "hang-finalize 19 DeleteFailed has been in on_finalize for 1",
    ];
    all(&cases, |[fault, seconds, event, text]| {
        let lab = Lab::new(fault, &[]);
        lab.apply("0");
        let process = lab.stack.witness().of(BAD).pid;
        let begun = Instant::now();
        lab.stack.expect(0, &["teardown", "misbehaving", "--yes"]);
        let took = begun.elapsed().as_secs_f64();
        assert!(took < f64::from(number(seconds)), "{fault}: {took} s");
        assert!(!alive(process), "{fault}");
        lab.event(event, text);
        assert_eq!(lab.stack.get("systems").len(), 0);
        lab.stack.leaves_nothing();
        assert!(family(&lab.stack).is_empty());
    });
}

#[test]
fn a_teardown_waits_no_longer_than_the_policy_of_what_hangs() {
    let cases = ["hang-execute", "hang-deactivate", "hang-finalize"];
    all(&cases, |[fault]| {
        let policies = [&PATIENCE[1..], &[("onHang", "restart")]].concat();
        let mut lab = Lab::new(fault, &policies);
        // A second after it is Active, at which the teardown is asked for.
        lab.set(fault, &[("after", "1")]);
        lab.apply("0");
        let process = lab.stack.witness().of(BAD).pid;
        std::thread::sleep(Duration::from_secs(1));
        lab.ends_within(SOON);
        assert!(!alive(process), "{fault}");
        assert!(family(&lab.stack).is_empty());
    });
}

#[test]
fn a_reset_that_hangs_is_no_longer_waited_for_than_its_policy_allows() {
    let policies = [ONCE, &[("resetOnError", "true")]].concat();
    let lab = Lab::new("hang-reset", &policies);
    lab.apply("0|5");
    let begun = Instant::now();
    lab.stack
        .until("components", "its process is replaced", |all| {
            let is = |c: &Value| c["metadata"]["name"] == BAD && c["status"]["restarts"] == 1;
            all.iter().any(is)
        });
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(8), "{took:?}");
    lab.event("ManagerExpired", "on_reset for longer than 1 s");
    lab.event("ResetFailed", "has been in on_reset for longer than 1 s");
    lab.ends_within(SOON);
}

#[test]
fn a_rate_that_it_refuses_leads_to_error() {
    let lab = Lab::new("error-rate-changed", &[]);
    lab.apply("0");
    let text = std::fs::read_to_string(&lab.file).expect("the profile");
    let begin = format!(r#"rts:instanceName="{BAD}""#);
    let own = text.find(&begin).expect("the component");
    let (before, own) = text.split_at(own);
    let changed = format!(
        "{before}{}",
        own.replacen(r#"rts:rate="100.0""#, r#"rts:rate="50.0""#, 1)
    );
    assert_ne!(changed, text, "it has a rate");
    std::fs::write(&lab.file, changed).expect("the profile is written");
    let said = lab.apply("5");
    assert!(
        said.err.contains("told to fail on_rate_changed"),
        "{said:#?}"
    );
    lab.until("Error", "told to fail on_rate_changed");
    lab.event("ComponentError", "told to fail on_rate_changed");
    assert_eq!(lab.stack.witness().of(BAD).info.rate, 50.0);
    // The same again does not pass for well.
    lab.apply("5");
    lab.ends_within(SOON);
}

#[test]
fn what_needs_two_seconds_to_activate_is_waited_for() {
    let lab = Lab::new("slow-activate", &[]);
    let begun = Instant::now();
    lab.apply("0");
    assert!(begun.elapsed() >= Duration::from_secs(2));
    lab.ends_within(SOON);
    // Longer than it may take: told, and good in the end.
    let lab = Lab::new("slow-activate", &[("startTimeout", "1s")]);
    let said = lab.apply("5");
    assert!(said.err.contains("on_activated for 1"), "{said:#?}");
    let bystanders = lab.bystanders();
    lab.stack
        .until("systems", "it is Active in the end", |systems| {
            systems[0]["status"]["healthy"] == true
        });
    bystanders.goes_on_undisturbed(&lab.stack);
    lab.ends_within(SOON);
}

#[test]
fn a_flood_drowns_nobody_and_every_sample_is_accounted_for() {
    let mut lab = Lab::new("flood", &[]);
    lab.apply("0");
    let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
    let flooded = lab.stack.until_seen("many samples are lost", |now| {
        now.of(BAD).info.connectors[0].drops > 10_000
    });
    assert_eq!(flooded.of("Sink0").info.state, "Active");
    lab.stack.until("connectors", "the drops are shown", |all| {
        all.iter().any(|c| {
            c["metadata"]["name"] == "Misbehaving0.out-Sink0.in"
                && c["status"]["drops"].as_u64() > Some(10_000)
        })
    });
    bystanders.goes_on_undisturbed(&lab.stack);
    // Told to stop while it floods, it stops.
    lab.set("none", &[("after", "3600")]);
    lab.apply("0");
    let still = |now: &Witness| {
        let (sent, came) = (
            &now.of(BAD).info.connectors[0],
            &now.of("Sink0").info.bindings[0],
        );
        (
            sent.samples_sent,
            sent.drops + came.drops + came.samples_received,
        )
    };
    // The source sends on, so that the two may differ by what is under way.
    let now = lab
        .stack
        .until_seen("what was sent came or was dropped", |now| {
            let (sent, accounted) = still(now);
            sent.abs_diff(accounted) < 10
        });
    assert_eq!(
        now.of(BAD).info.incarnation,
        before.of(BAD).info.incarnation,
        "a parameter is set in place"
    );
    lab.neighbours_are_kept(&before);
    lab.ends_within(SOON);
}

#[test]
fn what_an_in_port_drops_is_shown_at_its_connector() {
    let lab = Lab::new("error-execute", &[]);
    lab.apply("0|5");
    lab.until("Error", "told to fail on_execute");
    let status = |all: &[Value]| {
        let mut all = all.iter();
        let connector = all.find(|c| c["metadata"]["name"] == "Source0.out-Misbehaving0.in");
        connector.map_or(Value::Null, |c| c["status"].clone())
    };
    // Nobody reads any more: its queue is full, and each new sample drops an old one.
    let seen = lab.stack.until("connectors", "drops are shown", |all| {
        status(all)["drops"].as_u64() > Some(20)
    });
    let [sent, received, drops] =
        ["samplesSent", "samplesReceived", "drops"].map(|key| status(&seen)[key].as_u64());
    let waiting = sent.zip(received).zip(drops);
    let waiting = waiting.map(|((sent, received), drops)| sent - received - drops);
    assert!(waiting <= Some(80), "{seen:#?}");
    lab.ends_within(SOON);
}

#[test]
fn a_leak_is_of_its_own_process() {
    let mut lab = Lab::new("leak", &[]);
    lab.set("leak", &[("after", "0"), ("leak_limit", "48")]);
    lab.apply("0");
    let (before, bystanders) = (lab.stack.witness(), lab.bystanders());
    let leaks = before.of(BAD).pid;
    let deadline = Instant::now() + SOON;
    while memory(leaks) < 48 {
        assert!(Instant::now() < deadline, "{} MiB", memory(leaks));
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(
        memory(before.of("Sink0").pid) < 40,
        "another has no part in it"
    );
    bystanders.goes_on_undisturbed(&lab.stack);
    before.goes_on_undisturbed(&lab.stack);
    assert!(memory(leaks) < 96, "it is bounded: {} MiB", memory(leaks));
    lab.ends_within(SOON);
}

/// MiB of memory that a process holds.
fn memory(pid: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"));
    let kib = line.and_then(|l| l.split_whitespace().next()?.parse::<u64>().ok());
    kib.unwrap_or(0) / 1024
}

/// Whether control groups may be made here; without, what leaves its process group outlives its manager.
fn cgroups_are_permitted() -> bool {
    let nobody = format!("/tmp/rts-nobody-{}", std::process::id());
    match Cgroups::of(Path::new(&nobody), Choice::Auto).create("probe") {
        Ok(probe) => probe.remove().is_ok(),
        Err(e) => {
            eprintln!("only process groups are looked at: {e}");
            false
        }
    }
}

/// Live processes that components of this stack started.
fn left_by_components(stack: &Stack) -> Vec<u32> {
    let is_theirs = |pid: &u32| {
        let comm = std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
        ["sh", "sleep"].contains(&comm.trim())
    };
    family(stack).into_iter().filter(is_theirs).collect()
}

/// Its processes: those in the process group of the manager, and those that left it.
fn children(stack: &Stack, manager: u32) -> (Vec<u32>, Vec<u32>) {
    let group = |pid: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        let rest = stat.rsplit_once(") ").map_or("", |(_, rest)| rest);
        rest.split(' ').nth(2).and_then(|g| g.parse::<u32>().ok())
    };
    let all = left_by_components(stack);
    all.into_iter()
        .partition(|pid| group(*pid) == group(manager))
}

fn grandchildren(cgroups: &str) -> (Lab, Vec<u32>, Vec<u32>) {
    let mut lab = Lab::new("grandchildren", &[]);
    cgroups.clone_into(&mut lab.cgroups);
    lab.apply("0");
    let manager = lab.stack.witness().of(BAD).pid;
    let deadline = Instant::now() + SOON;
    loop {
        let (beside, away) = children(&lab.stack, manager);
        if beside.len() == 2 && away.len() == 2 {
            return (lab, beside, away);
        }
        assert!(Instant::now() < deadline, "{beside:?} {away:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Waits until none of them lives.
#[track_caller]
fn all_end(pids: &[u32]) {
    let deadline = Instant::now() + SOON;
    while pids.iter().any(|pid| alive(*pid)) {
        assert!(Instant::now() < deadline, "of {pids:?} some live");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Ends the manager, and all that it started; what left its process group only where control groups hold it.
fn they_end(cgroups: &str, crash: bool) {
    let (lab, beside, away) = grandchildren(cgroups);
    let held = cgroups == "auto";
    if crash {
        let bystanders = lab.bystanders();
        kill_9(lab.stack.witness().of(BAD).pid);
        all_end(&beside);
        lab.stack
            .until_seen("it runs again", |now| now.all_active(5));
        bystanders.goes_on_undisturbed(&lab.stack);
    }
    lab.stack.expect(0, &["teardown", "misbehaving", "--yes"]);
    assert!(beside.iter().all(|pid| !alive(*pid)), "{beside:?}");
    assert!(away.iter().all(|pid| alive(*pid) != held), "{away:?}");
    lab.stack.expect(0, &["down", "--yes"]);
    let left = family(&lab.stack);
    assert_eq!(left.is_empty(), held, "processes are left: {left:?}");
    left.into_iter().for_each(kill);
    lab.stack.leaves_nothing();
}

#[test]
fn grandchildren_end_with_their_manager() {
    let mut cases = vec!["off teardown", "off crash"];
    if cgroups_are_permitted() {
        cases.extend(["auto teardown", "auto crash"]);
    }
    all(&cases, |[cgroups, end]| they_end(cgroups, end == "crash"));
}
