//! The schema, the documentation and the examples say the same as the types.

use std::path::{Path, PathBuf};

use boon::{Compiler, SchemaIndex, Schemas};
use rts_schemas::overlay::{self, Rule};
use rts_schemas::placement::Settings;
use rts_schemas::yaml_type::{YamlType, rows_of};
use serde_json::Value;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[allow(clippy::disallowed_methods)] // Only the tests read files, the crate does not.
fn file(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_default()
}

/// The schema, compiled by a validator that is not ours; it checks it against the schema of schemas.
pub struct Judge {
    schemas: Schemas,
    index: SchemaIndex,
}

impl Judge {
    pub fn new(schema: Value) -> Self {
        let mut schemas = Schemas::new();
        let mut compiler = Compiler::new();
        compiler.add_resource("schema.json", schema).unwrap();
        let index = compiler.compile("schema.json", &mut schemas).unwrap();
        Self { schemas, index }
    }

    pub fn fault(&self, value: &Value) -> Option<String> {
        let result = self.schemas.validate(value, self.index);
        result.err().map(|error| format!("{error:#}"))
    }
}

pub fn yaml(text: &str) -> Value {
    serde_yaml::from_str(text).unwrap()
}

/// Written by `rtsctl schema > docs/schema/deployment.json`.
#[test]
fn the_checked_in_schema_is_current() {
    let stored: Value = serde_json::from_str(&file("docs/schema/deployment.json")).unwrap();
    assert!(
        stored == overlay::schema(),
        "run `cargo run -p rtsctl -- schema > docs/schema/deployment.json`"
    );
}

fn table<T: YamlType>() -> String {
    let rows = rows_of::<T>().into_iter();
    let rows = rows.map(|row| {
        let path = row.path.replace("NAME", "*name*");
        format!("| {path} | {} | {} |\n", row.expected, row.doc)
    });
    format!(
        "| key | takes | says |\n|---|---|---|\n{}",
        rows.collect::<String>()
    )
}

#[test]
fn the_documented_keys_are_those_of_the_types() {
    let page = file("docs/overlay.md");
    for table in [table::<Settings>(), table::<Rule>()] {
        assert!(
            page.contains(&table),
            "docs/overlay.md lacks this table:\n{table}"
        );
    }
}

/// Blocks of YAML in the documentation that are whole overlays, and those of the examples.
fn examples() -> Vec<(String, String)> {
    let mut examples = Vec::new();
    for page in ["docs/overlay.md", "docs/guide.md"] {
        for block in file(page).split("```yaml\n").skip(1) {
            let text = block.split("```").next().unwrap();
            if text.contains("kind: Deployment") {
                examples.push((page.to_owned(), text.to_owned()));
            }
        }
    }
    for name in [
        "hello/lab.yaml",
        "hello/bench.yaml",
        "misbehaving/impatient.yaml",
    ] {
        let name = format!("manifests/{name}");
        examples.push((name.clone(), file(&name)));
    }
    examples
}

#[test]
fn examples_fit_the_schema_and_are_read() {
    let judge = Judge::new(overlay::schema());
    let examples = examples();
    assert!(examples.len() >= 5, "{}", examples.len());
    for (name, text) in examples {
        assert_eq!(judge.fault(&yaml(&text)), None, "{name}:\n{text}");
        assert!(
            overlay::read(&name, text.as_bytes()).is_ok(),
            "{name}:\n{text}"
        );
    }
}

/// What the reader refuses for its shape, keys or values, the schema refuses too, but for bounds of times and lists.
#[test]
fn what_is_wrong_fits_neither() {
    let judge = Judge::new(overlay::schema());
    for wrong in [
        "spec: {components: {A: {isolate: true}}}",
        "spec: {components: {A: {isolated: maybe}}}",
        "spec: {components: {A: {restart: [always]}}}",
        "spec: {components: {A: {resources: {realtimePriority: 100}}}}",
        "spec: {components: {A: {resources: {cpus: 2-x}}}}",
        "spec: {components: {A: {resources: {memoryLimit: 256}}}}",
        "spec: {components: {A: {configuration: {sets: {default: [1]}}}}}",
        "spec: {components: []}",
        "spec: {hosts: {a: 'no node'}}",
        "spec: {order: {activation: [{after: B}]}}",
        "spec: {order: {activate: []}}",
        "spec: {order: {activation: [{component: A, after: B, timing: soon}]}}",
        "metadata: {name: []}\nspec: {}",
        "spec: null",
        "{}",
        "spec: {}\nkind: Pod",
    ] {
        let text = match wrong.contains("kind") {
            true => format!("apiVersion: rtsctl.dev/v1\n{wrong}\n"),
            false if wrong == "{}" => "apiVersion: rtsctl.dev/v1\n".to_owned(),
            false => format!("apiVersion: rtsctl.dev/v1\nkind: Deployment\n{wrong}\n"),
        };
        assert!(judge.fault(&yaml(&text)).is_some(), "{text}");
        assert!(overlay::read("o.yaml", text.as_bytes()).is_err(), "{text}");
    }
}

#[test]
fn the_other_schemas_are_schemas_and_fit_the_examples() {
    use rts_schemas::json_schema::{Document, of};
    let profile = Judge::new(of(Document::RtsProfile));
    assert_eq!(
        profile.fault(&yaml(&file("manifests/hello/system.yaml"))),
        None
    );
    assert!(
        profile
            .fault(&yaml("rtsProfile: {components: 1}"))
            .is_some()
    );
    let component = Judge::new(of(Document::RtcProfile));
    assert_eq!(
        component.fault(&yaml(include_str!("../component.yaml"))),
        None
    );
    assert!(component.fault(&yaml("rtsProfile: {}")).is_some());
    let system = Judge::new(of(Document::System));
    let hello = include_bytes!("../../../manifests/hello/system.xml");
    let (spec, _) = rts_schemas::rts_profile::load("s.xml", hello, None, &[]).unwrap();
    let mut json = serde_json::to_value(&spec).unwrap();
    assert_eq!(system.fault(&json), None);
    json["components"][0]["placement"]["isolated"] = "maybe".into();
    assert!(system.fault(&json).is_some());
}
