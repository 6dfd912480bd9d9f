//! `rtsctl convert`, which needs no controller.

use std::path::PathBuf;

use super::Edge;

fn manifests() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../manifests")
}

/// A folder with these files of the examples.
fn with(files: &[&str]) -> Edge {
    let edge = Edge::new();
    for file in files {
        let to = edge.folder.path().join(file);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(manifests().join(file), to).unwrap();
    }
    edge
}

#[test]
fn xml_becomes_yaml_and_xml_again() {
    let edge = with(&["hello/system.xml"]);
    let (code, yaml, stderr) = edge.run(&["convert", "hello/system.xml", "--to", "yaml"]);
    assert_eq!(code, 0, "{stderr}");
    insta::assert_snapshot!(stderr, @r"
    warning[comments-left-out]: 3 comments of the XML have no place in the YAML
      = help: keep the XML too
    ");
    assert!(yaml.starts_with("rtsProfile:\n"), "{yaml}");
    // The format is that of the name.
    let (code, stdout, _) = edge.run(&["convert", "hello/system.xml", "--out", "a.yaml", "-q"]);
    assert_eq!((code, stdout.as_str()), (0, "written to a.yaml\n"));
    let written = std::fs::read_to_string(edge.folder.path().join("a.yaml")).unwrap();
    assert_eq!(written, yaml);
    let (code, xml, stderr) = edge.run(&["convert", "a.yaml", "--to", "xml"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert!(xml.contains(r#"rts:instanceName="Filter0""#), "{xml}");
    assert!(!edge.home().exists(), "no stack is touched");
}

#[test]
fn comments_of_yaml_are_kept_in_xml_and_missed_in_yaml() {
    let edge = Edge::new();
    let path = edge.folder.path().join("a.yaml");
    let text = "rtsProfile:\n  id: \"RTSystem:a:b:1\"\n  version: \"0.2\"\n  # the motors\n  components:\n    - instanceName: M0 # left\n";
    std::fs::write(path, text).unwrap();
    let (code, xml, stderr) = edge.run(&["convert", "a.yaml", "--to", "xml"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert!(
        xml.contains("<!-- the motors -->") && xml.contains("<!-- left -->"),
        "{xml}"
    );
    let (code, yaml, stderr) = edge.run(&["convert", "a.yaml", "--profile-version", "0.2"]);
    assert_eq!((code, yaml.contains('#')), (0, false));
    insta::assert_snapshot!(stderr, @r#"
    warning[comments-left-out]: 2 comments of the old YAML have no place in the YAML
     --> a.yaml:4:3
      |
    4 |   # the motors
      |   ^^^^^^^^^^^^
      = help: keep the old file too, or write XML (`--to xml`), which has them
    "#);
}

#[test]
fn a_name_that_says_another_format_is_refused() {
    let edge = with(&["hello/system.xml"]);
    let args = [
        "convert",
        "hello/system.xml",
        "--to",
        "xml",
        "--out",
        "x.yaml",
    ];
    let (code, stdout, stderr) = edge.run(&args);
    assert_eq!((code, stdout.as_str()), (2, ""));
    insta::assert_snapshot!(stderr, @r#"
    error: --to says xml, but --out x.yaml ends as yaml
    help: leave out --to, or name the file after its format
    "#);
    assert!(!edge.folder.path().join("x.yaml").exists());
}

#[test]
fn the_configuration_of_one_component_is_told_as_what_it_is() {
    let edge = Edge::new();
    let text = "# Motor0\nexec_cxt.periodic.rate: 500\nconf.default.gain: 1.0\nconf.__widget__.gain: text\n";
    std::fs::write(edge.folder.path().join("Motor0.conf"), text).unwrap();
    let (code, stdout, stderr) = edge.run(&["convert", "Motor0.conf"]);
    assert_eq!((code, stdout.as_str()), (3, ""));
    insta::assert_snapshot!(stderr, @r#"
    error[conf-no-component]: this file configures one component and makes none, so there is no system
     --> Motor0.conf:2:1
      |
    2 | exec_cxt.periodic.rate: 500
      | ^^^^^^^^^^^^^^^^^^^^^^
      = help: convert the `rtc.conf` that makes the component, and names this file: `CATEGORY.INSTANCE.config_file: FILE`
    error: cannot convert Motor0.conf: 1 error
    "#);
}

#[test]
fn what_a_version_cannot_say_is_refused_or_left_out() {
    let edge = with(&["invalid/version-cannot-say/system.xml"]);
    let file = "invalid/version-cannot-say/system.xml";
    let (code, stdout, stderr) = edge.run(&[
        "convert",
        file,
        "--profile-version",
        "0.1",
        "--out",
        "old.xml",
    ]);
    assert_eq!((code, stdout.as_str()), (3, ""));
    insta::assert_snapshot!(stderr, @r#"
    error[version-cannot-say]: version 0.1 cannot say the kind `FsmECShared` of a composite component
     --> invalid/version-cannot-say/system.xml:3:141
      |
    3 | …otor0.rtc" rts:compositeType="FsmECShared" rts:isRequired="true"/>
      |                                ^^^^^^^^^^^
      = help: take it out of the profile, or leave it out with `--force`
    error[version-cannot-say]: version 0.1 cannot say `rts:Activation`
     --> invalid/version-cannot-say/system.xml:4:5
      |
    4 |     <rts:Activation>
      |     ^^^^^^^^^^^^^^^^
      = help: take it out of the profile, or leave it out with `--force`
    error: cannot convert invalid/version-cannot-say/system.xml: 2 errors
    "#);
    assert!(!edge.folder.path().join("old.xml").exists());
    let (code, old, stderr) = edge.run(&["convert", file, "--profile-version", "0.1", "--force"]);
    assert_eq!(code, 0);
    assert_eq!(
        stderr.matches("warning[version-cannot-say]").count(),
        2,
        "{stderr}"
    );
    assert!(
        old.contains(r#"rts:version="0.1""#) && old.contains("<rts:Component "),
        "{old}"
    );
    assert!(!old.contains("Activation"), "{old}");
}

#[test]
fn rtc_profiles_change_their_version_too() {
    let edge = with(&["rtc_conf/rtc/Printer.xml"]);
    let file = "rtc_conf/rtc/Printer.xml";
    let (code, old, stderr) = edge.run(&["convert", file, "--rtc-version", "0.1", "--out", "-"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(
        old.contains(r#"rtc:id="RTC:rtsctl.example.Printer:1.0""#),
        "{old}"
    );
    let (code, _, stderr) = edge.run(&["convert", file, "--profile-version", "0.2"]);
    assert_eq!(code, 2, "{stderr}");
}

#[test]
fn a_set_up_becomes_a_profile_and_an_overlay() {
    let files = ["conf/rtc_cpp.conf", "conf/rtc_py.conf", "conf/Sine0.conf"];
    let types = [
        "rtc/SineSource.xml",
        "rtc/LowPassFilter.xml",
        "rtc/Printer.xml",
    ];
    let all: Vec<String> = files
        .iter()
        .chain(&types)
        .map(|file| format!("rtc_conf/{file}"))
        .collect();
    let edge = with(&all.iter().map(String::as_str).collect::<Vec<_>>());
    let (cpp, py) = ("rtc_conf/conf/rtc_cpp.conf", "rtc_conf/conf/rtc_py.conf");
    let (code, stdout, stderr) = edge.run(&[
        "convert",
        cpp,
        py,
        "--rtc",
        "rtc_conf/rtc",
        "--out",
        "lab.xml",
        "--overlay",
        "managers.yaml",
    ]);
    assert_eq!(
        (code, stdout.as_str()),
        (0, "written to lab.xml\n"),
        "{stderr}"
    );
    insta::assert_snapshot!(stderr, @r"
    note[conf-not-carried]: a profile has no place for logger.enable, manager.modules.load_path, manager.modules.preload
     --> rtc_conf/conf/rtc_cpp.conf:5:1
      |
    5 | logger.enable: NO
      | ^^^^^^^^^^^^^
      = help: modules are found where the agent looks for them; of several name servers and formats the first counts
    the managers are in managers.yaml
    ");
    let read = |name: &str| std::fs::read_to_string(edge.folder.path().join(name)).unwrap();
    let profile = read("lab.xml");
    assert!(
        profile.contains(r#"rts:id="RTSystem:unknown:rtc-conf:1.0.0""#),
        "{profile}"
    );
    assert!(!profile.contains("rtsctl.manager"), "{profile}");
    insta::assert_snapshot!(read("managers.yaml"), @r"
    apiVersion: rtsctl.dev/v1
    kind: Deployment
    metadata:
      name: rtc-conf
    spec:
      components:
        Sine0:
          manager: manager_cpp
        Filter0:
          manager: manager_cpp
        Printer0:
          manager: manager_py
    ");
    // Without an overlay the profile says the managers itself.
    let (code, alone, _) = edge.run(&["convert", cpp, py, "--name", "lab"]);
    assert_eq!(code, 0);
    assert_eq!(
        alone.matches(r#"rtsExt:name="rtsctl.manager""#).count(),
        3,
        "{alone}"
    );
    assert!(alone.contains("RTSystem:unknown:lab:1.0.0"), "{alone}");
}

#[test]
fn what_cannot_be_read_is_3_and_what_makes_no_sense_is_2() {
    let edge = with(&[
        "hello/system.xml",
        "invalid/malformed.xml",
        "invalid/conf-no-component.conf",
    ]);
    let code = |args: &[&str]| {
        let (code, stdout, stderr) = edge.run(args);
        assert_eq!(stdout, "", "{args:?}");
        assert!(stderr.contains("error"), "{args:?}: {stderr}");
        code
    };
    assert_eq!(code(&["convert", "missing.xml", "--to", "yaml"]), 3);
    assert_eq!(
        code(&["convert", "invalid/malformed.xml", "--to", "yaml"]),
        3
    );
    assert_eq!(code(&["convert", "invalid/conf-no-component.conf"]), 3);
    assert_eq!(code(&["convert", "hello/system.xml"]), 2);
    assert_eq!(
        code(&[
            "convert",
            "hello/system.xml",
            "hello/system.xml",
            "--to",
            "xml"
        ]),
        2
    );
    assert_eq!(
        code(&["convert", "hello/system.xml", "--to", "yaml", "--name", "x"]),
        2
    );
    assert_eq!(code(&["convert", "rtc.conf", "hello/system.xml"]), 2);
    assert_eq!(
        code(&["convert", "invalid/conf-no-component.conf", "--name", "A B"]),
        2
    );
    assert_eq!(
        code(&[
            "convert",
            "invalid/conf-no-component.conf",
            "--out",
            "a",
            "--overlay",
            "a"
        ]),
        2
    );
}
