//! What we write is accepted by the reference library wherever it accepted the original, with equal content; and by the
//! XML Schemas wherever they accepted the original.
//!
//! And that CDR is what omniORB writes and reads.
//!
//! `RTSCTL_REFERENCE` names a Python with `rtsprofile-aist`, `pyyaml`, `lxml` and `jeteve-omniorb`; without it these tests
//! say that they were skipped.

// A failure here is a failed test; only the tests read files, the environment and start programs.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

mod forms;
mod omniorb;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use forms::{files, systems};
use rts_schemas::form::{Around, Format, format};
use rts_schemas::{rtc_profile, rts_profile};

/// Reads `KIND<TAB>ORIGINAL<TAB>OURS` lines, and says for each whether both are accepted and whether they say the same.
const JUDGE: &str = include_str!("reference/judge.py");

fn python() -> Option<(PathBuf, PathBuf)> {
    let python = std::env::var_os("RTSCTL_REFERENCE").map(PathBuf::from);
    let corpus = std::env::var_os("RTSCTL_CORPUS").map(PathBuf::from);
    match (python, corpus) {
        (Some(python), Some(corpus)) => Some((python, corpus)),
        _ => {
            println!("skipped: RTSCTL_REFERENCE and RTSCTL_CORPUS are not both set");
            None
        }
    }
}

/// A folder that is removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("rts-schemas-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn put(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The judge's answers, one line for each question.
fn judged(python: &Path, corpus: &Path, questions: &str) -> Vec<String> {
    let mut judge = Command::new(python)
        .args(["-c", JUDGE])
        .arg(corpus.join("xsd"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = judge.stdin.take().unwrap();
    let questions = questions.to_owned();
    let writer = std::thread::spawn(move || input.write_all(questions.as_bytes()).unwrap());
    let output = judge.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

#[test]
fn the_reference_library_and_the_schemas_accept_what_we_write() {
    let Some((python, corpus)) = python() else {
        return;
    };
    let folder = Folder::new("reference");
    let mut questions = String::new();
    let mut asked = 0;
    let mut ask = |kind: &str, original: &Path, ours: &Path| {
        asked += 1;
        questions.push_str(&format!(
            "{kind}\t{}\t{}\n",
            original.display(),
            ours.display()
        ));
    };
    for place in ["rts", "derived", "systems"] {
        for (number, (original, bytes)) in systems(&corpus.join(place)).into_iter().enumerate() {
            let file = format!("{number}-{}", original.file_name().unwrap().display());
            let Ok(read) = rts_profile::read(&file, &bytes) else {
                continue;
            };
            let words = &rts_profile::forms::WORDS;
            let form = read.shape.form();
            let xml = format(form, &read.around, words, Format::Xml);
            let xml = folder.put(&format!("{place}-{file}.xml"), &xml);
            let yaml = format(form, &Around::default(), words, Format::Yaml);
            let yaml = folder.put(&format!("{place}-{file}.yaml"), &yaml);
            match read.format {
                Format::Xml => {
                    ask("rts-xml", &original, &xml);
                    ask("rts-yaml-of-xml", &original, &yaml);
                    ask("rts-xsd", &original, &xml);
                }
                Format::Yaml => ask("rts-yaml", &original, &yaml),
            }
        }
    }
    for (file, bytes) in files("rtc").unwrap() {
        let Ok(read) = rtc_profile::read(&file, &bytes) else {
            continue;
        };
        if read.format == Format::Xml {
            let xml = rtc_profile::format(&read.profile, &read.around, Format::Xml);
            let xml = folder.put(&format!("rtc-{file}.xml"), &xml);
            ask("rtc-xsd", &corpus.join("rtc").join(&file), &xml);
        }
    }
    let answers = judged(&python, &corpus, &questions);
    assert_eq!(answers.len(), asked);
    let mut counts = std::collections::BTreeMap::<String, usize>::new();
    let mut wrong = Vec::new();
    for answer in &answers {
        let verdict = answer.split('\t').take(2).collect::<Vec<_>>().join(" ");
        *counts.entry(verdict).or_default() += 1;
        if answer.contains("\tWRONG\t") {
            wrong.push(answer.as_str());
        }
    }
    println!("{counts:#?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let equal = |kind: &str| counts.get(&format!("{kind} equal")).copied().unwrap_or(0);
    assert!(equal("rts-xml") > 50, "{counts:?}");
    assert!(equal("rtc-xsd") > 40, "{counts:?}");
}
