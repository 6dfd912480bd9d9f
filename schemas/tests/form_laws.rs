//! The laws of forms, on generated profiles.

#![allow(clippy::unwrap_used)] // A failure here is a failed test.

mod forms;

use forms::changes::{Change, assert_untouched, change, instances, moved, rename, stands_twice};
use forms::noise::{scribble, spoil};
use forms::versions::{self, only_what_is_named_is_lost};
use forms::{Tape, bare, edit, fill, loose};
use proptest::prelude::*;
use rts_schemas::diagnostic::{Report, Source};
use rts_schemas::form::{
    Around, Form, Format, Vocabulary, format, open, patch, same, strip_places,
};
use rts_schemas::rtc_profile::forms::RtcProfile;
use rts_schemas::rts_profile::forms::{Profile, v01};
use rts_schemas::xml::document::{EditError, Part};
use rts_schemas::xml::{Document, parse_tree};
use rts_schemas::{rtc_profile, rts_profile, xml};

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

/// A profile with what no type knows at every place, in any layout.
fn noisy<F: Form + Default>(tape: &[u8], noise: &[u8], words: &'static Vocabulary) -> String {
    let form: F = made(tape);
    let mut tree = Around::default().tree(&form, words);
    let mut tape = Tape::new(noise);
    spoil(&mut tree, &mut tape);
    scribble(&tree, &mut tape)
}

/// The form alone gives back the whole tree: elements, attributes, texts, comments, instructions, prefixes, and the order.
fn kept<F: Form + Default>(tape: &[u8], noise: &[u8], words: &'static Vocabulary) {
    let text = noisy::<F>(tape, noise, words);
    let Ok(original) = parse_tree(&text) else {
        panic!("{text}")
    };
    let (form, around, _) = read::<F>(&text, words);
    let written = around.tree(&form, words);
    assert_eq!(bare(written), bare(original.clone()), "{text}");
    let printed = format(&form, &around, words, Format::Xml);
    let printed_tree = parse_tree(&printed).unwrap();
    assert_eq!(bare(printed_tree), bare(original), "{text}\n{printed}");
    let (again, around, _) = read::<F>(&printed, words);
    assert!(same(&form, &again), "{text}\n{printed}");
    assert_eq!(format(&again, &around, words, Format::Xml), printed);
    // YAML has no comments, but all values and all that is unknown.
    let yaml = format(&form, &around, words, Format::Yaml);
    let (by_yaml, ..) = read::<F>(&yaml, words);
    assert!(same(&form, &by_yaml), "{text}\n{yaml}");
    let twice = format(&by_yaml, &Around::default(), words, Format::Yaml);
    assert_eq!(twice, yaml);
}

/// After an edit the file is as it was but for the edit, and the form alone writes the same tree as the edited file.
fn changed<F: Form + Default + Clone>(
    text: &str,
    words: &'static Vocabulary,
    edit: impl Fn(&mut F) -> Option<Change>,
) {
    let document = Document::open("f.xml", text.as_bytes()).unwrap();
    let (old, around, _) = read::<F>(text, words);
    let mut new = old.clone();
    let Some(change) = edit(&mut new) else {
        return;
    };
    let patched = match patch(&document, &old, &new, words) {
        // The second one would count.
        Err(EditError::Unfaithful) if stands_twice(&document, &change) => return,
        Err(error) => panic!("{error}\n{change:?}\n{text}"),
        Ok(patched) => patched,
    };
    assert_untouched(&document, patched.text(), &change);
    let by_file = parse_tree(patched.text()).unwrap();
    let by_form = around.tree(&new, words);
    assert_eq!(
        loose(by_form),
        loose(by_file),
        "{change:?}\n{}",
        patched.text()
    );
    // And so does what is printed.
    let printed = format(&new, &around, words, Format::Xml);
    let (again, ..) = read::<F>(&printed, words);
    assert!(same(&again, &new), "{change:?}\n{printed}");
}

