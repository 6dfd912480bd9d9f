//! No file can make a reader panic, and what it cannot read it reports.

#![allow(clippy::unwrap_used)] // A failure here is a failed test.

use proptest::prelude::*;
use rts_schemas::canonical::canonical;
use rts_schemas::diagnostic::{Report, render};
use rts_schemas::form::{Around, Form, Format, Vocabulary, format, same};
use rts_schemas::rts_profile::{LowerOptions, load, lower, read};
use rts_schemas::system::SystemSpec;
use rts_schemas::xml::Document;
use rts_schemas::{check, overlay, rtc_profile, rts_profile};

const SYSTEM: &str = include_str!("../../manifests/hello/system.xml");
const TWIN: &str = include_str!("../../manifests/hello/system.yaml");
const COMPONENT: &str = include_str!("component.xml");
const COMPONENT_TWIN: &str = include_str!("component.yaml");
const LAB: &str = include_str!("../../manifests/hello/lab.yaml");
const BENCH: &str = include_str!("../../manifests/hello/bench.yaml");

/// Everything that is done with a file; the laws that hold whatever it contains.
fn attack(bytes: &[u8]) {
    let judged = load("f", bytes, Some("name"), &[]);
    match &judged {
        Ok((spec, report)) => {
            assert!(!report.has_errors());
            assert_eq!(check::spec(spec), Report::default());
            let json = serde_json::to_string(spec).unwrap();
            assert_eq!(&serde_json::from_str::<SystemSpec>(&json).unwrap(), spec);
        }
        Err(report) => assert!(report.has_errors()),
    }
    let (Ok((_, report)) | Err(report)) = judged;
    for finding in &report.findings {
        assert!(!render(finding).contains('\u{1b}'));
    }
    if let Ok(profile) = read("f", bytes) {
        let _ = lower(&profile, &LowerOptions::default());
        let read = |text: &str| read("f", text.as_bytes()).unwrap().shape;
        let words = &rts_profile::forms::WORDS;
        let form = profile.shape.form();
        written(
            form,
            &profile.around,
            words,
            profile.format,
            |text, form| same(read(text).form(), form),
        );
    }
    if let Ok(profile) = rtc_profile::read("f", bytes) {
        let read = |text: &str| rtc_profile::read("f", text.as_bytes()).unwrap().profile;
        let words = &rtc_profile::forms::WORDS;
        let form = &profile.profile;
        written(
            form,
            &profile.around,
            words,
            profile.format,
            |text, form| same(&read(text), form),
        );
    }
    checked(bytes);
    if let Ok(made) = canonical("f", bytes) {
        assert_eq!(
            canonical("f", made.text.as_bytes()).unwrap().text,
            made.text
        );
    }
    if let Ok(document) = Document::open("f", bytes) {
        assert_eq!(document.bytes().unwrap(), bytes);
    }
    match overlay::read("f", bytes) {
        Ok(overlay) => {
            let (mut spec, _) = load("system.xml", SYSTEM.as_bytes(), None, &[]).unwrap();
            overlay::apply(&mut spec, &overlay);
            assert_eq!(check::spec(&spec), Report::default());
            let text = overlay::write(&overlay.deployment);
            let again = overlay::read("f", text.as_bytes()).unwrap();
            assert_eq!(overlay::write(&again.deployment), text);
        }
        Err(report) => assert!(report.has_errors()),
    }
}

/// Everything that is checked about a file; what is deployed has the same findings.
fn checked(bytes: &[u8]) {
    let mut library = check::Library::default();
    library.add(rtc_profile::read("component.xml", COMPONENT.as_bytes()).unwrap());
    if let Ok(system) = check::system("f", bytes, Some("name"), &[], Some(&library)) {
        let (Ok((_, report)) | Err(report)) = load("f", bytes, Some("name"), &[]);
        assert_eq!(system.report, report);
        check::against(&system.read, &library);
        check::placed(&system, Some(&["local"]));
    }
    if let Ok(profile) = rtc_profile::read("f", bytes) {
        check::rtc_profile(&profile);
        let mut library = check::Library::default();
        library.add(profile);
        let system = SYSTEM.replace("LowPassFilter", "Filter");
        let system = read("system.xml", system.as_bytes()).unwrap();
        check::against(&system, &library);
    }
}

