//! `rtc.conf` files: the small wrong ones, a whole set-up, every real one, and how much memory one may cost.

// A failure here is a failed test; only the tests read files and the environment, the crate does not.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use rts_schemas::codes;
use rts_schemas::diagnostic::{Finding, Report, Severity, render};
use rts_schemas::form::Format;
use rts_schemas::rtc_conf::{Converted, Options, SIZE_LIMIT, Sources, convert, load, read};
use rts_schemas::rtc_profile::forms::RtcProfile;
use rts_schemas::{overlay, rtc_profile, rts_profile};

/// Files of a folder.
struct Folder(PathBuf);

impl Sources for Folder {
    fn read(&self, path: &str) -> Result<Option<Vec<u8>>, String> {
        Ok(std::fs::read(self.0.join(path)).ok())
    }
}

fn manifests() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../manifests")
}

fn types(folder: &Path) -> Vec<RtcProfile> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut files: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    files.sort();
    let xml = files
        .iter()
        .filter(|path| path.extension().is_some_and(|e| e == "xml"));
    xml.map(|path| {
        rtc_profile::read("RTC.xml", &std::fs::read(path).unwrap())
            .unwrap()
            .profile
    })
    .collect()
}

/// A set-up in a folder, with everything that was found.
fn converted(folder: &Path, files: &[&str], types: &[RtcProfile]) -> Converted {
    let read: Vec<_> = files
        .iter()
        .map(|file| std::fs::read(folder.join(file)).unwrap())
        .collect();
    let named: Vec<(&str, &[u8])> = files
        .iter()
        .copied()
        .zip(read.iter().map(Vec::as_slice))
        .collect();
    let mut report = Report::default();
    let setup = load(&named, &Folder(folder.to_owned()), &mut report);
    let options = Options {
        name: Some("made"),
        created: "2026-01-15T10:00:00",
        types,
        managers_inside: false,
    };
    let mut made = convert(&setup, &options);
    report.extend(std::mem::take(&mut made.report));
    made.report = report;
    made
}

fn shown(report: &Report) -> String {
    report
        .findings
        .iter()
        .map(render)
        .collect::<Vec<_>>()
        .join("\n\n")
}

#[test]
fn each_wrong_file_gives_its_code() {
    let folder = manifests().join("invalid");
    let mut seen = BTreeSet::new();
    let ours: Vec<_> = codes::all()
        .filter(|code| code.code.starts_with("conf-"))
        .collect();
    assert!(ours.len() >= 18);
    for code in ours {
        let own = folder.join(code.code);
        let made = match own.is_dir() {
            true => converted(&own, &["rtc.conf"], &types(&own)),
            false => converted(&folder, &[&format!("{}.conf", code.code)], &[]),
        };
        for finding in &made.report.findings {
            assert!(finding.help.is_some(), "{finding:?}");
            assert!(codes::find(&finding.code).is_some(), "{finding:?}");
            seen.insert(finding.code.clone());
        }
        let found = made
            .report
            .findings
            .iter()
            .any(|finding| finding.code == code.code);
        assert!(found, "{}: {}", code.code, shown(&made.report));
        insta::assert_snapshot!(code.code, shown(&made.report));
    }
    let unused: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    for path in unused
        .iter()
        .filter(|path| path.extension().is_some_and(|e| e == "conf"))
    {
        let stem = path.file_stem().unwrap().to_str().unwrap();
        assert!(seen.contains(stem), "{stem} is no code");
    }
}

