//! Real files: every one is read, or is listed with the reason why not.
//!
//! The corpus lies beside the checkout where `RTSCTL_CORPUS` points to; elsewhere these tests say that they were skipped.

// A failure here is a failed test; only the tests read files and the environment, the crate does not.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

use std::collections::BTreeMap;
use std::path::PathBuf;

use rts_schemas::diagnostic::{Report, Severity};
use rts_schemas::rts_profile::versions::{Version, to_version};
use rts_schemas::rts_profile::{
    Format, LowerOptions, ReadProfile, WriteOptions, format, load, lower, read, sayable, write,
};
use rts_schemas::system::{SendingTiming, SystemSpec, WaitFor};
use rts_schemas::{check, names};

fn corpus() -> Option<PathBuf> {
    let found = std::env::var_os("RTSCTL_CORPUS").map(PathBuf::from);
    if found.is_none() {
        println!("skipped: RTSCTL_CORPUS is not set");
    }
    found
}

fn bytes(folder: &str, file: &str) -> Option<Vec<u8>> {
    let path = corpus()?.join(folder).join(file);
    Some(std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}

fn lowered(folder: &str, file: &str) -> Option<(ReadProfile, SystemSpec, Report)> {
    let bytes = bytes(folder, file)?;
    let profile = read(file, &bytes).unwrap();
    let options = LowerOptions {
        name: None,
        file_stem: names::file_stem(file),
    };
    let (spec, report) = lower(&profile, &options);
    Some((profile, spec.unwrap(), report))
}

fn codes(report: &Report, severity: Severity) -> Vec<&str> {
    let findings = report.findings.iter().filter(|f| f.severity == severity);
    findings.map(|f| f.code.as_str()).collect()
}

fn files(folder: &str) -> Option<Vec<(String, Vec<u8>)>> {
    let folder = corpus()?.join(folder);
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e != "tsv"))
        .collect();
    files.sort();
    let read = |path: PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        (name, std::fs::read(path).unwrap())
    };
    Some(files.into_iter().map(read).collect())
}

#[test]
fn every_file_is_read_and_judged() {
    let (Some(rts), Some(derived)) = (files("rts"), files("derived")) else {
        return;
    };
    let (mut total, mut clean) = (0, 0);
    let (mut components, mut connectors) = (0, 0);
    let mut refused = Vec::new();
    let mut found: BTreeMap<String, usize> = BTreeMap::new();
    for (file, bytes) in rts.iter().chain(&derived) {
        total += 1;
        // Whatever a real editor wrote is readable; what is wrong in it is said by the checks.
        let profile = read(file, bytes).unwrap_or_else(|report| panic!("{file}: {report:?}"));
        components += profile.profile.components.len();
        connectors += profile.profile.connectors.len();
        let judged = load(file, bytes, None, &[]);
        if let Err(report) = &judged {
            assert!(report.has_errors(), "{file}");
            refused.push(format!(
                "{file}: {}",
                codes(report, Severity::Error).join(", ")
            ));
        } else {
            clean += 1;
        }
        if let Ok((spec, _)) = &judged {
            assert_eq!(check::spec(spec), Report::default(), "{file}");
        }
        let (Ok((_, report)) | Err(report)) = judged;
        for finding in report.findings {
            *found.entry(finding.code).or_default() += 1;
        }
    }
    println!(
        "{total} files, {clean} without errors, {components} components, {connectors} connectors"
    );
    insta::assert_snapshot!(refused.join("\n"));
    insta::assert_json_snapshot!("findings_by_code", found);
    assert!(
        rts.len() >= 71 && derived.len() >= 20,
        "the corpus is incomplete"
    );
}

/// A system that was read is written so that it is read as the same one.
#[test]
fn every_file_is_written_as_the_same_system() {
    let (Some(rts), Some(derived)) = (files("rts"), files("derived")) else {
        return;
    };
    let options = WriteOptions {
        created: "2026-01-15T10:00:00",
        updated: "2026-01-15T10:00:00",
        abstract_text: "",
    };
    let mut same = 0;
    for (file, bytes) in rts.iter().chain(&derived) {
        let profile = read(file, bytes).unwrap();
        let stem = names::file_stem(file);
        let lowered = lower(
            &profile,
            &LowerOptions {
                name: None,
                file_stem: stem,
            },
        );
        let Some(spec) = lowered.0 else { continue };
        let text = write(&spec, &options);
        let again = read("written.xml", text.as_bytes()).unwrap();
        assert_eq!(again.findings, Report::default(), "{file}");
        let lowered = lower(&again, &LowerOptions::default());
        let expected = sayable(&spec);
        assert_eq!(
            lowered,
            (Some(expected.clone()), Report::default()),
            "{file}"
        );
        same += usize::from(expected == spec);
        // What may be deployed may be deployed again.
        if let Ok((spec, _)) = load(file, bytes, None, &[]) {
            assert_eq!(expected, spec, "{file}");
            let (loaded, report) = load("written.xml", text.as_bytes(), None, &[]).unwrap();
            assert_eq!(loaded, spec, "{file}");
            let known = ["empty-system", "unknown-configuration-set"];
            let new = report
                .findings
                .iter()
                .find(|f| !known.contains(&f.code.as_str()));
            assert_eq!(new, None, "{file}");
        }
    }
    println!("{same} systems came back without a change");
    assert!(same >= 80, "{same}");
}

