//! A spec as words: target → field → text.

use std::collections::BTreeMap;

use rts_plan::target;
use rts_schemas::system::{
    ComponentSpec, Condition, ConnectorSpec, DriftPolicy, LIVENESS_TIMEOUT_MS, NO_SEQUENCE, OnHang,
    RESTART_WINDOW_MS, START_TIMEOUT_MS, SendingTiming, SystemSpec, WaitFor,
};
use serde_json::Value;

use crate::publish::drift::short;

/// Field → what it is.
pub type Words = BTreeMap<String, Word>;

/// A text as it is shown, and as it is compared.
#[derive(Debug, Clone)]
pub struct Word {
    /// A long one is cut.
    pub text: String,
    whole: String,
}

impl PartialEq for Word {
    fn eq(&self, other: &Self) -> bool {
        self.whole == other.whole
    }
}

impl Word {
    fn new(whole: String) -> Self {
        let text = short(&whole);
        Self { text, whole }
    }
}

/// Fields of a component's JSON that a plan names otherwise, by how they begin.
const NAMES: [(&str, &str); 4] = [
    ("configuration.sets.", "configuration."),
    ("executionContext.rate", "rate"),
    ("executionContext.kind", "executionKind"),
    ("policy.onDisconnect", "onDisconnect"),
];

/// All that a spec says, but for the order of its components and connectors.
pub fn words(spec: &SystemSpec) -> BTreeMap<String, Words> {
    let components = spec.components.iter();
    let components = components.map(|c| (target::component(&c.instance), component(c)));
    let connectors = spec.connectors.iter();
    let connectors = connectors.map(|c| (target::connector(&c.name), connector(c)));
    let system = (format!("system/{}", spec.name), whole(spec));
    components.chain(connectors).chain([system]).collect()
}

fn component(spec: &ComponentSpec) -> Words {
    let defaults = [
        ("policy.drift", DriftPolicy::default().as_str().to_owned()),
        ("policy.onHang", OnHang::default().as_str().to_owned()),
        ("policy.restartWindowMs", RESTART_WINDOW_MS.to_string()),
        ("policy.startTimeoutMs", START_TIMEOUT_MS.to_string()),
        ("policy.livenessTimeoutMs", LIVENESS_TIMEOUT_MS.to_string()),
    ];
    let defaults = defaults.into_iter();
    let mut words: Words = defaults
        .map(|(name, text)| (name.to_owned(), Word::new(text)))
        .collect();
    // Nothing of a spec can fail to become JSON.
    flatten(
        "",
        &serde_json::to_value(spec).unwrap_or_default(),
        &mut words,
    );
    words
}

/// The leaves of a JSON value; a list is one.
fn flatten(path: &str, value: &Value, words: &mut Words) {
    let text = match value {
        Value::Object(fields) => {
            let join = |name: &str| match path {
                "" => name.to_owned(),
                _ => format!("{path}.{name}"),
            };
            fields
                .iter()
                .for_each(|(name, value)| flatten(&join(name), value, words));
            return;
        }
        Value::Null => return,
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let mut names = NAMES.iter();
    let known = names.find_map(|(long, name)| Some(format!("{name}{}", path.strip_prefix(long)?)));
    words.insert(known.unwrap_or_else(|| path.to_owned()), Word::new(text));
}

fn connector(spec: &ConnectorSpec) -> Words {
    let ends = [
        ("source", spec.source.to_string()),
        ("target", spec.target.to_string()),
        ("kind", format!("{:?}", spec.kind).to_lowercase()),
    ];
    let ends = ends.into_iter().map(|(name, text)| (name.to_owned(), text));
    let data_type = spec
        .data_type
        .iter()
        .map(|id| ("dataType".to_owned(), id.clone()));
    let properties = spec.properties.iter();
    let properties = properties.map(|(key, value)| (format!("properties.{key}"), value.clone()));
    let all = ends.chain(data_type).chain(properties);
    all.map(|(name, text)| (name, Word::new(text))).collect()
}

fn whole(spec: &SystemSpec) -> Words {
    let orders = &spec.orders;
    let orders = [
        ("startUp", &orders.start_up),
        ("shutDown", &orders.shut_down),
        ("activation", &orders.activation),
        ("deactivation", &orders.deactivation),
        ("resetting", &orders.resetting),
        ("initializing", &orders.initializing),
        ("finalizing", &orders.finalizing),
    ];
    let orders = orders.into_iter().filter(|(_, all)| !all.is_empty());
    let orders = orders.map(|(name, all)| (format!("orders.{name}"), conditions(all)));
    let id = ("fullId".to_owned(), Word::new(spec.full_id.clone()));
    orders.chain([id]).collect()
}

/// `A0 1, B0 2 sync A0`
fn conditions(all: &[Condition]) -> Word {
    let texts: Vec<String> = all.iter().map(condition).collect();
    Word::new(texts.join(", "))
}

fn condition(condition: &Condition) -> String {
    let Condition {
        target,
        sequence,
        wait,
    } = condition;
    let wait = match wait {
        None => String::new(),
        Some(WaitFor::Time { milliseconds }) => format!(" wait {milliseconds} ms"),
        Some(WaitFor::Preceding {
            timing,
            timeout_ms,
            components,
        }) => {
            let timing = match timing {
                SendingTiming::Sync => "sync",
                SendingTiming::Async => "async",
            };
            let limit = match timeout_ms {
                0 => String::new(),
                limit => format!(" for {limit} ms"),
            };
            format!(" {timing} {}{limit}", components.join("+"))
        }
    };
    let number = match *sequence {
        NO_SEQUENCE => String::new(),
        number => format!(" {number}"),
    };
    format!("{target}{number}{wait}")
}
