//! A real manager process for tests, and short ways to ask it things.

#![allow(dead_code, reason = "each test program uses its part")]
#![allow(
    clippy::unwrap_used,
    reason = "a failure here is a failed test; clippy only knows test functions"
)]

use std::collections::BTreeMap;
use std::io::BufReader;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rts_manager_api::client::{CallError, Client};
use rts_manager_api::control::*;
use rts_manager_api::{PROTOCOL_VERSION, frame};

/// Time for anything that should take milliseconds.
pub const SOON: Duration = Duration::from_secs(10);

/// A manager that dies with the test.
pub struct Running {
    pub child: Child,
    pub dir: PathBuf,
    _home: tempfile::TempDir,
}

/// Path of something that cargo builds for this package's tests.
pub fn built(name: &str) -> PathBuf {
    // target/debug/deps/<this test> -> target/debug/examples/<name>
    let mut path = std::env::current_exe().unwrap();
    path.pop();
    path.pop();
    path.push("examples");
    path.push(name);
    assert!(
        path.exists(),
        "{} is missing: cargo build -p rts-manager --examples",
        path.display()
    );
    path
}

pub fn command(dir: &Path, name: &str) -> Command {
    let mut command = Command::new(built("manager"));
    command
        .arg("--dir")
        .arg(dir)
        .args(["--name", name, "--incarnation", "i-1"])
        .stdin(Stdio::null());
    command
}

/// Starts a manager and waits until its socket is there.
pub fn start(name: &str) -> Running {
    start_with(name, &[])
}

/// Starts a manager with further variables in its environment.
pub fn start_with(name: &str, variables: &[(&str, &str)]) -> Running {
    let home = tempfile::Builder::new()
        .prefix("rtm")
        .tempdir_in("/tmp")
        .unwrap();
    let dir = home.path().join("m");
    let mut command = command(&dir, name);
    let child = command.envs(variables.iter().copied()).spawn().unwrap();
    let running = Running {
        child,
        dir,
        _home: home,
    };
    until("the manager serves", || {
        UnixStream::connect(running.socket()).is_ok()
    });
    running
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Running {
    pub fn socket(&self) -> PathBuf {
        self.dir.join("control.sock")
    }

    /// A connection that has not greeted yet.
    pub fn connect(&self) -> UnixStream {
        let stream = UnixStream::connect(self.socket()).unwrap();
        stream.set_read_timeout(Some(SOON)).unwrap();
        stream
    }

    pub fn client(&self) -> Client {
        Client::connect(&self.socket(), SOON).unwrap()
    }

    pub fn log_path(&self, instance: &str) -> PathBuf {
        self.dir.parent().unwrap().join(format!("{instance}.log"))
    }

    pub fn log(&self, instance: &str) -> String {
        std::fs::read_to_string(self.log_path(instance)).unwrap()
    }

    /// A request for a Testmod with these parameters in its default set.
    pub fn testmod(&self, instance: &str, parameters: &[(&str, &str)]) -> RequestBody {
        RequestBody::Create(CreateRequest {
            instance: instance.to_owned(),
            type_name: "Testmod".to_owned(),
            system: None,
            recreate_hash: "h".to_owned(),
            restarts: 0,
            sets: default_set(parameters),
            active: None,
            execution_kind: "periodic".to_owned(),
            rate: None,
            log_path: self.log_path(instance).display().to_string(),
            on_disconnect: None,
            stand_in: None,
            realtime: None,
            execution_context: None,
        })
    }

    /// Loads Testmod and creates one; returns its incarnation.
    pub fn create(&self, instance: &str, parameters: &[(&str, &str)]) -> String {
        let mut client = self.client();
        ok(&mut client, load_testmod());
        match ok(&mut client, self.testmod(instance, parameters)) {
            ResponseBody::Created { incarnation } => incarnation,
            other => panic!("{other:?}"),
        }
    }

    pub fn signal(&self, signal: &str) {
        let pid = self.child.id().to_string();
        let status = Command::new("kill").args([signal, &pid]).status().unwrap();
        assert!(status.success());
    }

    pub fn wait(&mut self) -> ExitStatus {
        let mut status = None;
        until("the manager ends", || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        status.unwrap()
    }
}

pub fn default_set(parameters: &[(&str, &str)]) -> BTreeMap<String, BTreeMap<String, String>> {
    let values = parameters
        .iter()
        .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()))
        .collect();
    BTreeMap::from([("default".to_owned(), values)])
}

pub fn load_testmod() -> RequestBody {
    RequestBody::LoadModule {
        type_name: "Testmod".to_owned(),
        path: built("libtestmod.so").display().to_string(),
        digest: None,
    }
}

