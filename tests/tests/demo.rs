//! `cargo xtask demo` runs here as a user runs it, with what is built already.

use std::process::{Command, Stdio};

use rts_tests::{program, root};

#[test]
fn the_demo_works_and_leaves_nothing_behind() {
    let output = Command::new(program("xtask"))
        .args(["demo", "--no-build"])
        .current_dir(root())
        .env("NO_COLOR", "1")
        .stdin(Stdio::null())
        .output()
        .expect("xtask starts");
    let (out, err) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    assert!(output.status.success(), "{out}\n{err}");
    assert!(out.contains("no changes"), "{out}");
    assert!(
        out.ends_with("Nothing is left: no process, no socket, no file.\n"),
        "{out}"
    );
}

#[test]
fn the_launch_benchmark_prints_its_rows() {
    let output = Command::new(program("xtask"))
        .args([
            "bench", "launch", "--no-ssh", "--runs", "2", "--json", "--built", "dev",
        ])
        // Whole systems of real users are measured where they are at hand.
        .env_remove("RTSCTL_CORPUS")
        .current_dir(root())
        .stdin(Stdio::null())
        .output()
        .expect("xtask starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON on stdout");
    let names: Vec<_> = json["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .map(|row| row["row"].clone())
        .collect();
    assert_eq!(
        names,
        [
            "agent-1-same",
            "agent-1-separate",
            "agent-10-same",
            "agent-10-separate",
            "floor-dlopen",
            "floor-spawn"
        ]
    );
    for row in json["rows"].as_array().expect("rows") {
        assert!(
            row["median_ms_per_component"]
                .as_f64()
                .is_some_and(|ms| ms > 0.0),
            "{row}"
        );
    }
}
