//! The system of the manifest in a stack of its own, and what is asked of it.

use std::time::{Duration, Instant};

use rts_host::cgroup::VARIABLE;
use rts_tests::{Said, Stack, Witness, alive, kill};
use serde_json::Value;

use super::grandchildren::left_by_components;

const PROFILE: &str = "manifests/misbehaving/misbehaving.rtsys.xml";
pub const BAD: &str = "Misbehaving0";

/// What hangs is told after a second.
pub const PATIENCE: &[(&str, &str)] = &[("startTimeout", "1s"), ("livenessTimeout", "1s")];
/// What hangs is replaced after a second, once.
pub const ONCE: &[(&str, &str)] = &[
    ("startTimeout", "1s"),
    ("livenessTimeout", "1s"),
    ("onHang", "restart"),
    ("restartLimit", "1"),
];
pub const SOON: Duration = Duration::from_secs(6);

/// The system of the manifest in a stack of its own.
pub struct Lab {
    pub stack: Stack,
    pub file: String,
    pub overlay: String,
    /// `RTSCTL_CGROUP`, for whatever starts the agent.
    pub cgroups: String,
}

impl Lab {
    /// With a fault that comes 0.2 s after the activation, and policies (`restart`) of the component that has it.
    pub fn new(fault: &str, policies: &[(&str, &str)]) -> Self {
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
    pub fn set(&mut self, fault: &str, parameters: &[(&str, &str)]) {
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
    pub fn apply(&self, codes: &str) -> Said {
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
    pub fn until(&self, state: &str, why: &str) -> Value {
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
    pub fn bystanders(&self) -> Witness {
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
    pub fn neighbours_are_kept(&self, before: &Witness) {
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
    pub fn event(&self, reason: &str, text: &str) {
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
    pub fn ends_within(&self, limit: Duration) {
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
pub fn family(stack: &Stack) -> Vec<u32> {
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
pub fn all<const WORDS: usize>(cases: &[&str], test: impl Fn([&str; WORDS]) + Sync) {
    std::thread::scope(|scope| {
        for case in cases {
            let words: Vec<&str> = case.splitn(WORDS, ' ').collect();
            scope.spawn(|| test(words.try_into().expect("all words")));
        }
    });
}

pub fn number(word: &str) -> i32 {
    word.parse().expect("a number")
}