#[test]
fn a_set_up_of_two_managers_becomes_one_system() {
    let folder = manifests().join("rtc_conf");
    let files = ["conf/rtc_cpp.conf", "conf/rtc_py.conf"];
    let made = converted(&folder, &files, &types(&folder.join("rtc")));
    assert!(!made.report.has_errors(), "{}", shown(&made.report));
    insta::assert_snapshot!("set_up_findings", shown(&made.report));
    let text = made.text(Format::Xml);
    insta::assert_snapshot!("set_up_profile", text);
    insta::assert_snapshot!("set_up_overlay", made.overlay);
    let overlay = overlay::read("made.yaml", made.overlay.as_bytes()).unwrap();
    let (spec, report) = rts_profile::load("made.xml", text.as_bytes(), None, &[overlay]).unwrap();
    assert_eq!(report, Report::default());
    let placed: Vec<_> = spec
        .components
        .iter()
        .map(|c| (c.instance.as_str(), c.placement.manager.as_deref()))
        .collect();
    let (cpp, py) = (Some("manager_cpp"), Some("manager_py"));
    assert_eq!(placed, [("Sine0", cpp), ("Filter0", cpp), ("Printer0", py)]);
    assert_eq!(
        spec.components[0].configuration.active.as_deref(),
        Some("slow")
    );
    assert_eq!(spec.components[2].execution_context.rate, Some(50.0));
    // The YAML says the same.
    let yaml = made.text(Format::Yaml);
    let (again, _) = rts_profile::load("made.yaml", yaml.as_bytes(), None, &[]).unwrap();
    assert_eq!(again.connectors, spec.connectors);
    assert_eq!(again.orders, spec.orders);
}

/// A composite component names its members in its configuration.
#[test]
fn a_composite_keeps_its_members() {
    let text = "manager.components.precreate: PeriodicECSharedComposite?instance_name=Arm, Motor, Sensor\n\
        composite.Arm.conf.default.members: Motor0, Sensor0, Nobody0\n\
        composite.Arm.conf.default.exported_ports: Motor0.in\n\
        manager.components.preactivation: Arm, Motor0, Sensor0\n";
    let mut report = Report::default();
    let setup = load(
        &[("rtc.conf", text.as_bytes())],
        &Folder(PathBuf::new()),
        &mut report,
    );
    let options = Options {
        name: Some("arm"),
        created: "2026-01-01T00:00:00",
        types: &[],
        managers_inside: true,
    };
    let made = convert(&setup, &options);
    let arm = &made.profile.components[0];
    assert_eq!(
        arm.composite_type.as_ref().unwrap().value,
        "PeriodicECShared"
    );
    let members: Vec<&str> = arm
        .participants
        .iter()
        .flat_map(|one| &one.participant)
        .map(|member| member.instance_name.as_ref().unwrap().value.as_str())
        .collect();
    assert_eq!(members, ["Motor0", "Sensor0"]);
    assert_eq!(arm.configuration_sets[0].data.len(), 2);
    insta::assert_snapshot!("composite_findings", shown(&made.report));
}

#[test]
fn without_rtc_profiles_types_are_guessed_and_said() {
    let folder = manifests().join("rtc_conf");
    let made = converted(&folder, &["conf/rtc_cpp.conf"], &[]);
    let codes: Vec<&str> = made
        .report
        .findings
        .iter()
        .map(|f| f.code.as_str())
        .collect();
    assert_eq!(
        codes,
        [
            "conf-unknown-instance",
            "conf-unknown-type",
            "conf-unknown-type",
            "conf-not-carried"
        ]
    );
    let text = made.text(Format::Xml);
    let (spec, _) = rts_profile::load("made.xml", text.as_bytes(), None, &[]).unwrap();
    assert_eq!(
        spec.components[0].full_id,
        "RTC:unknown:example:SineSource:1.0.0"
    );
    assert_eq!(spec.connectors.len(), 1);
}

fn corpus() -> Option<PathBuf> {
    let found = std::env::var_os("RTSCTL_CORPUS").map(PathBuf::from);
    if found.is_none() {
        println!("skipped: RTSCTL_CORPUS is not set");
    }
    found
}

fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, found);
        } else if path
            .to_str()
            .is_some_and(|path| path.ends_with(".conf") || path.ends_with(".conf.sample"))
        {
            found.push(path);
        }
    }
}

