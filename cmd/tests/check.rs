//! `rtsctl check`: what the program says of every wrong file of the examples, and of the files of real users.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use rts_schemas::codes;

/// Codes that no example gives, and why.
const WITHOUT: [(&str, &str); 6] = [
    (
        "no-transport",
        "it takes a home with a node that is reached by SSH; a unit test and one at a real server have it",
    ),
    (
        "unreadable-file",
        "a file that is not there is no example; a test of its own has it",
    ),
    (
        "too-dense",
        "its example would be nothing but thousands of empty values",
    ),
    ("too-large", "its example would have megabytes"),
    (
        "too-many-entries",
        "its example would have thousands of lines",
    ),
    (
        "duplicate-connector",
        "only a system that comes over the API can have it: names of connectors in files are numbered",
    ),
];

/// Codes of other verbs (`fmt`, `convert`), which have tests of their own.
const ELSEWHERE: [&str; 4] = [
    "comments-in-yaml",
    "comments-left-out",
    "not-canonical",
    "version-cannot-say",
];

fn is_elsewhere(code: &str) -> bool {
    ELSEWHERE.contains(&code) || code.starts_with("conf-")
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../manifests/invalid")
}

/// Runs in a folder, without a home; gives exit code, stdout and stderr.
fn run_in(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_rtsctl"))
        .args(args)
        .env_clear()
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code().unwrap(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

/// IDL files have a verb of their own.
fn verb(args: &[&str]) -> &'static [&'static str] {
    match args.first().is_some_and(|file| file.ends_with(".idl")) {
        true => &["idl", "check"],
        false => &["check"],
    }
}

fn check(args: &[&str]) -> (i32, String, String) {
    let args: Vec<&str> = verb(args).iter().chain(args).copied().collect();
    run_in(&folder(), &args)
}

/// The examples: name → arguments. A file is one; an overlay goes over `hello`; a folder has `system.…` or
/// `component.xml`, overlays, RTC Profiles in `rtc`, and more arguments in `args`.
fn examples() -> BTreeMap<String, Vec<String>> {
    let entries = std::fs::read_dir(folder())
        .unwrap()
        .map(|e| e.unwrap().path());
    entries
        .filter(|path| !is_elsewhere(&name(path)))
        .map(|path| (name(&path), arguments(&path)))
        .collect()
}

fn name(path: &Path) -> String {
    path.file_name().unwrap().to_str().unwrap().to_owned()
}

fn arguments(path: &Path) -> Vec<String> {
    let own = name(path);
    if path.is_file() {
        return match own.starts_with("overlay-") {
            true => vec!["../hello/system.xml".to_owned(), "-f".to_owned(), own],
            false => vec![own],
        };
    }
    let mut inside: Vec<PathBuf> = std::fs::read_dir(path)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    inside.sort();
    let (mut first, mut args) = (Vec::new(), Vec::new());
    for path in inside {
        let file = format!("{own}/{}", name(&path));
        match name(&path).as_str() {
            "rtc" => args.extend(["--rtc".to_owned(), file]),
            "args" => {
                let text = std::fs::read_to_string(&path).unwrap();
                args.extend(text.split_whitespace().map(str::to_owned));
            }
            "component.xml" | "system.xml" | "system.yaml" => first.push(file),
            _ => args.extend(["-f".to_owned(), file]),
        }
    }
    if first.is_empty() {
        first.push("../hello/system.xml".to_owned());
    }
    first.extend(args);
    first
}

/// The codes in a text, as `error[code]` and the like.
fn codes_in(text: &str) -> BTreeSet<&str> {
    let heads = ["error[", "warning[", "note["];
    let found = text.lines().filter_map(|line| {
        let rest = heads.iter().find_map(|head| line.strip_prefix(head))?;
        rest.split_once("]: ").map(|(code, _)| code)
    });
    found.collect()
}

#[test]
fn every_example_says_what_a_user_shall_read() {
    for (name, args) in examples() {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let (code, stdout, stderr) = check(&args);
        let errors = stdout.lines().any(|line| line.starts_with("error["));
        assert_eq!(code, i32::from(errors), "{name}: {stderr}");
        // The name of an example is its code, if it has one.
        let stem = name.split('.').next().unwrap();
        if codes::find(stem).is_some() {
            assert!(codes_in(&stdout).contains(stem), "{name}: {stdout}");
        }
        let shown: Vec<&str> = stdout.lines().take(60).collect();
        insta::assert_snapshot!(
            format!("example__{name}"),
            format!(
                "$ rtsctl {} {}\n{}\n\n{stderr}",
                verb(&args).join(" "),
                args.join(" "),
                shown.join("\n")
            )
        );
    }
}

#[test]
fn every_code_has_an_example_and_every_finding_a_code() {
    let mut seen = BTreeSet::new();
    for args in examples().values() {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let (_, stdout, _) = check(&args);
        seen.extend(codes_in(&stdout).into_iter().map(str::to_owned));
    }
    let known: BTreeSet<String> = codes::all().map(|code| code.code.to_owned()).collect();
    let unexplained: Vec<_> = seen.difference(&known).collect();
    assert_eq!(unexplained, [] as [&String; 0], "add them to codes/");
    let missing: Vec<_> = known.difference(&seen).collect();
    let excused = WITHOUT.map(|(code, _)| code.to_owned());
    let missing: Vec<_> = missing
        .into_iter()
        .filter(|c| !excused.contains(c) && !is_elsewhere(c))
        .collect();
    assert_eq!(
        missing,
        [] as [&String; 0],
        "add examples to manifests/invalid"
    );
    for code in excused {
        assert!(known.contains(&code) && !seen.contains(&code), "{code}");
    }
}

#[test]
fn json_has_everything_that_the_text_has() {
    let (code, stdout, stderr) = check(&["unknown-port.xml", "-o", "json"]);
    assert_eq!((code, stderr.as_str()), (1, "2 errors\n"));
    insta::assert_snapshot!("json", stdout);
    for (name, args) in examples() {
        let args: Vec<&str> = args
            .iter()
            .map(String::as_str)
            .chain(["-o", "json"])
            .collect();
        let report: serde_json::Value = serde_json::from_str(&check(&args).1).unwrap();
        for finding in report["findings"].as_array().unwrap() {
            let code = finding["code"].as_str().unwrap();
            assert!(finding["help"].is_string(), "{name}: {finding}");
            // Of too many there is no one place.
            let placed = finding["place"].is_object() || code == "too-many-problems";
            assert!(placed, "{name}: {finding}");
        }
    }
}

#[test]
fn sarif_is_as_its_standard_has_it() {
    let (code, stdout, _) = check(&["many.xml", "-o", "sarif"]);
    assert_eq!(code, 1);
    let log: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(log["version"], "2.1.0");
    assert!(
        log["$schema"]
            .as_str()
            .unwrap()
            .ends_with("sarif-2.1.0.json")
    );
    let run = &log["runs"][0];
    assert_eq!(run["columnKind"], "unicodeCodePoints");
    let rules = run["tool"]["driver"]["rules"].as_array().unwrap();
    let lines: Vec<String> = std::fs::read_to_string(folder().join("many.xml"))
        .unwrap()
        .lines()
        .map(str::to_owned)
        .collect();
    let results = run["results"].as_array().unwrap();
    assert!(results.len() >= 7);
    for result in results {
        let index = usize::try_from(result["ruleIndex"].as_u64().unwrap()).unwrap();
        assert_eq!(rules[index]["id"], result["ruleId"]);
        assert!(rules[index]["help"]["text"].as_str().unwrap().len() > 100);
        assert!(matches!(
            result["level"].as_str().unwrap(),
            "error" | "warning" | "note"
        ));
        assert!(!result["message"]["text"].as_str().unwrap().is_empty());
        let location = &result["locations"][0]["physicalLocation"];
        assert_eq!(location["artifactLocation"]["uri"], "many.xml");
        let number = |key: &str| {
            let number = location["region"][key].as_u64().unwrap();
            usize::try_from(number).unwrap()
        };
        let line = lines[number("startLine") - 1].chars().count();
        assert!(number("startColumn") < number("endColumn"));
        assert!(number("endColumn") <= line + 1, "{result}");
    }
    let (_, stdout, _) = check(&["unknown-port.xml", "-o", "sarif"]);
    let version = format!("\"semanticVersion\": \"{}\"", env!("CARGO_PKG_VERSION"));
    assert!(stdout.contains(&version), "{stdout}");
    let stdout = stdout.replace(&version, "\"semanticVersion\": \"VERSION\"");
    insta::assert_snapshot!("sarif", stdout);
}

#[test]
fn a_code_is_explained_or_the_nearest_named() {
    let (code, stdout, stderr) = check(&["--explain", "unknown-port"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    insta::assert_snapshot!("explained", stdout);
    assert_eq!(check(&["--explain", "error[unknown-port]"]).1, stdout);
    let (code, stdout, stderr) = check(&["--explain", "unknown-prot"]);
    assert_eq!((code, stdout.as_str()), (2, ""));
    insta::assert_snapshot!(stderr, @r"
    error: `unknown-prot` is no code of a finding
    help: did you mean `unknown-port`? `rtsctl check --explain` lists all codes
    ");
    let (code, list, _) = check(&["--explain"]);
    assert_eq!(code, 0);
    assert_eq!(list.lines().count(), codes::all().count());
}

/// What the documentation shows whole is accepted for the example, but for what the example has not.
#[test]
fn documented_overlays_are_accepted() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/overlay.md");
    let page = std::fs::read_to_string(page).unwrap();
    let blocks = page.split("```yaml\n").skip(1);
    let blocks = blocks.map(|block| block.split("```").next().unwrap());
    let overlays: Vec<&str> = blocks.filter(|b| b.contains("kind: Deployment")).collect();
    assert!(!overlays.is_empty());
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("documented.yaml");
    for overlay in overlays {
        std::fs::write(&file, overlay).unwrap();
        let args = ["../hello/system.xml", "-f", file.to_str().unwrap()];
        let (code, stdout, _) = check(&args);
        assert_eq!(code, 0, "{overlay}\n{stdout}");
        let expected = BTreeSet::from(["not-carried-out", "unmatched-selector"]);
        assert_eq!(codes_in(&stdout), expected, "{stdout}");
    }
}

#[test]
fn warnings_fail_only_where_they_are_denied() {
    let (code, _, stderr) = check(&["bad-widget.xml"]);
    assert_eq!((code, stderr.as_str()), (0, "1 warning\n"));
    let (code, _, _) = check(&["bad-widget.xml", "--deny", "warnings"]);
    assert_eq!(code, 1);
    let (code, stdout, stderr) = check(&[
        "../hello/system.xml",
        "-f",
        "../hello/lab.yaml",
        "--deny",
        "warnings",
    ]);
    assert_eq!((code, stdout.as_str()), (0, ""));
    assert_eq!(stderr, "no problem was found\n");
    let (_, _, stderr) = check(&["bad-widget.xml", "-q"]);
    assert_eq!(stderr, "");
}

#[test]
fn everything_is_told_though_a_file_cannot_be_read() {
    let (code, stdout, stderr) = check(&[
        "unknown-port.xml",
        "-f",
        "nothing.yaml",
        "-f",
        "overlay-bad-value.yaml",
    ]);
    assert_eq!(code, 3);
    assert!(stdout.contains("error[unknown-port]"), "{stdout}");
    assert!(stdout.contains("error[bad-placement-value]"), "{stdout}");
    assert!(
        stderr.ends_with("cannot read nothing.yaml: No such file or directory (os error 2)\n"),
        "{stderr}"
    );
    let (code, stdout, stderr) = check(&["nothing.xml", "-o", "json"]);
    assert_eq!(code, 3);
    let report: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(report["findings"][0]["code"], "unreadable-file");
    assert!(!stderr.contains("no problem"), "{stderr}");
    let (_, stdout, stderr) = check(&["nothing.xml"]);
    assert!(
        stdout.is_empty() && !stderr.contains("no problem"),
        "{stderr}"
    );
    // No XML or YAML, another document, nothing: something is wrong in a file that was read.
    for wrong in ["malformed.xml", "wrong-root.xml", "empty-file.xml"] {
        assert_eq!(check(&[wrong]).0, 1, "{wrong}");
        let (code, stdout, _) = check(&["../hello/system.xml", "-f", wrong]);
        assert_eq!(code, 1, "{wrong}");
        assert!(!stdout.contains("malformed-yaml"), "{stdout}");
    }
    assert_eq!(check(&["."]).0, 3);
    let (code, _, _) = check(&["-", "-f", "-"]);
    assert_eq!(code, 2);
    let (code, stdout, _) = check(&["-"]);
    assert_eq!(code, 1, "{stdout}");
    assert!(stdout.contains("<stdin>"), "{stdout}");
}

/// 500 are told; the line that stands for the others is none of them, and fails the check whatever they are.
#[test]
fn what_is_not_shown_is_not_counted() {
    let (code, _, stderr) = check(&["too-many-problems.xml"]);
    let expected = "500 errors, and more that are not shown\n";
    assert_eq!((code, stderr.as_str()), (1, expected));
    let (_, stdout, _) = check(&["too-many-problems.xml", "-o", "json"]);
    let report: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(report["errors"], 500);
}

/// What an overlay says is checked though another of its lines cannot be read, and with a profile that nobody named.
#[test]
fn no_fault_hides_another() {
    let (_, stdout, _) = check(&["../hello/system.xml", "-f", "hidden-rule/overlay.yaml"]);
    for code in ["bad-placement-value", "unknown-instance", "order-cycle"] {
        assert!(codes_in(&stdout).contains(code), "{code}: {stdout}");
    }
    let (_, stdout, _) = check(&["no-system-name.xml", "-f", "hidden-rule/overlay.yaml"]);
    for code in ["no-system-name", "bad-placement-value", "unknown-instance"] {
        assert!(codes_in(&stdout).contains(code), "{code}: {stdout}");
    }
}

#[test]
fn every_code_is_in_the_documentation() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/checking.md");
    let page = std::fs::read_to_string(path).unwrap();
    let rows = codes::all().map(|code| format!("| `{}` | {} |", code.code, code.title));
    let missing: Vec<String> = rows.filter(|row| !page.contains(row)).collect();
    assert!(
        missing.is_empty(),
        "docs/checking.md lacks these lines:\n{}",
        missing.join("\n")
    );
}

/// The files of real users: nothing panics, and nobody is told of errors that are none.
#[test]
fn files_of_real_users() {
    let Some(corpus) = std::env::var_os("RTSCTL_CORPUS").map(PathBuf::from) else {
        println!("skipped: RTSCTL_CORPUS is not set");
        return;
    };
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut errors = Vec::new();
    let mut total = 0;
    for folder in ["rts", "derived", "rtc"] {
        let mut files: Vec<PathBuf> = std::fs::read_dir(corpus.join(folder))
            .unwrap()
            .map(|e| e.unwrap().path())
            .filter(|path| name(path) != "DERIVED.tsv")
            .collect();
        files.sort();
        for file in files {
            total += 1;
            let file = name(&file);
            let args = ["check", file.as_str(), "-o", "json"];
            let (code, stdout, stderr) = run_in(&corpus.join(folder), &args);
            assert!(matches!(code, 0 | 1), "{file}: {stderr}");
            let report: serde_json::Value = serde_json::from_str(&stdout).unwrap();
            let mut own = BTreeSet::new();
            for finding in report["findings"].as_array().unwrap() {
                let code = finding["code"].as_str().unwrap();
                assert!(codes::find(code).is_some(), "{file}: {code}");
                let severity = finding["severity"].as_str().unwrap();
                *counts.entry(format!("{severity} {code}")).or_default() += 1;
                if severity == "error" {
                    own.insert(code.to_owned());
                }
            }
            errors.extend(own.into_iter().map(|code| format!("{file}: {code}")));
        }
    }
    println!("{total} files: {counts:#?}");
    assert!(total > 150, "the corpus is incomplete: {total}");
    insta::assert_json_snapshot!("real_counts", counts);
    insta::assert_snapshot!("real_errors", errors.join("\n"));
}
