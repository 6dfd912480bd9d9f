//! `docs/ci.md`: its workflow is run as it stands there.

use std::path::Path;
use std::process::Command;

use quick_junit::Report;
use rts_tests::{Stack, program, programs, root};
use serde_json::Value;

use super::home;

/// The first block of this language.
fn block<'t>(text: &'t str, language: &str) -> &'t str {
    let (_, rest) = text
        .split_once(&format!("```{language}\n"))
        .expect("a block");
    let end = rest.find("\n```\n").expect("its end");
    &rest[..=end]
}

/// Folder with what a checkout has of the workspace.
fn checkout(stack: &Stack) -> std::path::PathBuf {
    let file = stack.write("checkout", "");
    std::fs::remove_file(&file).expect("an empty file");
    std::fs::create_dir(&file).expect("a folder");
    std::os::unix::fs::symlink(root().join("manifests"), file.join("manifests")).expect("a link");
    file
}

/// Runs a step as a runner does: `bash -e`, and with `shell: bash` also `-o pipefail`.
#[track_caller]
fn run(step: &Value, folder: &Path) -> String {
    let script = step["run"].as_str().expect("commands");
    let path = std::env::var("PATH").unwrap_or_default();
    let mut command = Command::new("bash");
    command.arg("-e");
    if step["shell"] == "bash" {
        command.args(["-o", "pipefail"]);
    }
    let output = command
        .args(["-c", script])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", programs().display()))
        .env("GITHUB_STEP_SUMMARY", folder.join("summary.md"))
        .env("RTSCTL_HOME", folder.join("h"))
        .output()
        .expect("bash starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{script}: {said}");
    said
}

#[test]
fn the_workflow_of_the_documentation_runs_and_publishes_what_it_says() {
    program("rtsctl");
    let text = std::fs::read_to_string(root().join("docs/ci.md")).expect("docs/ci.md");
    let workflow: Value = serde_yaml::from_str(block(&text, "yaml")).expect("a workflow");
    let steps = workflow["jobs"]["smoke"]["steps"]
        .as_array()
        .expect("steps");
    let stack = Stack::new();
    let folder = checkout(&stack);
    let runs = steps.iter().filter(|step| step["run"].is_string());
    // The programs are built already.
    let runs: Vec<_> = runs.filter(|step| step["name"] != "Build").collect();
    assert_eq!(runs.len(), 2);
    let said: String = runs.iter().map(|step| run(step, &folder)).collect();
    super::leaves_nothing(&home(&said));
    let publish = steps.iter().find(|step| step["name"] == "Publish");
    let files = publish.expect("a step")["with"]["path"]
        .as_str()
        .expect("files");
    let [junit, svg] = files.split_whitespace().collect::<Vec<_>>()[..] else {
        panic!("{files}");
    };
    let junit = std::fs::read_to_string(folder.join(junit)).expect("the JUnit file");
    let report = Report::deserialize_from_str(&junit).expect("a JUnit file");
    assert_eq!((report.tests > 0, report.failures), (true, 0));
    let svg = std::fs::read_to_string(folder.join(svg)).expect("the picture");
    assert!(svg.starts_with("<svg "));
    let summary = std::fs::read_to_string(folder.join("summary.md")).expect("the summary");
    assert!(summary.contains("checks passed"), "{summary}");
    assert!(!folder.join("h").exists());
}
