//! A manager of protocol version 1, played from a recording of a real one (`tests/recorded/v1.jsonl`), so that tests can
//! see today's agent with a manager that was started before an upgrade.
//!
//! It takes the arguments of a manager, and `--component NAME[:STATE]` for each component that it holds from the start
//! (STATE is `Active` when left out), `--type NAME` and `--recreate-hash HASH` for these. It has the run folder of a
//! manager, knows the requests by their `op`, and answers with recorded frames in which names, ids, incarnations and pid
//! are exchanged for those of the moment. Its components do nothing. `configure` with `mode` = `error_after` sends one
//! that is Active to Error, as it did in the recording.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use rts_host::identity::{boot_id, start_ticks};
use serde_json::Value;

const RECORDED: &str = include_str!("../tests/recorded/v1.jsonl");
const INSTANCE: &str = "Faulty0";
const UUID: &str = "00000000-0000-4000-8000-00000000000";
const SYSTEM: &str = r#"{"name":"demo","uid":"00000000-0000-4000-8000-000000000001"}"#;

type Failed = Box<dyn Error + Send + Sync>;

#[derive(Clone)]
struct Component {
    incarnation: String,
    type_name: String,
    recreate_hash: String,
    state: String,
}

struct Previous {
    dir: PathBuf,
    name: String,
    /// As JSON.
    system: String,
    incarnation: String,
    components: Mutex<BTreeMap<String, Component>>,
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Failed> {
    let previous = Arc::new(Previous::from_arguments()?);
    fs::create_dir_all(&previous.dir)?;
    let _lock = rts_host::files::lock(&previous.dir.join("lock"))?.ok_or("the folder is held")?;
    let socket = previous.dir.join("control.sock");
    let _ = fs::remove_file(&socket);
    let listener = UnixListener::bind(&socket)?;
    let description = previous.own(recorded("manager.json", "file")?)?;
    fs::write(previous.dir.join("manager.json"), description)?;
    previous.end_at_sigterm()?;
    if let Ok(stdin) = std::io::stdin().as_fd().try_clone_to_owned()
        && fs::read_link("/proc/self/fd/0").is_ok_and(|to| to.to_string_lossy().contains("socket:"))
    {
        previous.serve(UnixStream::from(stdin));
    }
    for stream in listener.incoming() {
        previous.serve(stream?);
    }
    Ok(())
}

/// The recorded frame of a step, as it was written.
fn recorded(step: &str, from: &str) -> Result<&'static str, Failed> {
    let begin = format!(r#"{{"step":"{step}","from":"{from}","frame":"#);
    RECORDED
        .lines()
        .find_map(|line| line.strip_prefix(&begin)?.strip_suffix('}'))
        .ok_or_else(|| format!("no frame was recorded for {step}").into())
}

impl Previous {
    fn from_arguments() -> Result<Self, Failed> {
        let mut options: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let mut arguments = std::env::args().skip(1);
        while let Some(name) = arguments.next() {
            let value = arguments.next().ok_or("a value is missing")?;
            options.entry(name).or_default().push(value);
        }
        let one = |name: &str| options.get(name).and_then(|values| values.last().cloned());
        let needed = |name: &str| one(name).ok_or_else(|| format!("{name} is missing"));
        let system = match (one("--system-name"), one("--system-uid")) {
            (Some(name), Some(uid)) => serde_json::json!({ "name": name, "uid": uid }).to_string(),
            _ => "null".to_owned(),
        };
        let component = |text: &String| {
            let (name, state) = text.split_once(':').unwrap_or((text, "Active"));
            let component = Component {
                incarnation: uuid::Uuid::new_v4().to_string(),
                type_name: one("--type").unwrap_or_else(|| "Faulty".to_owned()),
                recreate_hash: one("--recreate-hash").unwrap_or_else(|| "hash".to_owned()),
                state: state.to_owned(),
            };
            (name.to_owned(), component)
        };
        let components = options.get("--component").into_iter().flatten();
        Ok(Self {
            dir: needed("--dir")?.into(),
            name: needed("--name")?,
            system,
            incarnation: one("--incarnation").unwrap_or_else(|| uuid::Uuid::new_v4().to_string()),
            components: Mutex::new(components.map(component).collect()),
        })
    }