fn renamed(text: &str) {
    let words = &rts_profile::forms::WORDS;
    let document = Document::open("f.xml", text.as_bytes()).unwrap();
    let (old, ..) = read::<Profile>(text, words);
    let mut names = Vec::new();
    instances(&old, &mut names);
    let Some(name) = names.first() else { return };
    let mut new = old.clone();
    let count = rename(&mut new, name, "Renamed0");
    assert_eq!(count, names.iter().filter(|other| *other == name).count());
    let patched = patch(&document, &old, &new, words).unwrap();
    let (before, after) = (pieces(&document), pieces(&patched));
    // The text between the values is to the letter the same, and so are all values but these.
    let different = before.iter().zip(&after).filter(|(a, b)| a != b).count();
    assert_eq!((before.len(), different), (after.len(), count), "{text}");
}

/// The text cut at each attribute's quotes.
fn pieces(document: &Document) -> Vec<String> {
    fn cuts(part: &Part, all: &mut Vec<usize>) {
        for attribute in &part.attributes {
            all.extend([attribute.value.start, attribute.value.end]);
        }
        part.children.iter().for_each(|child| cuts(child, all));
    }
    let mut all = vec![0];
    cuts(document.root(), &mut all);
    all.push(document.text().len());
    let piece = |pair: &[usize]| document.text()[pair[0]..pair[1]].to_owned();
    all.windows(2).map(piece).collect()
}

fn tape(length: usize) -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..length)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rts_profiles_keep_what_they_do_not_know(form in tape(400), noise in tape(800)) {
        kept::<Profile>(&form, &noise, &rts_profile::forms::WORDS);
        kept::<v01::Profile>(&form, &noise, &rts_profile::forms::WORDS);
    }

    #[test]
    fn rtc_profiles_keep_what_they_do_not_know(form in tape(400), noise in tape(800)) {
        kept::<RtcProfile>(&form, &noise, &rtc_profile::forms::WORDS);
    }

    #[test]
    fn every_edit_leaves_the_rest_as_it_was(form in tape(400), noise in tape(800), edit in tape(80)) {
        let by_tape = |form: &mut dyn Form| change(form, &mut Tape::new(&edit));
        let rts = &rts_profile::forms::WORDS;
        changed::<Profile>(&noisy::<Profile>(&form, &noise, rts), rts, |form| by_tape(form));
        changed::<v01::Profile>(&noisy::<v01::Profile>(&form, &noise, rts), rts, |form| by_tape(form));
        let rtc = &rtc_profile::forms::WORDS;
        changed::<RtcProfile>(&noisy::<RtcProfile>(&form, &noise, rtc), rtc, |form| by_tape(form));
    }

    #[test]
    fn what_is_moved_is_moved_to_the_letter(form in tape(400), noise in tape(800), edit in tape(20)) {
        let words = &rts_profile::forms::WORDS;
        let text = noisy::<Profile>(&form, &noise, words);
        changed::<Profile>(&text, words, |profile| {
            let (here, tape) = (profile.span.range().start, &mut Tape::new(&edit));
            match tape.choose(3) {
                0 => moved(&mut profile.components, here, tape),
                1 => moved(&mut profile.data_port_connectors, here, tape),
                _ => {
                    let component = profile.components.first_mut()?;
                    let here = component.span.range().start;
                    moved(&mut component.properties, here, tape)
                }
            }
        });
    }

    #[test]
    fn what_the_old_version_loses_is_named(form in tape(900), noise in tape(400)) {
        let words = &rts_profile::forms::WORDS;
        let text = format(&versions::connected(&form), &Around::default(), words, Format::Xml);
        only_what_is_named_is_lost("f", text.as_bytes());
        let mut tree = Around::default().tree(&versions::connected(&form), words);
        spoil(&mut tree, &mut Tape::new(&noise));
        only_what_is_named_is_lost("f", xml::print(&tree).as_bytes());
    }

    #[test]
    fn an_instance_is_renamed_everywhere_and_nothing_else_is(form in tape(600), noise in tape(400)) {
        renamed(&noisy::<Profile>(&form, &noise, &rts_profile::forms::WORDS));
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