/// Whatever was read is written in its format so that it is read as the same.
fn written(
    form: &dyn Form,
    around: &Around,
    words: &Vocabulary,
    own: Format,
    is_same: impl Fn(&str, &dyn Form) -> bool,
) {
    let text = format(form, around, words, own);
    assert!(is_same(&text, form), "{text}");
    let _ = format(form, &Around::default(), words, Format::Yaml);
    let _ = format(form, &Around::default(), words, Format::Xml);
}

#[derive(Debug, Clone)]
enum Edit {
    Remove {
        at: prop::sample::Index,
        count: usize,
    },
    Insert {
        at: prop::sample::Index,
        text: String,
    },
    Copy {
        from: prop::sample::Index,
        count: usize,
        to: prop::sample::Index,
    },
    Byte {
        at: prop::sample::Index,
        value: u8,
    },
}

fn edit() -> impl Strategy<Value = Edit> {
    let index = any::<prop::sample::Index>;
    let words = prop::sample::select(vec![
        "\"",
        "<",
        ">",
        "&",
        "&#0;",
        "&#x1F600;",
        "<!--",
        "-->",
        "]]>",
        "<![CDATA[",
        "rts:",
        "NaN",
        "-1",
        "99999999999999999999",
        "日本語",
        "\u{feff}",
        "\n",
        "\t",
        "'",
        "*a",
        "&a ",
        "? ",
        "- ",
        ": ",
        "{",
        "}",
        "[",
        "|\n",
        "#",
        "!!str ",
        "..",
        "/",
        "\u{0}",
    ]);
    prop_oneof![
        (index(), 1usize..200).prop_map(|(at, count)| Edit::Remove { at, count }),
        (index(), words).prop_map(|(at, text)| Edit::Insert {
            at,
            text: text.to_owned()
        }),
        (index(), 1usize..600, index()).prop_map(|(from, count, to)| Edit::Copy {
            from,
            count,
            to
        }),
        (index(), any::<u8>()).prop_map(|(at, value)| Edit::Byte { at, value }),
    ]
}

fn edited(text: &str, edits: &[Edit]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for edit in edits {
        let length = bytes.len();
        match edit {
            Edit::Remove { at, count } if length > 0 => {
                let at = at.index(length);
                bytes.drain(at..(at + count).min(length));
            }
            Edit::Insert { at, text } => {
                let at = at.index(length + 1);
                bytes.splice(at..at, text.bytes());
            }
            Edit::Copy { from, count, to } if length > 0 => {
                let from = from.index(length);
                let piece = bytes[from..(from + count).min(length)].to_vec();
                let to = to.index(length + 1);
                bytes.splice(to..to, piece);
            }
            Edit::Byte { at, value } if length > 0 => bytes[at.index(length)] = *value,
            _ => {}
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..2048)) {
        attack(&bytes);
    }

    #[test]
    fn any_text(text in "\\PC{0,400}") {
        attack(text.as_bytes());
    }

    #[test]
    fn edits_of_a_profile(edits in prop::collection::vec(edit(), 1..6)) {
        attack(&edited(SYSTEM, &edits));
    }

    #[test]
    fn edits_of_the_yaml_twin(edits in prop::collection::vec(edit(), 1..6)) {
        attack(&edited(TWIN, &edits));
    }

    #[test]
    fn edits_of_a_component(edits in prop::collection::vec(edit(), 1..6)) {
        attack(&edited(COMPONENT, &edits));
        attack(&edited(COMPONENT_TWIN, &edits));
    }

    #[test]
    fn edits_of_an_overlay(edits in prop::collection::vec(edit(), 1..6)) {
        attack(&edited(LAB, &edits));
        attack(&edited(BENCH, &edits));
    }
}

#[test]
fn hostile_files_are_refused_at_once() {
    let deep_xml = "<a>".repeat(100_000);
    let deep_yaml = "[".repeat(100_000);
    let laughs = (1..30).fold("a0: &a0 [x]\n".to_owned(), |text, i| {
        let before = i - 1;
        format!("{text}a{i}: &a{i} [*a{before},*a{before},*a{before},*a{before},*a{before},*a{before},*a{before}]\n")
    });
    for (text, code) in [
        (deep_xml, "too-deep"),
        (deep_yaml, "too-dense"),
        ("[".repeat(200), "too-deep"),
        (laughs, "too-dense"),
    ] {
        let report = load("f", text.as_bytes(), None, &[]).unwrap_err();
        assert_eq!(report.findings[0].code, code);
    }
}