pub fn activate(instance: &str) -> RequestBody {
    RequestBody::Activate {
        instance: instance.to_owned(),
    }
}

pub fn deactivate(instance: &str) -> RequestBody {
    RequestBody::Deactivate {
        instance: instance.to_owned(),
        by_hand: None,
    }
}

pub fn binding(connector: &str, instance: &str, port: &str, source: &str) -> RequestBody {
    RequestBody::Bind(Binding {
        connector: connector.to_owned(),
        instance: instance.to_owned(),
        port: port.to_owned(),
        source: source.to_owned(),
    })
}

pub fn unbind(connector: &str) -> RequestBody {
    RequestBody::Unbind {
        connector: connector.to_owned(),
    }
}

pub fn disconnect(instance: &str, connector: &str) -> RequestBody {
    RequestBody::Disconnect {
        instance: instance.to_owned(),
        connector: connector.to_owned(),
        by_hand: None,
    }
}

/// A request to connect `from`.out to `to`.in, over a socket when one is given.
pub fn connection(
    from: &str,
    to: &str,
    incarnation: &str,
    socket: Option<&Path>,
) -> ConnectRequest {
    ConnectRequest {
        connector: format!("{from}.out-{to}.in"),
        instance: from.to_owned(),
        port: "out".to_owned(),
        target_instance: to.to_owned(),
        target_port: "in".to_owned(),
        target_socket: socket.map(|path| path.display().to_string()),
        target_incarnation: incarnation.to_owned(),
        between_nodes: false,
        properties: BTreeMap::from([("k".to_owned(), "v".to_owned())]),
        by_hand: None,
    }
}

pub fn ok(client: &mut Client, body: RequestBody) -> ResponseBody {
    let text = format!("{body:?}");
    client
        .call(body, SOON)
        .unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// The refusal that a request must get.
pub fn refused(client: &mut Client, body: RequestBody, deadline: Duration) -> Failure {
    match client.call(body, deadline) {
        Err(CallError::Refused(failure)) => failure,
        other => panic!("{other:?}"),
    }
}

pub fn inventory(client: &mut Client) -> ManagerInventory {
    match ok(client, RequestBody::Inventory) {
        ResponseBody::Inventory(inventory) => inventory,
        other => panic!("{other:?}"),
    }
}

pub fn component(client: &mut Client, instance: &str) -> ComponentInfo {
    inventory(client)
        .components
        .into_iter()
        .find(|component| component.instance == instance)
        .unwrap_or_else(|| panic!("no {instance}"))
}

pub fn until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < SOON, "not within {SOON:?}: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Sets values of the default set.
pub fn configure(instance: &str, parameters: &[(&str, &str)]) -> RequestBody {
    RequestBody::Configure {
        instance: instance.to_owned(),
        sets: default_set(parameters),
        active: None,
        rate: None,
        on_disconnect: None,
        order: None,
        by_hand: None,
    }
}

/// Configures nothing but the policy for a lost peer.
pub fn on_disconnect(instance: &str, policy: &str) -> RequestBody {
    RequestBody::Configure {
        instance: instance.to_owned(),
        sets: BTreeMap::new(),
        active: None,
        rate: None,
        on_disconnect: Some(policy.to_owned()),
        order: None,
        by_hand: None,
    }
}

/// A control connection that keeps pushed events.
pub struct Listener(BufReader<UnixStream>);

impl Listener {
    pub fn connect(running: &Running) -> Self {
        let mut stream = running.connect();
        let greeting = Greeting::Control {
            version: PROTOCOL_VERSION,
        };
        frame::write(&mut stream, &greeting).unwrap();
        let mut reader = BufReader::new(stream);
        let hello: Hello = frame::read(&mut reader).unwrap();
        assert_eq!(hello.version, PROTOCOL_VERSION);
        let mut listener = Self(reader);
        // The hello leaves before the subscription; an answered request proves that it stands.
        let request = Request {
            id: 0,
            deadline_ms: 1000,
            body: RequestBody::Factories,
        };
        frame::write(listener.0.get_mut(), &request).unwrap();
        let answer: FromManager = frame::read_answer(&mut listener.0).unwrap();
        assert!(matches!(answer, FromManager::Response(_)));
        listener
    }

    /// The next event of a target.
    pub fn event(&mut self, target: &str) -> String {
        loop {
            if let FromManager::Changed(changed) = frame::read_answer(&mut self.0).unwrap()
                && changed.target == target
            {
                return changed.message;
            }
        }
    }
}
