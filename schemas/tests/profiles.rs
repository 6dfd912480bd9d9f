//! Every real profile is read, kept and written.

// A failure here is a failed test; only the tests read files and the environment, the crate does not.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

mod forms;

use std::collections::HashSet;
use std::fmt::Write;

use forms::changes::{Change, assert_untouched, change, instances, moved, rename};
use forms::versions::only_what_is_named_is_lost;
use forms::{Tape, bare, edit, files, loose, sorted};
use rts_schemas::canonical::canonical;
use rts_schemas::diagnostic::{Report, Source};
use rts_schemas::form::{Around, Form, Format, Value, Vocabulary, format, same, strip_places};
use rts_schemas::rtc_profile::forms::RtcProfile;
use rts_schemas::rts_profile::forms::Shape;
use rts_schemas::xml::{Document, Element, parse_tree};
use rts_schemas::{rtc_profile, rts_profile};

/// A profile of either kind.
#[derive(Clone)]
enum Any {
    Rts(Shape),
    Rtc(Box<RtcProfile>),
}

struct Read {
    file: String,
    bytes: Vec<u8>,
    text: String,
    format: Format,
    around: Around,
    profile: Any,
}

impl Any {
    fn form(&self) -> &dyn Form {
        match self {
            Self::Rts(shape) => shape.form(),
            Self::Rtc(profile) => &**profile,
        }
    }

    fn form_mut(&mut self) -> &mut dyn Form {
        match self {
            Self::Rts(shape) => shape.form_mut(),
            Self::Rtc(profile) => &mut **profile,
        }
    }

    fn words(&self) -> &'static Vocabulary {
        match self {
            Self::Rts(_) => &rts_profile::forms::WORDS,
            Self::Rtc(_) => &rtc_profile::forms::WORDS,
        }
    }

    fn patch(&self, document: &Document, new: &Self) -> Option<Document> {
        let patched = match (self, new) {
            (Self::Rts(a), Self::Rts(b)) => rts_profile::patch(document, a, b),
            (Self::Rtc(a), Self::Rtc(b)) => rtc_profile::patch(document, a, b),
            _ => return None,
        };
        Some(patched.unwrap())
    }
}

fn read_rts(file: &str, bytes: &[u8]) -> Result<Read, Report> {
    let read = rts_profile::read(file, bytes)?;
    Ok(Read {
        file: file.to_owned(),
        bytes: bytes.to_vec(),
        text: read.source.text().to_owned(),
        format: read.format,
        around: read.around,
        profile: Any::Rts(read.shape),
    })
}

fn read_rtc(file: &str, bytes: &[u8]) -> Result<Read, Report> {
    let read = rtc_profile::read(file, bytes)?;
    Ok(Read {
        file: file.to_owned(),
        bytes: bytes.to_vec(),
        text: read.source.text().to_owned(),
        format: read.format,
        around: read.around,
        profile: Any::Rtc(Box::new(read.profile)),
    })
}

fn again(read: &Read, text: &str) -> Read {
    let again = match read.profile {
        Any::Rts(_) => read_rts(&read.file, text.as_bytes()),
        Any::Rtc(_) => read_rtc(&read.file, text.as_bytes()),
    };
    again.unwrap_or_else(|report| panic!("{}: {report:?}\n{text}", read.file))
}

/// Everything in the corpus that can be read, and the reasons why the rest cannot.
fn corpus() -> Option<(Vec<Read>, String)> {
    let mut all = Vec::new();
    let mut refused = String::new();
    for folder in ["rts", "derived", "rtc"] {
        for (file, bytes) in files(folder)? {
            let read = match folder {
                "rtc" => read_rtc(&file, &bytes),
                _ => read_rts(&file, &bytes),
            };
            match read {
                Ok(read) => all.push(read),
                Err(report) => {
                    let finding = &report.findings[0];
                    let place = finding.place.as_ref().unwrap();
                    let (line, column) = (place.line, place.column);
                    let why = format!("{}: {}", finding.code, finding.message);
                    writeln!(refused, "{folder}/{file}:{line}:{column} {why}").unwrap();
                }
            }
        }
    }
    Some((all, refused))
}

/// How many forms and texts there are, and what has no field.
fn count(form: &dyn Form, counts: &mut [usize; 4]) {
    counts[0] += 1;
    let beside = form.extra().get();
    let unknown = beside
        .attributes
        .iter()
        .filter(|a| !a.qname.starts_with("xmlns"));
    counts[2] += unknown.count();
    counts[3] += beside.strays.len() + beside.keys.len();
    for at in 0..form.form_type().fields.len() {
        match form.value(at) {
            Value::Forms(forms) => {
                (0..forms.count()).for_each(|index| count(forms.form(index).unwrap(), counts));
            }
            value => counts[1] += value.count(),
        }
    }
}