/// A profile in the older version, and that one in the newer again, are the same system but for what is named as lost.
#[test]
fn every_file_goes_to_the_old_version_and_back() {
    let (Some(rts), Some(derived)) = (files("rts"), files("derived")) else {
        return;
    };
    let of = |bytes: &[u8], file: &str| {
        let profile = read(file, bytes).unwrap();
        let spec = lower(
            &profile,
            &LowerOptions {
                name: Some("x"),
                file_stem: None,
            },
        )
        .0;
        (profile, spec.unwrap())
    };
    // The order of connectors is that of their ports in the old version.
    let plain = |mut spec: SystemSpec| {
        let starting = std::mem::take(&mut spec.orders).start_up;
        spec.orders.start_up = starting;
        spec.orders
            .start_up
            .sort_by_key(|c| (c.sequence, c.target.clone()));
        spec.connectors.sort_by(|a, b| a.name.cmp(&b.name));
        spec.full_id = names::id_with_colons(&spec.full_id);
        for component in &mut spec.components {
            component.full_id = names::id_with_colons(&component.full_id);
        }
        for composite in &mut spec.composites {
            composite.full_id = names::id_with_colons(&composite.full_id);
        }
        spec
    };
    let (mut same, mut lost) = (0, BTreeMap::<String, usize>::new());
    for (file, bytes) in rts.iter().chain(&derived) {
        let (profile, spec) = of(bytes, file);
        let (old, around, report) = to_version(&profile, Version::V01);
        let text = format(&old, &around, Format::Xml);
        let (old_profile, old_spec) = of(text.as_bytes(), "old.xml");
        for finding in &report.findings {
            *lost.entry(finding.message.clone()).or_default() += 1;
        }
        let orders_only = report
            .findings
            .iter()
            .all(|f| f.message.contains("tion`") || f.message.contains("Down`"));
        // What is kept for the way back is not understood on the way.
        let kept = ["rtsctl.v02.id", "rtsctl.v02.source.undeclared"];
        if orders_only && !kept.iter().any(|name| text.contains(name)) {
            assert_eq!(plain(old_spec), plain(spec.clone()), "{file}");
            same += 1;
        }
        let (new, around, report) = to_version(&old_profile, Version::V02);
        let known = |message: &str| message.contains("`Choice`");
        assert!(
            report.findings.iter().all(|f| known(&f.message)),
            "{file}: {report:?}"
        );
        let (_, new_spec) = of(format(&new, &around, Format::Xml).as_bytes(), "new.xml");
        if orders_only {
            assert_eq!(plain(new_spec), plain(spec), "{file}");
        }
    }
    println!("{same} systems in the old version without other loss than orders");
    assert!(same >= 60, "{same}");
    insta::assert_json_snapshot!("lost_in_the_old_version", lost);
}

#[test]
fn every_rtc_profile_changes_its_version_once() {
    use rts_schemas::rtc_profile::{format, read, versions::Version, versions::to_version};
    let Some(rtc) = files("rtc") else { return };
    let mut read_files = 0;
    for (file, bytes) in &rtc {
        let Ok(profile) = read(file, bytes) else {
            continue;
        };
        read_files += 1;
        for version in [Version::V01, Version::V02, Version::V03] {
            let (new, _) = to_version(&profile, version);
            let text = format(&new, &profile.around, Format::Xml);
            let again = read("new.xml", text.as_bytes()).unwrap();
            let (twice, report) = to_version(&again, version);
            assert!(
                !report.has_errors(),
                "{file} in {}: {report:?}",
                version.name()
            );
            let twice = format(&twice, &again.around, Format::Xml);
            assert!(twice == text, "{file} in {}", version.name());
        }
    }
    println!("{read_files} RTC Profiles");
    assert!(read_files >= 100, "{read_files}");
}

