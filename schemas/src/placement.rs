//! What can be said of a component beside its profile: one meaning, whether it stands in the profile (`rtsctl.*`) or in an
//! overlay.

mod lay;
mod parts;
mod recorded;
mod settings;
mod stand_in;
mod values;

pub use lay::{lay, lay_all};
pub use parts::{keys, later, pointer};
pub use recorded::Values;
pub use settings::{of, settings};
pub use stand_in::StandInSetting;
pub use values::{
    ContextName, ContextOrder, Cpus, ManagerName, MemoryLimit, NodeName, PackageName, Priority,
    Rate, RestartLimit, Time, Value, VersionRange,
};
pub(crate) use values::{milliseconds, spelled_time, time_schema};

use crate::diagnostic::Finding;
use crate::span::{Span, Text};
use crate::system::{
    ComponentSpec, DriftPolicy, ExecutionKind, OnDisconnect, OnHang, RestartPolicy, StandIn,
    StandInFault,
};
use crate::yaml::{self, Node};
use crate::yaml_type::{Definitions, Faults, Leaf, Map, Row, YamlType, yaml_type};

/// The prefix of the keys in a profile; an overlay may leave it away.
pub const PREFIX: &str = "rtsctl.";

/// The keys, without their prefix.
pub const KEYS: &[&str] = Settings::KEYS;

yaml_type! {
    /// What is said of a component. What is not said stays as it is; `null` takes back what was said before.
    pub struct Settings ["unknown-placement-key", "rtsctl."] {
        /// Node that runs it, by its name, an address or an alias.
        node: NodeName = "node";
        /// Manager process that holds it. Components of one node that name the same manager share a process.
        manager: ManagerName = "manager";
        /// Whether it has a process of its own. Beats a manager that is named beside it.
        isolated: bool = "isolated";
        /// When it is started again after its process ended.
        restart: RestartPolicy = "restart";
        /// Most restarts within the restart window; none for no limit.
        restart_limit: RestartLimit = "restartLimit";
        /// Time in which restarts are counted; 10 minutes when nothing is said.
        restart_window: Time = "restartWindow";
        /// Time that initialising and activating may take; 10 seconds when nothing is said.
        start_timeout: Time = "startTimeout";
        /// Time after which a callback that has not returned hangs; 5 seconds when nothing is said.
        liveness_timeout: Time = "livenessTimeout";
        /// What is done when it hangs.
        on_hang: OnHang = "onHang";
        /// What it does when the other end of a connector is lost.
        on_disconnect: OnDisconnect = "onDisconnect";
        /// Whether it is reset when it is in Error.
        reset_on_error: bool = "resetOnError";
        /// What is done when a person changed it by hand.
        drift: DriftPolicy = "drift";
        /// Package that brings its module.
        package: PackageName = "package";
        /// Versions of the package that will do.
        version: VersionRange = "version";
        /// When a stand-in, with its ports but without its code, takes its place; a mapping says how that behaves too.
        stand_in: StandInSetting = "standIn";
        /// The execution context that runs it.
        execution_context: Box<ExecutionContextSettings> = "executionContext";
        /// What it may use of its node.
        resources: ResourceSettings = "resources";
        /// Configuration sets, parameter by parameter, and the active one.
        configuration: ConfigurationSettings = "configuration";
    }
}

yaml_type! {
    /// A stand-in: when there is one, and how it behaves. A plain word says when.
    pub struct StandInSettings {
        /// When it takes the component's place.
        when: StandIn = "when";
        /// Time that its initialising takes.
        startup_time: Time = "startupTime";
        /// The callback in which it fails.
        fail: StandInFault = "fail";
        /// Time after its activation at which it brings its process down.
        crash_after: Time = "crashAfter";
        /// Recorded values that an out-port plays instead of numbers, one in each cycle, and then again from the first.
        data: Map<Values> = "data";
    }
}

yaml_type! {
    /// An execution context. Kind and rate may also be said in the profile, and are then its own there.
    pub struct ExecutionContextSettings {
        /// Execution context that it shares with the other components of its manager that name the same; all run on one
        /// thread, in their order.
        name: ContextName = "name";
        /// Place in that order: lower numbers run first, those with the same by name.
        order: ContextOrder = "order";
        /// What drives it.
        kind: ExecutionKind = "kind";
        /// Rate in hertz.
        rate: Rate = "rate";
    }
}