#[test]
fn every_profile_is_read() {
    let Some((all, refused)) = corpus() else {
        return;
    };
    let mut counts = [0; 4];
    let mut unknown = String::new();
    for read in &all {
        let mut own = [0; 4];
        count(read.profile.form(), &mut own);
        if own[2] + own[3] > 0 {
            writeln!(
                unknown,
                "{}: {} attributes, {} nodes or keys",
                read.file, own[2], own[3]
            )
            .unwrap();
        }
        counts
            .iter_mut()
            .zip(own)
            .for_each(|(all, own)| *all += own);
    }
    println!(
        "{} files read, {} refused; {} elements, {} values, {} attributes and {} nodes without a field",
        all.len(),
        refused.lines().count(),
        counts[0],
        counts[1],
        counts[2],
        counts[3]
    );
    insta::assert_snapshot!("refused", refused);
    insta::assert_snapshot!("without_a_field", unknown);
}

/// The findings of RTC Profiles, by file.
#[test]
fn findings_of_rtc_profiles() {
    let Some(files) = files("rtc") else { return };
    let mut all = String::new();
    for (file, bytes) in files {
        if let Ok(read) = rtc_profile::read(&file, &bytes) {
            for finding in read.findings.findings {
                let line = finding.place.map_or(0, |place| place.line);
                writeln!(all, "{file}:{line} {}: {}", finding.code, finding.message).unwrap();
            }
        }
    }
    insta::assert_snapshot!(all);
}

/// Attributes and first children of elements, each kind once.
fn kinds<'a>(
    element: &'a Element,
    words: &Vocabulary,
    seen: &mut HashSet<String>,
    found: &mut Vec<(Option<&'a str>, usize)>,
) {
    if !words.knows(&element.namespace) {
        return;
    }
    for attribute in &element.attributes {
        let ours = words.knows(&attribute.namespace) && !attribute.qname.starts_with("xsi:");
        let kind = format!("{} {}", element.qname, attribute.qname);
        if ours && !attribute.value.is_empty() && seen.insert(kind) {
            found.push((Some(&attribute.qname), attribute.span.range().start));
        }
    }
    if let Some(child) = element.elements().next()
        && seen.insert(element.qname.to_string())
    {
        found.push((None, child.span.range().start));
    }
    for child in element.elements() {
        kinds(child, words, seen, found);
    }
}

/// A slip of the pen in each kind of attribute and element that real files have is told where it stands.
#[test]
fn no_slip_is_passed_over_in_silence() {
    let Some((all, _)) = corpus() else { return };
    let mut seen = HashSet::new();
    let mut slips = 0;
    for read in &all {
        if read.format != Format::Xml || read.text.as_bytes() != read.bytes {
            continue;
        }
        let words = read.profile.words();
        let tree = parse_tree(&read.text).unwrap();
        let mut found = Vec::new();
        kinds(&tree.root, words, &mut seen, &mut found);
        let mut told = |code: &str, text: String, at: usize| {
            let findings = match read.profile {
                Any::Rts(_) => rts_profile::read("f", text.as_bytes()).unwrap().findings,
                Any::Rtc(_) => rtc_profile::read("f", text.as_bytes()).unwrap().findings,
            };
            let place = Source::new("f", text.as_str()).place(at, at + 1);
            let is_told = findings.findings.iter().any(|finding| {
                let at = finding.place.as_ref().unwrap();
                finding.code == code && (at.line, at.column) == (place.line, place.column)
            });
            assert!(is_told, "{}: {code} {place:?} {findings:?}", read.file);
            slips += 1;
        };
        for (attribute, start) in found {
            let (before, after) = read.text.split_at(start);
            let Some(qname) = attribute else {
                told("stray-text", format!("{before}slip {after}"), start);
                continue;
            };
            let name = before.rfind(qname).unwrap();
            let (head, tail) = (&before[..name], &before[name + qname.len()..]);
            let wrong = format!("{head}{qname}Slip{tail}{after}");
            told("unknown-attribute", wrong, start + "Slip".len());
            if let Some((prefix, local)) = qname.split_once(':') {
                let bare = format!("{head}{local}{tail}{after}");
                told("unprefixed-attribute", bare, start - prefix.len() - 1);
            }
        }
    }
    assert!(slips > 150, "{slips}");
}

