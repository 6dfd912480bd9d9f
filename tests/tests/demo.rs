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
    let names: Vec<&str> = json["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .filter_map(|row| row["row"].as_str())
        .collect();
    let (pools, others): (Vec<&str>, Vec<&str>) =
        names.into_iter().partition(|row| row.contains("-pool-"));
    // One and ten processes, with none and two that wait.
    assert!(pools.is_empty() || pools.len() == 4, "{pools:?}");
    assert_eq!(
        others,
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

#[test]
fn a_small_fleet_is_applied_changed_and_taken_down_at_one_controller() {
    let output = Command::new(program("xtask"))
        .args(["bench", "fleet", "--short", "--runs", "1"])
        .args(["--seconds", "1", "--json", "--built", "dev"])
        .current_dir(root())
        .stdin(Stdio::null())
        .output()
        .expect("xtask starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let rows: Vec<_> = found["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .filter_map(|row| row["row"].as_str())
        .collect();
    let actions = ["apply", "no-op", "one-change", "teardown", "rest"];
    assert_eq!(rows, actions.map(|action| format!("fleet-20-200-{action}")));
    let real = found["real"].as_array().expect("real processes");
    for (row, shared) in real.iter().zip([false, true]) {
        // In one of its threads each, or those of a half of a process together.
        assert_eq!(
            (row["managers"].as_u64(), row["components"].as_u64()),
            (Some(2), Some(20))
        );
        assert!(
            row["cycles"].as_u64().is_some_and(|cycles| cycles > 0),
            "{row}"
        );
        assert_eq!(
            row["row"].as_str().is_some_and(|r| r.ends_with("shared")),
            shared
        );
    }
    let threads = |place: usize| real[place]["threads"].as_u64().expect("threads");
    assert!(threads(0) > threads(1), "{real:?}");
}

#[test]
fn the_benchmark_of_an_idle_stack_prints_its_tables() {
    let output = Command::new(program("xtask"))
        .args(["bench", "idle", "--runs", "1", "--seconds", "1"])
        .args(["--components", "10", "--json", "--built", "dev"])
        .current_dir(root())
        .stdin(Stdio::null())
        .output()
        .expect("xtask starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let costs = found["costs"].as_array().expect("costs");
    let both = costs
        .iter()
        .find(|cost| cost["components"] == 0 && cost["process"] == "controller + agent")
        .expect("both");
    assert_eq!(both["processes"], 2);
    assert!(
        both["pss_bytes"]
            .as_u64()
            .is_some_and(|bytes| bytes > 1_000_000)
    );
    assert!(
        costs
            .iter()
            .any(|cost| cost["process"] == "managers" && cost["components"] == 10)
    );
    assert_eq!(found["rows"].as_array().map(Vec::len), Some(4));
}