yaml_type! {
    /// What a component may use of its node.
    pub struct ResourceSettings {
        /// Processors that its execution context runs on.
        cpus: Cpus = "cpus";
        /// SCHED_FIFO priority of its execution context.
        realtime_priority: Priority = "realtimePriority";
        /// Whether the memory of its process is locked, so that nothing of it is ever fetched from a disk.
        lock_memory: bool = "lockMemory";
        /// Whether it is refused where its node does not permit these; `false` runs it all the same, with an event.
        required: bool = "required";
        /// Memory that its process may have; components that share a process add theirs up.
        memory_limit: MemoryLimit = "memoryLimit";
    }
}

yaml_type! {
    /// Configuration of a component. What is not said stays as the profile has it.
    pub struct ConfigurationSettings {
        /// Name of the active set.
        active: Value = "active";
        /// Set, then parameter, then its value; `null` takes a parameter or a whole set away.
        sets: Map<Map<Value>> = "sets";
    }
}

/// It is seldom said, and costs little where it is not.
impl YamlType for Box<ExecutionContextSettings> {
    fn schema(definitions: &mut Definitions) -> serde_json::Value {
        ExecutionContextSettings::schema(definitions)
    }

    fn read(node: &Node, key: &str, faults: &mut Faults) -> Option<Self> {
        ExecutionContextSettings::read(node, key, faults).map(Self::new)
    }

    fn write(&self) -> serde_json::Value {
        self.as_ref().write()
    }

    fn rows(path: &str, doc: &str, rows: &mut Vec<Row>) {
        ExecutionContextSettings::rows(path, doc, rows);
    }

    fn leaves(&self, path: &[&str], span: Span, leaves: &mut Vec<Leaf>) {
        self.as_ref().leaves(path, span, leaves);
    }
}

/// Reads a key of a profile, without its prefix: `node`, or `resources.cpus`.
pub fn read(key: &Text, value: &Text, faults: &mut Faults) -> Option<Settings> {
    let Some(whole) = KEYS.iter().find(|known| **known == first(&key.value)) else {
        let keys = keys();
        let known: Vec<&str> = keys.iter().map(String::as_str).collect();
        faults.unknown_key("unknown-placement-key", &key.value, &known, key.span);
        return None;
    };
    let text = Node {
        value: yaml::Value::Scalar(value.value.as_str().into()),
        span: value.span,
    };
    let inner = parts_of(&key.value).into_iter().skip(1).rev();
    let node = inner.fold(text, |node, part| mapping(part, key.span, node));
    Settings::read(&mapping(whole, key.span, node), "", faults)
}

/// The parts of a key of a profile. The name of a port is one, whatever is in it.
pub fn parts_of(key: &str) -> Vec<&str> {
    match key.strip_prefix("standIn.data.") {
        Some(port) => vec!["standIn", "data", port],
        None => key.split('.').collect(),
    }
}

fn first(key: &str) -> &str {
    key.split('.').next().unwrap_or(key)
}

fn mapping(key: &str, span: Span, node: Node) -> Node {
    Node {
        value: yaml::Value::Mapping([(Text::new(key, span), node)].into()),
        span,
    }
}

/// Sets one key of a component; `key` is without prefix. A later call wins.
///
/// # Errors
/// Unknown key, or a value that the key does not take; the component is then unchanged.
pub fn set(component: &mut ComponentSpec, key: &str, value: &str) -> Result<(), Box<Finding>> {
    let text = |text: &str| Text::new(text, Span::default());
    let mut faults = Faults::default();
    let read = read(&text(key), &text(value), &mut faults);
    match faults.into_first() {
        Some(fault) => Err(Box::new(fault)),
        None => {
            read.iter().for_each(|settings| lay(component, settings));
            Ok(())
        }
    }
}

/// `true`, `false`, `1` or `0`, as XML Schema has it, in any case.
pub fn parse_bool(value: &str) -> Option<bool> {
    match value.trim().to_ascii_lowercase().as_str() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}