#[test]
fn reversed_ends_of_choreonoid_are_swapped() {
    let Some((profile, spec, report)) = lowered(
        "rts",
        "MasutaniLab__KobukiForChoreonoid__root-RTSystem~125fbf1.xml",
    ) else {
        return;
    };
    assert!(codes(&report, Severity::Warning).contains(&"reversed-connector"));
    for connector in spec
        .connectors
        .iter()
        .filter(|c| c.kind == rts_schemas::system::PortKind::Data)
    {
        let direction = |end: &rts_schemas::system::PortRef| {
            let component = spec
                .components
                .iter()
                .find(|c| c.instance == end.instance)
                .unwrap();
            component
                .ports
                .iter()
                .find(|p| p.name == end.port)
                .unwrap()
                .direction
        };
        assert_ne!(
            direction(&connector.source),
            Some(rts_schemas::system::Direction::In),
            "{}",
            connector.name
        );
        assert_ne!(
            direction(&connector.target),
            Some(rts_schemas::system::Direction::Out),
            "{}",
            connector.name
        );
    }
    assert_eq!(
        check::profile(&profile)
            .findings
            .iter()
            .filter(|f| f.code == "direction-mismatch")
            .count(),
        0
    );
    // The instance name stands where the type belongs; its number is not part of the type.
    let (_, spec, _) = lowered("rts", "MasutaniLab__KobukiForChoreonoid__RTSystem.xml").unwrap();
    let types: Vec<&str> = spec
        .components
        .iter()
        .map(|c| c.type_name.as_str())
        .collect();
    assert_eq!(types, ["KobukiController", "Turtlebot-KobukiIoRTC"]);
}

#[test]
fn two_hosts_hidden_in_references_are_found() {
    let file =
        "Nobu19800__RaspberryPiMouseRTSystem_script__GamePadLightSensorControlRasPiMouse.rtsys";
    let Some((_, spec, _)) = lowered("rts", file) else {
        return;
    };
    assert_eq!(
        spec.name,
        names::dns_label(names::file_stem(file).unwrap()).unwrap()
    );
    assert_eq!((spec.components.len(), spec.connectors.len()), (6, 8));
    let placed: Vec<String> = spec
        .components
        .iter()
        .map(|c| {
            format!(
                "{} {} {}",
                c.instance,
                c.placement.host.as_deref().unwrap_or("-"),
                c.placement.manager.as_deref().unwrap_or("main")
            )
        })
        .collect();
    insta::assert_snapshot!(placed.join("\n"));
}

#[test]
fn version_0_1_has_its_connectors_inside_ports() {
    let Some((profile, spec, _)) = lowered("rts", "OpenRTM__OpenRTP-aist__RtsSampleV01.xml") else {
        return;
    };
    assert_eq!(spec.name, "ta-sample");
    assert_eq!(spec.components.len(), 2);
    assert_eq!(spec.composites.len(), 3, "without members");
    assert_eq!(spec.components[0].type_name, "ConsoleIn");
    assert_eq!(spec.connectors[0].name, "ConsoleIn0.out-ConsoleOut0.in");
    assert_eq!(
        spec.connectors[0].data_type.as_deref(),
        Some("IDL:RTC/TimedLong:1.0")
    );
    assert_eq!(
        spec.connectors[0].properties["dataport.subscription_type"],
        "flush"
    );
    // The sample connects to ConsoleOut0, but has only ConsoleOut1 to 4.
    assert_eq!(
        codes(&check::profile(&profile), Severity::Error),
        ["unknown-instance"]
    );
}

#[test]
fn xml_and_yaml_twins_are_the_same_system() {
    let Some((xml, mut a, _)) = lowered("rts", "gbiggs__rtsprofile__rtsystem.xml") else {
        return;
    };
    let (yaml, mut b, _) = lowered("rts", "gbiggs__rtsprofile__rtsystem.yaml").unwrap();
    assert_eq!((xml.format, yaml.format), (Format::Xml, Format::Yaml));
    let (_, c, _) = lowered("rts", "gbiggs__rtsprofile__test-rtsystem.yaml").unwrap();
    assert_eq!(b, c, "1000 and 1000.0 are one rate");

    // What the two files themselves say differently, and nothing else.
    // Ports: the YAML has the typo `inort` also where the XML writes `inport`.
    assert_eq!(a.components[1].ports[0].name, "Comp2_inport1");
    assert_eq!(b.components[1].ports[0].name, "Comp2_inort1");
    a.components[1].ports[0]
        .name
        .clone_from(&b.components[1].ports[0].name);
    a.components[2].ports[0]
        .name
        .clone_from(&b.components[2].ports[0].name);
    a.connectors[0].name.clone_from(&b.connectors[0].name);
    a.connectors[0]
        .target
        .port
        .clone_from(&b.connectors[0].target.port);
    // Parameters: `name_1` and `name1`; the second component's set is only in the YAML.
    for spec in [&mut a, &mut b] {
        for component in &mut spec.components {
            component.configuration.sets.clear();
        }
    }
    // The service connector starts from the other end.
    let service = &mut a.connectors[2];
    std::mem::swap(&mut service.source, &mut service.target);
    service.name = format!("{}-{}", service.source, service.target);
    assert_eq!(a, b);

    assert_eq!(
        a.orders.start_up[1].wait,
        Some(WaitFor::Time { milliseconds: 500 })
    );
    assert_eq!(a.orders.shut_down.len(), 3);
    // The typo is an error of the XML only: there the port is declared right and connected wrong.
    assert_eq!(
        codes(&check::profile(&xml), Severity::Error),
        ["unknown-port"]
    );
    assert_eq!(
        codes(&check::profile(&yaml), Severity::Error),
        [] as [&str; 0]
    );
}