#[test]
fn every_real_file_is_read() {
    let Some(corpus) = corpus() else { return };
    let mut files = Vec::new();
    for folder in ["conf", "systems"] {
        files_below(&corpus.join(folder), &mut files);
    }
    files.sort();
    let (mut entries, mut refused) = (0, Vec::new());
    let mut found: BTreeMap<String, usize> = BTreeMap::new();
    for path in &files {
        let name = path.strip_prefix(&corpus).unwrap().to_str().unwrap();
        match read(name, &std::fs::read(path).unwrap()) {
            Ok(conf) => {
                entries += conf.entries.len();
                for finding in conf.findings.findings {
                    *found.entry(finding.code).or_default() += 1;
                }
            }
            Err(report) => {
                let finding = &report.findings[0];
                refused.push(format!("{name}: {} ({})", finding.code, finding.message));
            }
        }
    }
    println!(
        "{} files, {} refused, {entries} entries",
        files.len(),
        refused.len()
    );
    println!("{}", refused.join("\n"));
    assert!(files.len() >= 109, "the corpus is incomplete");
    // Files of another program, which happen to end in `.conf`.
    insta::assert_snapshot!("refused_real_files", refused.join("\n"));
    insta::assert_json_snapshot!("findings_of_real_files", found);
    assert!(refused.iter().all(|line| line.starts_with("systems/")));
}

/// Each real set-up becomes a profile that is read without errors.
#[test]
fn every_real_set_up_is_converted() {
    let Some(corpus) = corpus() else { return };
    let mut files = Vec::new();
    for folder in ["conf", "systems"] {
        files_below(&corpus.join(folder), &mut files);
    }
    files.sort();
    let mut said = Vec::new();
    let mut made = 0;
    for path in files {
        let name = path
            .strip_prefix(&corpus)
            .unwrap()
            .to_str()
            .unwrap()
            .to_owned();
        let bytes = std::fs::read(&path).unwrap();
        let Ok(conf) = read(&name, &bytes) else {
            continue;
        };
        let precreate = conf.get("manager.components.precreate");
        if precreate.is_none_or(|entry| entry.value.is_empty()) {
            continue;
        }
        let result = converted(&corpus, &[&name], &[]);
        assert!(
            !result.report.has_errors(),
            "{name}: {}",
            shown(&result.report)
        );
        let text = result.text(Format::Xml);
        let (spec, report) = rts_profile::load("made.xml", text.as_bytes(), None, &[]).unwrap();
        let composite = |f: &Finding| f.code == "composite-component";
        assert!(report.findings.iter().all(composite), "{name}: {report:?}");
        overlay::read("made.yaml", result.overlay.as_bytes()).unwrap();
        made += 1;
        let warned = result
            .report
            .findings
            .iter()
            .filter(|f| f.severity == Severity::Warning);
        let warned: BTreeSet<&str> = warned.map(|f| f.code.as_str()).collect();
        let components: Vec<&str> = spec
            .components
            .iter()
            .map(|c| c.instance.as_str())
            .collect();
        said.push(format!(
            "{name}: {} | {}",
            components.join(", "),
            warned.into_iter().collect::<Vec<_>>().join(", ")
        ));
    }
    println!("{made} set-ups");
    insta::assert_snapshot!("real_set_ups", said.join("\n"));
}

/// Itself, as a component's file.
struct Itself(Vec<u8>);

impl Sources for Itself {
    fn read(&self, _: &str) -> Result<Option<Vec<u8>>, String> {
        Ok(Some(self.0.clone()))
    }
}