    /// A recorded text about the process, of this process.
    fn own(&self, text: &str) -> Result<String, Failed> {
        let pid = std::process::id();
        let ticks = start_ticks(pid).ok_or("no start time")?;
        Ok(text
            .replace(SYSTEM, &self.system)
            .replace(r#""name":"main""#, &format!(r#""name":"{}""#, self.name))
            .replace(&format!("{UUID}2"), &self.incarnation)
            .replace(&format!("{UUID}4"), &boot_id().ok_or("no boot id")?)
            .replace(r#""pid":4711"#, &format!(r#""pid":{pid}"#))
            .replace(r#""startTicks":815"#, &format!(r#""startTicks":{ticks}"#)))
    }

    /// A recorded text about the component, of this one.
    fn of(&self, text: &str, name: &str, component: &Component) -> String {
        text.replace(SYSTEM, &self.system)
            .replace(INSTANCE, name)
            .replace(&format!("{UUID}3"), &component.incarnation)
            .replace(r#""Faulty""#, &format!(r#""{}""#, component.type_name))
            .replace(r#""hash""#, &format!(r#""{}""#, component.recreate_hash))
    }

    fn end_at_sigterm(self: &Arc<Self>) -> Result<(), Failed> {
        let (mut read, write) = UnixStream::pair()?;
        signal_hook::low_level::pipe::register(signal_hook::consts::SIGTERM, write)?;
        let previous = Arc::clone(self);
        thread::spawn(move || {
            if read.read_exact(&mut [0]).is_ok() {
                previous.end();
            }
        });
        Ok(())
    }

    fn end(&self) -> ! {
        for name in ["control.sock", "manager.json"] {
            let _ = fs::remove_file(self.dir.join(name));
        }
        std::process::exit(0)
    }

    fn serve(self: &Arc<Self>, stream: UnixStream) {
        let previous = Arc::clone(self);
        thread::spawn(move || {
            if let Err(error) = previous.converse(stream) {
                let _ = writeln!(std::io::stderr(), "a connection ended: {error}");
            }
        });
    }

    fn converse(&self, mut stream: UnixStream) -> Result<(), Failed> {
        let greeting = read(&mut stream)?;
        // As it was: whoever comes as what it does not know is sent away.
        if !matches!(greeting["role"].as_str(), Some("control" | "data")) {
            return Err("an unknown role".into());
        }
        write(&mut stream, &self.own(recorded("greeting", "manager")?)?)?;
        // As it was: another version is told ours and sent away.
        if greeting["version"] != 1 {
            return Ok(());
        }
        loop {
            let request = read(&mut stream)?;
            let id = request["id"].as_u64().ok_or("a request without id")?;
            let (answer, pushed) = self.answer(&request["body"])?;
            write(&mut stream, &with_id(&answer, id)?)?;
            if let Some(pushed) = pushed {
                write(&mut stream, &pushed)?;
            }
            if request["body"]["op"] == "shutdown" {
                self.end();
            }
        }
    }

    /// The answer to a request, and what is pushed after it.
    fn answer(&self, body: &Value) -> Result<(String, Option<String>), Failed> {
        let op = body["op"].as_str().ok_or("a request without op")?;
        let text = |field: &str| body[field].as_str().unwrap_or_default().to_owned();
        let name = text("instance");
        let mut components = self
            .components
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if op == "create" {
            let component = Component {
                incarnation: uuid::Uuid::new_v4().to_string(),
                type_name: text("typeName"),
                recreate_hash: text("recreateHash"),
                state: "Inactive".to_owned(),
            };
            components.insert(name.clone(), component);
        }
        let mut step = op;
        let mut pushed = None;
        if let Some(component) = components.get_mut(&name) {
            let state = component.state.clone();
            let to = match (op, state.as_str()) {
                ("activate", "Error") => {
                    step = "refusal";
                    "Error"
                }
                ("activate", _) => "Active",
                ("deactivate", "Active") | ("reset", "Error") => "Inactive",
                ("configure", "Active") if body["sets"]["default"]["mode"] == "error_after" => {
                    pushed = Some(self.of(recorded("changed", "manager")?, &name, component));
                    "Error"
                }
                _ => &state,
            };
            component.state = to.to_owned();
        }
        let answer = match op {
            "inventory" => self.inventory(&components)?,
            "loadModule" => recorded(op, "manager")?
                .replace("/modules/libfaulty.so", &text("path"))
                .replace(r#""Faulty""#, &format!(r#""{}""#, text("typeName"))),
            _ => {
                let answer = recorded(step, "manager")?;
                match components.get(&name) {
                    Some(component) => self.of(answer, &name, component),
                    None => answer.to_owned(),
                }
            }
        };
        if op == "delete" {
            components.remove(&name);
        }
        Ok((answer, pushed))
    }

    fn inventory(&self, components: &BTreeMap<String, Component>) -> Result<String, Failed> {
        const BEGIN: &str = r#""components":["#;
        const END: &str = "]}}}}";
        let mut all = Vec::new();
        for (name, component) in components {
            let step = format!("inventory{}", component.state);
            let whole = recorded(&step, "manager")?;
            let (_, one) = whole.split_once(BEGIN).ok_or("no components")?;
            let one = one.strip_suffix(END).ok_or("no end of components")?;
            all.push(self.of(one, name, component));
        }
        let empty = recorded("inventoryEmpty", "manager")?;
        Ok(empty.replace(BEGIN, &format!("{BEGIN}{}", all.join(","))))
    }
}

/// A recorded answer, for the request with this id.
fn with_id(answer: &str, id: u64) -> Result<String, Failed> {
    let (begin, rest) = answer.split_once(r#""id":"#).ok_or("no id")?;
    let (_, rest) = rest.split_once(',').ok_or("no end of the id")?;
    Ok(format!(r#"{begin}"id":{id},{rest}"#))
}

fn read(stream: &mut UnixStream) -> Result<Value, Failed> {
    let mut header = [0; 4];
    stream.read_exact(&mut header)?;
    let mut body = vec![0; u32::from_be_bytes(header).min(1 << 22) as usize];
    stream.read_exact(&mut body)?;
    Ok(serde_json::from_slice(&body)?)
}

fn write(stream: &mut UnixStream, text: &str) -> Result<(), Failed> {
    let length = u32::try_from(text.len())?;
    stream.write_all(&[&length.to_be_bytes(), text.as_bytes()].concat())?;
    Ok(())
}
