//! Every system of the corpus is tried out with stand-ins, on as many agents as it has hosts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use rts_schemas::rts_profile::load;
use rts_schemas::system::{PortKind, SystemSpec};
use rts_tests::Stack;
use serde_json::Value;

use super::{Smoked, ended, leaves_nothing, start};

/// Smoke tests at a time.
const AT_ONCE: usize = 3;

/// How one of them went.
struct Tried {
    name: String,
    /// What the profile says; none of one with errors.
    spec: Option<SystemSpec>,
    smoked: Smoked,
}

impl Tried {
    fn data_connectors(&self) -> usize {
        let spec = self.spec.iter();
        let all = spec.flat_map(|spec| &spec.connectors);
        all.filter(|c| c.kind == PortKind::Data).count()
    }

    fn hosts(&self) -> usize {
        let spec = self.spec.iter();
        let all = spec.flat_map(|spec| &spec.components);
        let hosts: BTreeSet<_> = all.filter_map(|c| c.placement.host.as_deref()).collect();
        hosts.len()
    }

    fn check(&self, name: &str) -> Value {
        let status = &self.smoked.document()["status"];
        let mut checks = status["checks"].as_array().expect("checks").iter();
        checks
            .find(|c| c["name"] == name)
            .expect("the check")
            .clone()
    }

    /// Why it did not pass: what the profile has errors in, or the first check that failed.
    fn reason(&self) -> String {
        if self.spec.is_none() || self.smoked.out.is_empty() {
            let mut lines = self.smoked.err.lines();
            let error = lines.find(|line| line.starts_with("error["));
            return error.unwrap_or(&self.smoked.err).to_owned();
        }
        let status = &self.smoked.document()["status"];
        let mut checks = status["checks"].as_array().expect("checks").iter();
        let failed = checks
            .find(|c| c["result"] == "failed")
            .expect("one failed");
        let detail = failed["details"][0].as_str().unwrap_or_default();
        format!("{}: {}", failed["name"], detail)
    }

    /// Its agents are those of its hosts, every data connector carried samples, and all components are stand-ins but
    /// those whose modules are there.
    fn is_thorough(&self) {
        let agents = self.hosts().max(1);
        let start = self.check("start")["message"].to_string();
        let expected = format!("{agents} agent");
        assert!(start.contains(&expected), "{}: {start}", self.name);
        let samples = self.check("samples")["message"].to_string();
        let expected = match self.data_connectors() {
            0 => "there is no data connector".to_owned(),
            1 => "1 data connector carries samples".to_owned(),
            count => format!("{count} data connectors carry samples"),
        };
        assert_eq!(samples, format!("{expected:?}"), "{}", self.name);
    }
}

/// The profiles of a folder, those of the same content once.
fn profiles(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder of the corpus");
    let files = entries.map(|entry| entry.expect("an entry").path());
    let mut files: Vec<_> = files
        .filter(|f| f.extension().is_none_or(|e| e != "tsv"))
        .collect();
    files.sort();
    let mut seen = BTreeSet::new();
    files.retain(|file| seen.insert(std::fs::read(file).expect("a file of the corpus")));
    files
}

fn attempt(file: &Path, stack: &Stack) -> Tried {
    let name = file
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let path = file.to_str().expect("a path");
    let arguments = [path, "--stand-ins", "--steady", "10ms", "-o", "json"];
    let smoked = ended(start(stack, &arguments));
    let bytes = std::fs::read(file).expect("a file of the corpus");
    let spec = load(&name, &bytes, None, &[]).ok().map(|(spec, _)| spec);
    Tried { name, spec, smoked }
}

/// Some at a time.
fn all(files: Vec<PathBuf>, stack: &Stack) -> Vec<Tried> {
    let (files, done) = (Mutex::new(files.into_iter()), Mutex::new(Vec::new()));
    let next = || files.lock().expect("no panic").next();
    let work = || {
        while let Some(file) = next() {
            let tried = attempt(&file, stack);
            done.lock().expect("no panic").push(tried);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(work);
        }
    });
    let mut done = done.into_inner().expect("no panic");
    done.sort_by(|a, b| a.name.cmp(&b.name));
    done
}

#[test]
fn systems_of_the_corpus_pass_with_stand_ins() {
    let Ok(corpus) = std::env::var("RTSCTL_CORPUS") else {
        println!("skipped: RTSCTL_CORPUS is not set");
        return;
    };
    let stack = Stack::new();
    let mut files = profiles(&Path::new(&corpus).join("rts"));
    files.push(Path::new(&corpus).join("derived/ten_10procs.rtsys.xml"));
    let tried = all(files, &stack);
    assert!(!stack.home().exists());
    let mut reasons = BTreeMap::new();
    let (mut passed, mut with_data, mut on_two) = (0, 0, 0);
    for one in &tried {
        if one.smoked.err.contains("rts-smoke-") {
            leaves_nothing(&one.smoked.home());
        }
        if one.smoked.code != 0 {
            reasons.insert(&one.name, one.reason());
            continue;
        }
        one.is_thorough();
        passed += 1;
        with_data += usize::from(one.data_connectors() > 0);
        on_two += usize::from(one.hosts() > 1);
    }
    let list = reasons
        .iter()
        .map(|(name, reason)| format!("{name}\n    {reason}\n"));
    insta::assert_snapshot!(format!(
        "{passed} of {} pass: {with_data} have a data connector, {on_two} run on two agents\n\n{}",
        tried.len(),
        list.collect::<String>()
    ));
    assert!(with_data >= 45, "{with_data}");
}
