//! The laws of forms, on generated profiles.

#![allow(clippy::unwrap_used)] // A failure here is a failed test.

mod forms;

use forms::{Tape, edit, fill};
use proptest::prelude::*;
use rts_schemas::diagnostic::{Report, Source};
use rts_schemas::form::{
    Around, Form, Format, Vocabulary, format, open, patch, same, strip_places,
};
use rts_schemas::rtc_profile::forms::RtcProfile;
use rts_schemas::rts_profile::forms::{Profile, v01};
use rts_schemas::xml::Document;
use rts_schemas::{rtc_profile, rts_profile};

fn read<F: Form + Default>(text: &str, words: &'static Vocabulary) -> (F, Around, Report) {
    let opened =
        open("f", text.as_bytes(), words).unwrap_or_else(|report| panic!("{report:?}\n{text}"));
    let mut form = F::default();
    let mut report = opened.findings;
    let source: &Source = &opened.source;
    let (_, around) = opened.tree.fill(&mut form, words, source, &mut report);
    (form, around, report)
}

fn made<F: Form + Default>(tape: &[u8]) -> F {
    let mut form = F::default();
    fill(&mut form, &mut Tape::new(tape), 4);
    form
}

/// XML and YAML give back the form, and what is written is written the same again.
fn round<F: Form + Default + Clone + PartialEq>(tape: &[u8], words: &'static Vocabulary) {
    let form: F = made(tape);
    let nothing = Around::default();
    let xml = format(&form, &nothing, words, Format::Xml);
    let (mut by_xml, around, report) = read::<F>(&xml, words);
    assert_eq!(report, Report::default(), "{xml}");
    assert!(same(&form, &by_xml), "{xml}");
    assert_eq!(format(&by_xml, &around, words, Format::Xml), xml);
    let yaml = format(&by_xml, &nothing, words, Format::Yaml);
    let (mut by_yaml, _, report) = read::<F>(&yaml, words);
    assert_eq!(report, Report::default(), "{yaml}");
    assert!(same(&form, &by_yaml), "{yaml}");
    assert_eq!(format(&by_yaml, &nothing, words, Format::Yaml), yaml);
    strip_places(&mut by_xml);
    strip_places(&mut by_yaml);
    let xml_again = format(&by_yaml, &nothing, words, Format::Xml);
    assert_eq!(xml_again, xml);
}

/// An edit of what was read is written into the text, and read again.
fn edited<F: Form + Default + Clone>(tape: &[u8], change: &[u8], words: &'static Vocabulary) {
    let text = format(&made::<F>(tape), &Around::default(), words, Format::Xml);
    let document = Document::open("f.xml", text.as_bytes()).unwrap();
    let (old, ..) = read::<F>(&text, words);
    let mut new = old.clone();
    edit(&mut new, &mut Tape::new(change));
    let patched = patch(&document, &old, &new, words)
        .unwrap_or_else(|error| panic!("{error}\n{text}\n{new:?}"));
    let (by_text, ..) = read::<F>(patched.text(), words);
    assert!(same(&by_text, &new), "{}", patched.text());
    if same(&old, &new) {
        assert_eq!(patched.text(), text);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rts_profiles_are_kept(tape in prop::collection::vec(any::<u8>(), 0..600)) {
        round::<Profile>(&tape, &rts_profile::forms::WORDS);
    }

    #[test]
    fn rtc_profiles_are_kept(tape in prop::collection::vec(any::<u8>(), 0..600)) {
        round::<RtcProfile>(&tape, &rtc_profile::forms::WORDS);
    }

    #[test]
    fn rts_profiles_are_edited(
        tape in prop::collection::vec(any::<u8>(), 0..600),
        change in prop::collection::vec(any::<u8>(), 0..120),
    ) {
        edited::<Profile>(&tape, &change, &rts_profile::forms::WORDS);
        edited::<v01::Profile>(&tape, &change, &rts_profile::forms::WORDS);
    }

    #[test]
    fn rtc_profiles_are_edited(
        tape in prop::collection::vec(any::<u8>(), 0..600),
        change in prop::collection::vec(any::<u8>(), 0..120),
    ) {
        edited::<RtcProfile>(&tape, &change, &rtc_profile::forms::WORDS);
    }
}
