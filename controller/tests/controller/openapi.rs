//! The description of the API is whole: every reference resolves, every path is there, and answers.

use std::collections::BTreeSet;

use rts_controller_api::objects::Kind;
use rts_controller_api::paths;
use serde_json::Value;

fn document() -> Value {
    serde_json::to_value(rts_controller::openapi()).unwrap()
}

fn references(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            if let Some(Value::String(to)) = map.get("$ref") {
                found.insert(to.clone());
            }
            map.values().for_each(|v| references(v, found));
        }
        Value::Array(list) => list.iter().for_each(|v| references(v, found)),
        _ => {}
    }
}

/// Its own fields, and those of what is flattened into it.
fn fields<'a>(document: &'a Value, schema: &str) -> Vec<&'a str> {
    let schema_of = |name: &str| &document["components"]["schemas"][name];
    let whole = schema_of(schema);
    let parts = whole["allOf"].as_array().into_iter().flatten();
    let parts = parts.map(|part| match part["$ref"].as_str() {
        Some(to) => schema_of(to.rsplit('/').next().unwrap_or_default()),
        None => part,
    });
    let all = parts.chain([whole]);
    let properties = all.filter_map(|part| part["properties"].as_object());
    let names: Vec<_> = properties
        .flat_map(|p| p.keys().map(String::as_str))
        .collect();
    assert!(!names.is_empty(), "there is no schema {schema}");
    names
}

#[test]
fn every_reference_resolves() {
    let document = document();
    let mut found = BTreeSet::new();
    references(&document, &mut found);
    assert!(found.len() > 20);
    let dangling: Vec<_> = found
        .iter()
        .filter(|to| document.pointer(to.trim_start_matches('#')).is_none())
        .collect();
    assert!(dangling.is_empty(), "{dangling:?}");
}

#[test]
fn every_kind_has_a_schema_of_its_own() {
    let document = document();
    for kind in Kind::ALL {
        let kind = format!("{kind:?}");
        let all = ["apiVersion", "kind", "metadata", "spec", "status"];
        assert_eq!(fields(&document, &kind), all, "{kind}");
        let schemas = document["components"]["schemas"].as_object().unwrap();
        for generic in ["List", "WatchEvent"] {
            assert!(schemas.contains_key(&format!("{generic}_{kind}")), "{kind}");
        }
    }
    let schema = |kind: &str, part: &str| {
        let to = &document["components"]["schemas"][kind]["properties"][part]["$ref"];
        to.as_str().unwrap().rsplit('/').next().unwrap().to_owned()
    };
    let has = |kind: &str, part: &str, wanted: &[&str]| {
        let schema = schema(kind, part);
        let fields = fields(&document, &schema);
        for field in wanted {
            assert!(fields.contains(field), "{kind}.{part}.{field}");
        }
    };
    let metadata = [
        "name",
        "uid",
        "resourceVersion",
        "generation",
        "labels",
        "creationTimestamp",
    ];
    has("System", "metadata", &metadata);
    has(
        "System",
        "spec",
        &["name", "components", "connectors", "orders"],
    );
    has(
        "System",
        "status",
        &["observedGeneration", "synced", "healthy", "conditions"],
    );
    has("Component", "spec", &["system", "type"]);
    let status = [
        "state",
        "node",
        "manager",
        "pid",
        "restarts",
        "standIn",
        "incarnation",
        "waitingOn",
        "lastKnownState",
    ];
    has("Component", "status", &status);
    has("Connector", "spec", &["kind", "source", "target"]);
    has(
        "Connector",
        "status",
        &["state", "samplesSent", "samplesReceived", "bytes", "drops"],
    );
    has("Manager", "status", &["node", "pid", "components"]);
    has("Node", "status", &["state", "lastSeen"]);
}

#[test]
fn every_path_of_the_api_is_described() {
    let document = document();
    let described: BTreeSet<&str> = document["paths"]
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    let lists: Vec<String> = Kind::ALL.into_iter().map(paths::objects).collect();
    let mut known: BTreeSet<&str> = lists.iter().map(String::as_str).collect();
    known.extend([
        paths::SYSTEM,
        paths::SYSTEM_PLAN,
        paths::SYSTEM_SIMULATE,
        paths::SYSTEM_EXPORT,
        paths::NODE_ACTS,
        paths::NODE,
        paths::NODE_ADOPT,
        paths::NODE_TAKE_OVER,
        paths::BACKUP,
        paths::TIMINGS,
        paths::COMPONENT,
        paths::COMPONENT_LOG,
        paths::PORT_SAMPLES,
        paths::CONNECTOR,
        paths::MANAGER,
        paths::MANAGER_MODULES,
        paths::MANAGER_MODULE,
        paths::MANAGER_FACTORIES,
        paths::MANAGER_COMPONENTS,
        paths::MANAGER_COMPONENT,
        "/v1/nodes/{node}/sessions",
        "/v1/nodes/{node}/sessions/{session}/heartbeat",
        "/livez",
        "/readyz",
        "/metrics",
        "/openapi.json",
    ]);
    assert_eq!(described, known);
}

#[test]
fn problems_are_problem_documents_and_watches_are_event_streams() {
    let document = document();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            for (status, response) in operation["responses"].as_object().unwrap() {
                let is_problem = &response["content"]["application/problem+json"]["schema"]["$ref"];
                let wanted = status.as_str() >= "400";
                assert_eq!(
                    is_problem == "#/components/schemas/Problem",
                    wanted,
                    "{method} {path} {status}"
                );
            }
        }
    }
    for kind in Kind::ALL {
        let list = &document["paths"][paths::objects(kind)]["get"];
        let stream = &list["responses"]["200"]["content"]["text/event-stream"]["schema"]["$ref"];
        assert_eq!(*stream, format!("#/components/schemas/WatchEvent_{kind:?}"));
        let parameters = list["parameters"].to_string();
        assert!(parameters.contains("Last-Event-ID"), "{parameters}");
    }
}