/// The form alone writes everything back: elements, attributes, comments, unknown ones too, and their order.
#[test]
fn what_is_written_is_the_tree_that_was_read() {
    let Some((all, _)) = corpus() else { return };
    for read in all.iter().filter(|read| read.format == Format::Xml) {
        let (form, words) = (read.profile.form(), read.profile.words());
        let original = parse_tree(&read.text).unwrap();
        let written = read.around.tree(form, words);
        assert_eq!(bare(written), bare(original.clone()), "{}", read.file);
        let text = format(form, &read.around, words, Format::Xml);
        let printed = parse_tree(&text).unwrap();
        assert_eq!(sorted(printed), sorted(original), "{}", read.file);
        let second = again(read, &text);
        let (form, around) = (second.profile.form(), &second.around);
        assert_eq!(
            format(form, around, words, Format::Xml),
            text,
            "{}",
            read.file
        );
    }
}

/// `rtsctl fmt`: every file has a canonical form, in which nothing is lost, and which is its own.
#[test]
fn every_profile_has_a_canonical_form() {
    let Some((all, _)) = corpus() else { return };
    let mut changed = 0;
    for read in &all {
        let file = &read.file;
        let made = canonical(file, &read.bytes).unwrap_or_else(|report| panic!("{report:?}"));
        assert_eq!(made.format, read.format, "{file}");
        changed += usize::from(made.text.as_bytes() != read.bytes);
        let again = canonical(file, made.text.as_bytes()).unwrap();
        assert!(again.text == made.text, "{file}");
        assert!(
            !made.text.contains('\r') && made.text.ends_with('\n'),
            "{file}"
        );
    }
    println!("{} files, {changed} of them in another form", all.len());
    assert!(changed > all.len() / 2, "{changed}");
}

/// Every kind of edit in every file: the rest keeps its bytes, and the form alone writes the same tree.
#[test]
fn every_edit_leaves_the_rest_as_it_was() {
    let Some((all, _)) = corpus() else { return };
    let (mut edits, mut renamed) = (0, 0);
    for (number, read) in all.iter().enumerate() {
        if read.format != Format::Xml {
            continue;
        }
        let document = Document::open(&read.file, &read.bytes).unwrap();
        for round in 0..12_u32 {
            let tape = tape(u32::try_from(number).unwrap() * 31 + round);
            let mut new = read.profile.clone();
            if let Some(change) = changed(&mut new, &mut Tape::new(&tape), round) {
                edits += 1;
                assert_edited(read, &document, &new, &change);
            }
        }
        let mut names = Vec::new();
        instances(read.profile.form(), &mut names);
        if let Some(name) = names.first() {
            let mut new = read.profile.clone();
            renamed += rename(new.form_mut(), name, "Renamed0");
            let patched = read.profile.patch(&document, &new).unwrap();
            let quoted = |name: &str, quote: char| format!("nstanceName={quote}{name}{quote}");
            let mut expected = document.text().to_owned();
            for quote in ['"', '\''] {
                expected = expected.replace(&quoted(name, quote), &quoted("Renamed0", quote));
            }
            assert_eq!(patched.text(), expected, "{}", read.file);
        }
    }
    println!("{edits} edits, {renamed} names");
    assert!(edits > 1000 && renamed > 100, "{edits} {renamed}");
}

fn tape(seed: u32) -> Vec<u8> {
    (1..80_u32)
        .map(|i| (seed.wrapping_mul(2_654_435_761).wrapping_add(i * 40_503) >> 9) as u8)
        .map(|b| b.wrapping_mul(167).wrapping_add(13) ^ (b >> 3))
        .collect()
}

fn changed(new: &mut Any, tape: &mut Tape<'_>, round: u32) -> Option<Change> {
    match new {
        Any::Rts(Shape::V02(profile)) if round == 0 => {
            let here = profile.span.range().start;
            moved(&mut profile.components, here, tape)
        }
        Any::Rts(Shape::V02(profile)) if round == 1 => {
            let here = profile.span.range().start;
            moved(&mut profile.data_port_connectors, here, tape)
        }
        Any::Rts(Shape::V02(profile)) if round == 2 => {
            let component = profile.components.first_mut()?;
            let here = component.span.range().start;
            moved(&mut component.data_ports, here, tape)
        }
        any => change(any.form_mut(), tape),
    }
}

