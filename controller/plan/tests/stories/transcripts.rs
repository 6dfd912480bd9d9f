//! Transcripts: commands in, plans out. Each file in `transcripts/` is a script of commands about a small simulated
//! world; the snapshot beside it is the script with what every command answers, to be read like prose.

use std::fmt::Write as _;
use std::path::Path;

use crate::script::Stage;

#[test]
fn every_script_plays_as_written() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/stories/transcripts");
    let mut scripts: Vec<_> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "txt"))
        .collect();
    scripts.sort();
    assert!(!scripts.is_empty());
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(&folder);
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    for path in scripts {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let script = std::fs::read_to_string(&path).unwrap();
        let transcript = play(&name, &script);
        settings.bind(|| insta::assert_snapshot!(name, transcript));
    }
}

/// Lines that start with a blank belong to the command above them; `#` begins a remark.
fn play(name: &str, script: &str) -> String {
    let mut stage = Stage::new();
    let mut transcript = String::new();
    let mut lines = script.lines().enumerate().peekable();
    while let Some((number, line)) = lines.next() {
        if line.trim().is_empty() || line.starts_with('#') {
            writeln!(transcript, "{line}").unwrap();
            continue;
        }
        writeln!(transcript, "> {line}").unwrap();
        let mut more = Vec::new();
        while let Some((_, part)) = lines.next_if(|(_, next)| next.starts_with(' ')) {
            writeln!(transcript, "> {part}").unwrap();
            more.push(part.trim());
        }
        let answer = stage.carry_out(line, &more);
        let answer = answer.unwrap_or_else(|e| panic!("{name}.txt:{}: {e}", number + 1));
        transcript.push_str(&answer);
    }
    transcript
}
