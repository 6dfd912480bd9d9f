//! A profile in canonical form, printed from the typed model alone; nothing that the file says is lost, or it is refused.
//!
//! One element or key a line, indented, in UTF-8 without byte order mark, lines ending in `\n`. In XML the order of
//! elements, attributes and comments, and the prefixes, are those of the file; in YAML the keys stand in the order of the
//! schema.

mod equal;

use crate::diagnostic::{Finding, Place, Report, Source};
use crate::form::{Around, Form, Format, Vocabulary, format, same};
use crate::span::Text;
use crate::{rtc_profile, rts_profile, xml, yaml};

/// A profile and its canonical text.
#[derive(Debug, Clone)]
pub struct Canonical {
    /// What it is: `RTS Profile`, `RTC Profile`.
    pub title: &'static str,
    /// XML or YAML.
    pub format: Format,
    /// The text that was read.
    pub source: Source,
    /// Name of the encoding that it was read in; what is written is UTF-8.
    pub encoding: &'static str,
    /// The canonical text.
    pub text: String,
}

/// A profile of either kind as it was read.
struct Profile {
    title: &'static str,
    source: Source,
    encoding: &'static str,
    findings: Report,
    format: Format,
    around: Around,
    form: Box<dyn Form>,
    words: &'static Vocabulary,
}

/// Brings a profile into canonical form; which kind it is, is seen from the content.
///
/// # Errors
/// A report with an error when the file cannot be read, or holds what the form has no place for: then it must stay as it is.
pub fn canonical(file_name: &str, bytes: &[u8]) -> Result<Canonical, Report> {
    let read = read(file_name, bytes)?;
    // What is wrong in the wrong shape was not read, so it would be lost.
    if read.findings.has_errors() {
        return Err(read.findings);
    }
    if read.format == Format::Yaml
        && let Some(place) = yaml::first_comment(&read.source)
    {
        return Err(comments_would_be_lost(place));
    }
    if let Some(finding) = beside_the_profile(&read) {
        return Err(alone(finding));
    }
    let text = format(&*read.form, &read.around, read.words, read.format);
    match unfaithful(&read, &text) {
        None => Ok(Canonical {
            title: read.title,
            format: read.format,
            source: read.source,
            encoding: read.encoding,
            text,
        }),
        Some(what) => Err(not_kept(file_name, what)),
    }
}

/// Reads an RTS Profile, or else an RTC Profile.
fn read(file_name: &str, bytes: &[u8]) -> Result<Profile, Report> {
    let is_other = |report: &Report| report.findings.iter().any(|f| f.code == "wrong-root");
    match rts_profile::read(file_name, bytes) {
        Ok(read) => Ok(Profile {
            title: rts_profile::forms::WORDS.title,
            source: read.source,
            encoding: read.encoding,
            findings: read.findings,
            format: read.format,
            around: read.around,
            form: match read.shape {
                rts_profile::forms::Shape::V02(profile) => profile,
                rts_profile::forms::Shape::V01(profile) => profile,
            },
            words: &rts_profile::forms::WORDS,
        }),
        Err(report) if is_other(&report) => match rtc_profile::read(file_name, bytes) {
            Ok(read) => Ok(Profile {
                title: rtc_profile::forms::WORDS.title,
                source: read.source,
                encoding: read.encoding,
                findings: read.findings,
                format: read.format,
                around: read.around,
                form: Box::new(read.profile),
                words: &rtc_profile::forms::WORDS,
            }),
            Err(other) if is_other(&other) => Err(no_profile(report)),
            Err(other) => Err(other),
        },
        Err(report) => Err(report),
    }
}

/// What the text does not say as the file does; nothing when all is kept.
fn unfaithful(read: &Profile, text: &str) -> Option<String> {
    if read.format == Format::Xml {
        let trees = (xml::parse_tree(read.source.text()), xml::parse_tree(text));
        let (Ok(old), Ok(new)) = trees else {
            return Some("the text would not be well-formed".to_owned());
        };
        if let Some(what) = equal::difference(&old, &new) {
            return Some(what);
        }
    }
    let Ok(again) = self::read("", text.as_bytes()) else {
        return Some("it could not be read again".to_owned());
    };
    let kept = same(&*read.form, &*again.form);
    let twice = format(&*again.form, &again.around, again.words, again.format);
    match (kept, twice == text) {
        (true, true) => None,
        (false, _) => Some("some of its values would be other ones".to_owned()),
        (true, false) => Some("it would be written differently each time".to_owned()),
    }
}

fn not_kept(file_name: &str, what: String) -> Report {
    let message = format!("{file_name} cannot be written in canonical form: {what}");
    let help = "the file stays as it is; please report it, with the file";
    alone(Finding::error("not-canonical", message).help(help))
}

fn comments_would_be_lost(place: Place) -> Report {
    let message = "canonical YAML has no comments, and this file has some: they would be lost";
    let help = "remove them, put them into `comment:` keys, or keep the profile as XML, whose comments stay";
    alone(
        Finding::error("comments-in-yaml", message)
            .at(Some(place))
            .help(help),
    )
}

/// What stands beside the root key of YAML, which no form holds.
fn beside_the_profile(read: &Profile) -> Option<Finding> {
    if read.format == Format::Xml {
        return None;
    }
    let root = yaml::parse(&read.source).ok()?;
    let beside = |(key, _): &&(Text, yaml::Node)| key.value != read.words.key;
    let (key, _) = root.entries().iter().find(beside)?;
    let message = format!(
        "`{}` stands beside `{}:`, and would be lost",
        key.value, read.words.key
    );
    let place = read.source.place(key.span.start, key.span.end);
    let place = (!key.span.is_unknown()).then_some(place);
    let finding = Finding::error("not-canonical", message).at(place);
    Some(finding.help("remove it, or move it into the profile"))
}

/// An overlay is written by hand: its comments and its order are part of it.
fn no_profile(mut report: Report) -> Report {
    for finding in &mut report.findings {
        let is_overlay = |help: &String| help.contains("overlay");
        if finding.help.as_ref().is_some_and(is_overlay) {
            finding.message = "a deployment overlay has no canonical form".to_owned();
            finding.help = Some(
                "it stays as it was written, with its comments; RTS and RTC Profiles are formatted"
                    .to_owned(),
            );
        } else if finding.code == "wrong-root" {
            let help = "name an RTS Profile (`rts:RtsProfile`, `rtsProfile:`) or an RTC Profile (`rtc:RtcProfile`, `rtcProfile:`)";
            finding.message = finding
                .message
                .replace("an RTS Profile", "an RTS Profile or RTC Profile");
            finding.help = Some(help.to_owned());
        }
    }
    report
}

fn alone(finding: Finding) -> Report {
    Report {
        findings: vec![finding],
    }
}
