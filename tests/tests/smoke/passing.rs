//! Smoke tests that pass.

use quick_junit::{Report, TestCaseStatus};
use rts_tests::Stack;

use super::{HELLO, ended, leaves_nothing, smoke, start};

const CHECKS: [&str; 9] = [
    "start", "apply", "samples", "again", "export", "steady", "heal", "teardown", "clean",
];

#[test]
fn hello_passes_and_is_told_in_three_ways() {
    let stack = Stack::new();
    let [junit, svg] = ["smoke.xml", "smoke.svg"].map(|name| stack.write(name, "before"));
    let files = [
        junit.to_str().expect("a path"),
        svg.to_str().expect("a path"),
    ];
    let smoked = smoke(
        &stack,
        0,
        &[HELLO, "-o", "json", "--junit", files[0], "--svg", files[1]],
    );

    let status = &smoked.document()["status"];
    assert_eq!(status["passed"], true, "{smoked:#?}");
    assert_eq!(
        (&status["components"], &status["standIns"]),
        (&3.into(), &0.into())
    );
    let checks = status["checks"].as_array().expect("checks");
    let names: Vec<_> = checks.iter().map(|check| check["name"].as_str()).collect();
    assert_eq!(names, CHECKS.map(Some));
    assert!(checks.iter().all(|check| check["result"] == "passed"));
    let heal = checks[6]["message"].as_str().expect("a message");
    assert!(
        heal.ends_with("1 component came back, 2 untouched"),
        "{heal}"
    );

    let text = std::fs::read_to_string(&junit).expect("the JUnit file");
    let report = Report::deserialize_from_str(&text).expect("a JUnit file");
    assert_eq!((report.tests, report.failures, report.errors), (9, 0, 0));
    let suite = &report.test_suites[0];
    assert_eq!(suite.name.as_str(), "hello");
    assert_eq!(suite.properties[0].value.as_str(), "0 of 3 are stand-ins");
    let cases = suite.test_cases.iter();
    let names: Vec<_> = cases.map(|case| case.name.as_str()).collect();
    assert_eq!(names, CHECKS);
    let passed = |status: &TestCaseStatus| matches!(status, TestCaseStatus::Success { .. });
    assert!(suite.test_cases.iter().all(|case| passed(&case.status)));

    let picture = std::fs::read_to_string(&svg).expect("the picture");
    assert!(picture.starts_with("<svg ") && picture.ends_with("</svg>\n"));
    for title in [
        "Sine0: SineSource, Active",
        "Sine0.out-Filter0.in: Connected",
        "node local",
    ] {
        assert!(picture.contains(title), "{title}: {picture}");
    }
}

/// One of three modules is not to be had.
#[test]
fn stand_ins_are_counted_and_there_may_be_too_many() {
    let stack = Stack::new();
    let profile = std::fs::read_to_string(rts_tests::root().join(HELLO)).expect("the manifest");
    let profile = stack.write("system.xml", profile.replace(":Printer:", ":Plotter:"));
    let junit = stack.write("smoke.xml", "before");
    let [profile, junit] = [&profile, &junit].map(|path| path.to_str().expect("a path"));
    let quick = [profile, "--stand-ins", "--no-faults", "--steady", "10ms"];
    let smoked = smoke(&stack, 0, &[&quick[..], &["--junit", junit]].concat());
    let said = "1 of 3 components is a stand-in";
    assert!(smoked.out.trim_end().ends_with(said), "{smoked:#?}");
    let text = std::fs::read_to_string(junit).expect("the JUnit file");
    assert!(
        text.contains(r#"name="stand-ins" value="1 of 3 are stand-ins""#),
        "{text}"
    );
    let smoked = smoke(&stack, 3, &[&quick[..], &["--max-stand-ins", "0"]].concat());
    assert!(smoked.out.contains("Printer0"), "{smoked:#?}");
}

#[test]
fn two_at_once_do_not_meet() {
    let stack = Stack::new();
    let both = [(); 2].map(|()| start(&stack, &[HELLO]));
    let [one, two] = both.map(ended);
    for smoked in [&one, &two] {
        assert_eq!(smoked.code, 0, "{smoked:#?}");
        leaves_nothing(&smoked.home());
    }
    assert_ne!(one.home(), two.home());
    assert!(!stack.home().exists());
}

#[test]
fn without_faults_nothing_is_killed_and_that_is_said() {
    let stack = Stack::new();
    let smoked = smoke(
        &stack,
        0,
        &[HELLO, "--no-faults", "--steady", "10ms", "-o", "json"],
    );
    let checks = &smoked.document()["status"]["checks"];
    assert_eq!(
        (&checks[6]["name"], &checks[6]["result"]),
        (&"heal".into(), &"skipped".into())
    );
    assert_eq!(checks[6]["message"], "no faults are wanted");
}

#[test]
fn a_stack_of_ones_own_is_not_tried_on() {
    let stack = Stack::new();
    let home = stack.home();
    let said = stack.expect(
        2,
        &["--home", home.to_str().expect("a path"), "smoke", HELLO],
    );
    assert!(
        said.err.contains("a smoke test has a stack of its own"),
        "{said:#?}"
    );
    assert!(!home.exists());
}