fn assert_edited(read: &Read, document: &Document, new: &Any, change: &Change) {
    let patched = read.profile.patch(document, new).unwrap();
    assert_untouched(document, patched.text(), change);
    let by_file = parse_tree(patched.text()).unwrap();
    let by_form = read.around.tree(new.form(), new.words());
    assert_eq!(loose(by_form), loose(by_file), "{}: {change:?}", read.file);
    let printed = format(new.form(), &read.around, new.words(), Format::Xml);
    assert!(
        same(again(read, &printed).profile.form(), new.form()),
        "{}",
        read.file
    );
}

/// XML → YAML → XML keeps values, unknown elements and unknown attributes; YAML is written once and for all.
#[test]
fn the_other_format_says_the_same() {
    let Some((all, _)) = corpus() else { return };
    for read in &all {
        let (form, words) = (read.profile.form(), read.profile.words());
        let nothing = Around::default();
        let yaml = format(form, &nothing, words, Format::Yaml);
        let by_yaml = again(read, &yaml);
        assert!(same(form, by_yaml.profile.form()), "{}:\n{yaml}", read.file);
        let second = format(by_yaml.profile.form(), &nothing, words, Format::Yaml);
        assert_eq!(second, yaml, "{}", read.file);
        if read.format == Format::Xml {
            let xml = format(by_yaml.profile.form(), &nothing, words, Format::Xml);
            let by_xml = again(read, &xml);
            assert!(same(form, by_xml.profile.form()), "{}:\n{xml}", read.file);
        }
    }
}

/// What 0.2 → 0.1 → 0.2 loses is what the errors name.
#[test]
fn what_the_old_version_loses_is_named() {
    let (Some(rts), Some(derived)) = (files("rts"), files("derived")) else {
        return;
    };
    let mut whole = 0;
    let mut lost = String::new();
    for (file, bytes) in rts.iter().chain(&derived) {
        let named = only_what_is_named_is_lost(file, bytes);
        whole += usize::from(named.is_empty());
        for message in named {
            writeln!(lost, "{file}: {message}").unwrap();
        }
    }
    println!("{whole} profiles come back whole");
    assert!(whole > 60, "{whole}");
    insta::assert_snapshot!("lost_and_named", lost);
}

#[test]
fn a_document_without_an_edit_has_the_same_bytes() {
    let Some((all, _)) = corpus() else { return };
    for read in all.iter().filter(|read| read.format == Format::Xml) {
        let document = Document::open(&read.file, &read.bytes).unwrap();
        assert!(document.bytes().unwrap() == read.bytes, "{}", read.file);
        let same = read.profile.patch(&document, &read.profile).unwrap();
        assert!(same.bytes().unwrap() == read.bytes, "{}", read.file);
    }
}

/// One edit changes what was edited and no other line.
#[test]
fn an_edit_touches_no_other_line() {
    let Some((all, _)) = corpus() else { return };
    let mut edits = 0;
    for (number, read) in all
        .iter()
        .enumerate()
        .filter(|(_, read)| read.format == Format::Xml)
    {
        let document = Document::open(&read.file, &read.bytes).unwrap();
        for round in 0..12_u8 {
            let seed = u32::try_from(number).unwrap() * 31 + u32::from(round);
            let mut new = read.profile.clone();
            edit(new.form_mut(), &mut Tape::new(&tape(seed)));
            if same(new.form(), read.profile.form()) {
                continue;
            }
            edits += 1;
            let patched = read.profile.patch(&document, &new).unwrap();
            let bytes = patched.bytes().unwrap();
            let read_again = match read.profile {
                Any::Rts(_) => read_rts(&read.file, &bytes),
                Any::Rtc(_) => read_rtc(&read.file, &bytes),
            };
            let mut by_file = read_again.unwrap().profile;
            let mut expected = new.clone();
            strip_places(by_file.form_mut());
            strip_places(expected.form_mut());
            assert!(same(by_file.form(), expected.form()), "{}", read.file);
            assert_one_region(&read.file, document.text(), patched.text());
        }
    }
    println!("{edits} edits");
    assert!(edits > 1000, "{edits}");
}

/// The lines that differ are one region, and it is not the whole file.
fn assert_one_region(file: &str, old: &str, new: &str) {
    let (old, new): (Vec<&str>, Vec<&str>) = (
        old.split_inclusive('\n').collect(),
        new.split_inclusive('\n').collect(),
    );
    let before = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
    let left = old.len().min(new.len()) - before;
    let after = old.iter().rev().zip(new.iter().rev()).take(left);
    let after = after.take_while(|(a, b)| a == b).count();
    let touched = old.len() - before - after;
    let added = new.len() - before - after;
    // A change is in one line (or that of a tag); what is removed or added is whole.
    assert!(
        touched <= 2 || added <= 2,
        "{file}: {touched} lines became {added}"
    );
}
