//! omniORB reads what we write, and writes the same: of drawn types, whose IDL it is given, and of those of OpenRTM.

mod idl_text;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::rc::Rc;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use rts_schemas::cdr::{Endian, Value, decode, encode, from_json, to_json, zero};
use rts_schemas::idl::{self, Standard, model::*};
use rts_schemas::span::Span;

use super::Folder;

#[path = "../../src/cdr/tests/any.rs"]
mod any;

/// Answers of omniORB to lines of a type and a value.
const JUDGE: &str = include_str!("../reference/omniorb.py");

/// Drawn types.
const TYPES: usize = 1000;

/// A Python with omniORB. In CI there has to be one.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("RTSCTL_REFERENCE").map(PathBuf::from);
    let python = python.filter(|python| {
        let probe = Command::new(python).args(["-c", "import omniORB"]).output();
        probe.is_ok_and(|probe| probe.status.success())
    });
    if python.is_none() {
        let ci = std::env::var_os("CI").is_some();
        assert!(!ci, "RTSCTL_REFERENCE names no Python that has omniORB");
        println!("skipped: RTSCTL_REFERENCE names no Python that has omniORB");
    }
    python
}

/// A value, and the type's name in the IDL file.
struct Case {
    name: String,
    unit: Rc<Unit>,
    r#type: Type,
    value: Value,
}

impl Case {
    fn encoded(&self, endian: Endian) -> Vec<u8> {
        encode(&self.unit, &self.r#type, &self.value, endian).unwrap()
    }

    fn question(&self) -> String {
        let json = to_json(&self.unit, &self.r#type, &self.value).unwrap();
        let [little, big] = [Endian::Little, Endian::Big].map(|it| hex(&self.encoded(it)));
        format!("{}\t{json}\t{little}\t{big}\n", self.name)
    }

    /// What is wrong with the bytes and the JSON of omniORB.
    fn wrong(&self, answer: &str) -> Option<String> {
        let parts: Vec<&str> = answer.split('\t').collect();
        let [_, little, big, json] = parts[..] else {
            return Some(answer.to_owned());
        };
        for (endian, theirs) in [(Endian::Little, little), (Endian::Big, big)] {
            let (ours, theirs) = (self.encoded(endian), bytes(theirs));
            if !self.same(&ours, &theirs, endian) {
                let (ours, theirs) = (hex(&ours), hex(&theirs));
                return Some(format!("{endian:?}: ours {ours}, theirs {theirs}"));
            }
        }
        let json = serde_json::from_str(json).unwrap();
        let read = from_json(&self.unit, &self.r#type, &json);
        (read.as_ref() != Ok(&self.value)).then(|| format!("{json}: {read:?}"))
    }

    /// The same but for padding: bytes that are zero in ours and can be anything. omniORB leaves there what the memory had.
    fn same(&self, ours: &[u8], theirs: &[u8], endian: Endian) -> bool {
        let padding = |at: usize| {
            let mut other = ours.to_vec();
            other[at] = theirs[at];
            let read = decode(&self.unit, &self.r#type, &other, endian);
            ours[at] == 0 && read.as_ref() == Ok(&self.value)
        };
        ours.len() == theirs.len()
            && (0..ours.len()).all(|at| ours[at] == theirs[at] || padding(at))
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(hex: &str) -> Vec<u8> {
    let digits = |at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
    (0..hex.len()).step_by(2).map(digits).collect()
}

/// The answers, one line for each question.
fn judged(python: &Path, idl: &Path, questions: String) -> Vec<String> {
    let mut judge = Command::new(python)
        .args(["-c", JUDGE])
        .arg(idl)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = judge.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(questions.as_bytes()));
    let output = judge.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    writer.join().unwrap().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

fn agree(python: &Path, idl: &Path, cases: &[Case]) {
    let questions = cases.iter().map(Case::question).collect();
    let answers = judged(python, idl, questions);
    assert_eq!(answers.len(), cases.len());
    let wrong = cases.iter().zip(&answers).filter_map(|(case, answer)| {
        let why = case.wrong(answer)?;
        Some(format!("{:?} of {:?}: {why}", case.value, case.r#type))
    });
    let wrong: Vec<String> = wrong.collect();
    assert!(
        wrong.is_empty(),
        "{} differ:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

/// Bytes to draw by.
fn choices() -> impl Iterator<Item = Vec<u8>> {
    let mut runner = TestRunner::deterministic();
    let choices = prop::collection::vec(0..=u8::MAX, 1..200);
    std::iter::repeat_with(move || choices.new_tree(&mut runner).unwrap().current())
}

/// What omniORB for Python carries too.
fn plain(bytes: &[u8]) -> any::Choices<'_> {
    any::Choices { bytes, plain: true }
}

#[test]
fn omniorb_writes_the_same_bytes_of_any_type() {
    let Some(python) = python() else {
        return;
    };
    let mut text = String::new();
    let mut cases = Vec::new();
    for (number, bytes) in choices().take(TYPES).enumerate() {
        let mut choices = plain(&bytes);
        let mut unit = Unit::default();
        let r#type = choices.r#type(&mut unit, 3);
        let value = choices.value(&unit, &r#type);
        let module = format!("C{number}");
        text += &idl_text::module(&module, &unit, &r#type);
        cases.push(Case {
            name: format!("::{module}::Root"),
            unit: unit.into(),
            r#type,
            value,
        });
    }
    let folder = Folder::new("omniorb-any");
    agree(&python, &folder.put("drawn.idl", &text), &cases);
}

#[test]
fn omniorb_writes_the_same_bytes_of_the_types_of_openrtm() {
    let Some(python) = python() else {
        return;
    };
    let folder = Folder::new("omniorb-openrtm");
    let mut text = String::new();
    for (name, content) in Standard::files() {
        folder.put(name, content);
        text += &format!("#include \"{name}\"\n");
    }
    let read = idl::read("all.idl", text.as_bytes(), &idl::standard()).unwrap();
    let unit = Rc::new(read.unit);
    let types = unit.definitions.iter().enumerate();
    // Interfaces, constants and exceptions have no values.
    let types = types.filter(|(index, _)| zero(&unit, &Type::Named(*index)).is_ok());
    let types: Vec<_> = types.collect();
    let mut cases = Vec::new();
    for (bytes, (index, definition)) in choices().zip(types.iter().cycle()).take(5 * types.len()) {
        let r#type = Type::Named(*index);
        cases.push(Case {
            name: format!("::{}", definition.path.join("::")),
            unit: unit.clone(),
            value: plain(&bytes).value(&unit, &r#type),
            r#type,
        });
    }
    assert!(types.len() > 80, "{}", types.len());
    agree(&python, &folder.put("all.idl", &text), &cases);
}