#[test]
fn orders_are_read_in_all_their_forms() {
    let Some((_, spec, _)) = lowered("derived", "plan_all.rtsys.xml") else {
        return;
    };
    assert_eq!(spec.name, "demo");
    insta::assert_json_snapshot!("plan_all", spec.orders.activation);
    let waits = |file: &str| {
        let (_, spec, _) = lowered("derived", file).unwrap();
        spec.orders.activation
    };
    assert!(waits("plan_seq.rtsys.xml").iter().all(|c| c.wait.is_none()));
    assert!(
        waits("plan_wait.rtsys.xml")
            .iter()
            .any(|c| matches!(c.wait, Some(WaitFor::Time { .. })))
    );
    let timing = |file: &str| {
        waits(file).into_iter().find_map(|c| match c.wait {
            Some(WaitFor::Preceding {
                timing, timeout_ms, ..
            }) => Some((timing, timeout_ms)),
            _ => None,
        })
    };
    assert!(matches!(
        timing("plan_async.rtsys.xml"),
        Some((SendingTiming::Async, _))
    ));
    assert!(matches!(
        timing("plan_sync.rtsys.xml"),
        Some((SendingTiming::Sync, 1..))
    ));
    assert_eq!(
        timing("plan_sync0.rtsys.xml"),
        Some((SendingTiming::Sync, 0))
    );

    // RT System Editor writes neither ids nor waits: plain order numbers, in all seven orders.
    let (profile, spec, _) = lowered("derived", "rts_rtse_ordering_v02.xml").unwrap();
    let o = &spec.orders;
    let all = [
        &o.start_up,
        &o.shut_down,
        &o.activation,
        &o.deactivation,
        &o.resetting,
        &o.initializing,
        &o.finalizing,
    ];
    assert!(
        all.iter()
            .all(|order| order.len() == 3 && order.iter().all(|c| c.wait.is_none()))
    );
    assert_eq!(o.shut_down[0].target, "Sensor0");
    assert_eq!(o.shut_down[0].sequence, 3);
    assert_eq!(check::profile(&profile), Report::default());

    let (_, spec, _) = lowered("rts", "gbiggs__rtshell__rtsystem.xml").unwrap();
    assert!(spec.orders.activation.iter().any(|c| matches!(
        c.wait,
        Some(WaitFor::Preceding {
            timing: SendingTiming::Async,
            ..
        })
    )));
}

#[test]
fn every_encoding_gives_the_same_system() {
    let Some((_, expected, _)) = lowered("derived", "rts_utf8_japanese.xml") else {
        return;
    };
    for (file, encoding, warnings) in [
        ("rts_utf8_japanese.xml", "UTF-8", 0),
        ("rts_utf8_bom_crlf.xml", "UTF-8", 0),
        ("rts_shift_jis.xml", "Shift_JIS", 0),
        ("rts_shift_jis_cp932ext.xml", "Shift_JIS", 0),
        ("rts_windows31j.xml", "Shift_JIS", 0),
        ("rts_euc_jp.xml", "EUC-JP", 0),
        ("rts_utf16.xml", "UTF-16LE", 0),
        ("rts_declared_utf8_but_cp932.xml", "Shift_JIS", 1),
        ("rts_other_prefixes.xml", "UTF-8", 0),
        ("rts_default_namespace.xml", "UTF-8", 0),
    ] {
        let (profile, mut spec, _) = lowered("derived", file).unwrap();
        assert_eq!(profile.encoding, encoding, "{file}");
        assert_eq!(
            codes(&profile.findings, Severity::Warning).len(),
            warnings,
            "{file}"
        );
        let text = profile.profile.abstract_text.unwrap().value;
        let japanese = !matches!(file, "rts_other_prefixes.xml" | "rts_default_namespace.xml");
        assert_eq!(
            text.contains("（複合コンポーネント試験）"),
            japanese,
            "{file}: {text}"
        );
        spec.name.clone_from(&expected.name);
        assert_eq!(spec, expected, "{file}");
    }
}