proptest! {
    /// Whatever a file says, what is written can be read, and says the components in their order.
    #[test]
    fn what_is_made_of_any_file_is_a_profile(lines in proptest::collection::vec(line(), 0..12)) {
        let bytes = lines.join("\n").into_bytes();
        let mut report = Report::default();
        let setup = load(&[("rtc.conf", &bytes)], &Itself(bytes.clone()), &mut report);
        let options = Options { name: None, created: "2026-01-15T10:00:00", types: &[], managers_inside: true };
        let made = convert(&setup, &options);
        report.extend(made.report.clone());
        report.findings.iter().for_each(|finding| drop(render(finding)));
        let text = made.text(Format::Xml);
        let read = rts_profile::read("made.xml", text.as_bytes()).unwrap();
        prop_assert_eq!(read.findings, Report::default());
        let names = |profile: &rts_profile::model::RtsProfile| -> Vec<String> {
            profile.components.iter().map(|c| c.instance_name.clone().unwrap().value).collect()
        };
        let written: Vec<String> =
            made.profile.components.iter().map(|c| c.instance_name.clone().unwrap().value).collect();
        prop_assert_eq!(names(&read.profile), written);
        overlay::read("made.yaml", made.overlay.as_bytes()).unwrap();
        // What is no error may be deployed, but for names that nothing here judges.
        if !report.has_errors() {
            let judged = rts_profile::load("made.xml", text.as_bytes(), Some("x"), &[]);
            let wrong = judged.err().map(|report| report.findings).unwrap_or_default();
            let known = ["bad-name", "unknown-placement-key", "bad-placement-value"];
            let wrong: Vec<_> = wrong.iter().filter(|f| f.severity == Severity::Error).collect();
            prop_assert!(wrong.iter().all(|f| known.contains(&f.code.as_str())), "{:?}", wrong);
        }
    }
}

/// A line that is nearly one of a real file.
fn line() -> impl Strategy<Value = String> {
    let key = prop_oneof![
        Just("manager.components.precreate"),
        Just("manager.components.preconnect"),
        Just("manager.components.preactivation"),
        Just("manager.instance_name"),
        Just("corba.nameservers"),
        Just("naming.formats"),
        Just("exec_cxt.periodic.rate"),
        Just("c.A0.config_file"),
        Just("c.A.conf.default.x"),
        Just("conf.set.y"),
        Just("configuration.active_config"),
        Just("rtsctl.type"),
    ];
    let item = "(A|B|A0|B0|A0\\.o|RTC:v:c:A:1|rtcname://h:1/B0\\.i|A0\\.o\\?port=B0\\.i|B0\\.i:A0\\.o\\(k=v\\)|A\\?instance_name=[ -~]{1,3}|%n\\.rtc|[ -~あ]{0,6}|[0-9]{1,4})";
    let value = proptest::collection::vec(item, 0..4).prop_map(|items| items.join(", "));
    (key, "(: |:|=| )", value, "(|\\\\|\r)")
        .prop_map(|(key, mark, value, end)| format!("{key}{mark}{value}{end}"))
}

#[test]
fn a_port_that_is_connected_with_itself_is_told() {
    struct Nothing;
    impl Sources for Nothing {
        fn read(&self, _: &str) -> Result<Option<Vec<u8>>, String> {
            Ok(None)
        }
    }
    let text = "manager.components.precreate: A\nmanager.components.preconnect: A0.o?port=A0.o\n";
    let mut report = Report::default();
    let setup = load(&[("rtc.conf", text.as_bytes())], &Nothing, &mut report);
    let options = Options {
        name: None,
        created: "2026-01-15T10:00:00",
        types: &[],
        managers_inside: true,
    };
    let made = convert(&setup, &options);
    assert!(made.profile.data_port_connectors.is_empty());
    let codes = made.report.findings.iter().map(|f| f.code.as_str());
    assert!(
        codes.clone().any(|code| code == "self-connector"),
        "{:?}",
        made.report
    );
}

#[test]
fn a_file_that_names_itself_or_too_much_ends() {
    struct Anything;
    impl Sources for Anything {
        fn read(&self, _: &str) -> Result<Option<Vec<u8>>, String> {
            Ok(Some(vec![b'#'; SIZE_LIMIT]))
        }
    }
    let mut text = String::from("manager.components.precreate: ");
    for n in 0..1500 {
        text.push_str(&format!("T{n},"));
    }
    for n in 0..1500 {
        text.push_str(&format!("\nC.T{n}.config_file: {n}.conf"));
    }
    let mut report = Report::default();
    let setup = load(&[("rtc.conf", text.as_bytes())], &Anything, &mut report);
    assert_eq!(setup.managers[0].components.len(), 1000);
    let said = |what: &str| report.findings.iter().any(|f| f.message.contains(what));
    assert!(said(
        "`manager.components.precreate` has more than 1000 items"
    ));
    assert!(said(
        "the files that are named have more than 16777216 bytes"
    ));
}
