//! Text → keys and values, as `coil::Properties` of OpenRTM-aist reads them.

use std::collections::HashMap;

use super::decode::decode;
use crate::diagnostic::{Finding, Place, Report, Severity, Source};
use crate::span::{Span, Text};

/// Most entries of one file. Real files have less than a hundred.
const ENTRIES: usize = 10_000;

/// Most findings of one code in a file; the rest is counted.
const FINDINGS: usize = 50;

/// A configuration file as it is written.
#[derive(Debug, Clone)]
pub struct Conf {
    /// The decoded text.
    pub source: Source,
    /// Name of the encoding that was found (`UTF-8`).
    pub encoding: &'static str,
    /// Keys and values, in the order of the file. A key that is given twice is in it once, with its last value.
    pub entries: Vec<Entry>,
    /// What was noticed while reading.
    pub findings: Report,
}

/// A key and its value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// The key.
    pub key: Text,
    /// The value, without escapes.
    pub value: String,
    /// The value with its backslashes, if it has any: what is a path may be one of Windows.
    raw: Option<String>,
    /// From which offset in the value on it stands where in the file.
    runs: Vec<(u32, u32)>,
}

impl Entry {
    /// The place of a part of the value.
    pub fn span(&self, start: usize, end: usize) -> Span {
        let from = self.offset(start);
        // The part may go over several lines: of it the first is shown.
        let to = self.offset(end.saturating_sub(1).max(start)) + 1;
        Span::new(from, to.max(from + 1))
    }

    /// The whole value, with its place.
    pub fn text(&self) -> Text {
        Text::new(self.value.clone(), self.span(0, self.value.len()))
    }

    /// The value as paths are written in it: backslashes stay, as slashes.
    pub fn path(&self) -> String {
        let raw = self.raw.as_ref().unwrap_or(&self.value);
        raw.replace('\\', "/")
    }

    fn offset(&self, at: usize) -> usize {
        let run = self
            .runs
            .partition_point(|(start, _)| *start as usize <= at);
        match self.runs.get(run.saturating_sub(1)) {
            Some((start, source)) => *source as usize + at.saturating_sub(*start as usize),
            None => self.key.span.range().start,
        }
    }
}

impl Conf {
    /// The place of a range.
    pub fn place(&self, span: Span) -> Option<Place> {
        (!span.is_unknown()).then(|| self.source.place(span.start, span.end))
    }

    /// True for the configuration file of one component, which makes nothing: `conf.SET.KEY` and nothing of a manager.
    pub fn is_of_a_component(&self) -> bool {
        let has = |start: &str| {
            self.entries
                .iter()
                .any(|entry| entry.key.value.starts_with(start))
        };
        has("conf.") && !has("manager.") && !has("corba.")
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key.value == key)
    }
}

/// Reads a configuration file.
///
/// # Errors
/// A report with one error when it cannot be read at all: size, or no text.
pub fn read(file_name: &str, bytes: &[u8]) -> Result<Conf, Report> {
    let alone = |finding| Report {
        findings: vec![finding],
    };
    let (text, encoding) = decode(file_name, bytes).map_err(|finding| alone(*finding))?;
    let source = Source::new(file_name, text);
    let mut reader = Reader::new(&source);
    reader.lines();
    if reader.entries.len() > ENTRIES {
        let message = format!("{file_name} has more than {ENTRIES} entries");
        let finding = Finding::error("too-large", message);
        return Err(alone(finding.help("is this the right file?")));
    }
    let (entries, mut findings) = (reader.entries, reader.findings);
    findings.sort_by_place();
    Ok(Conf {
        entries,
        findings,
        encoding,
        source,
    })
}

/// One logical line: its text, and where its pieces stand in the file.
#[derive(Default)]
struct Line {
    text: String,
    pieces: Vec<(usize, usize)>,
}

impl Line {
    fn source(&self, at: usize) -> usize {
        let piece = self.pieces.partition_point(|(start, _)| *start <= at);
        let piece = self.pieces.get(piece.saturating_sub(1));
        piece.map_or(0, |(start, source)| source + (at - start))
    }
}

struct Reader<'a> {
    source: &'a Source,
    entries: Vec<Entry>,
    index: HashMap<String, usize>,
    findings: Report,
    counts: HashMap<&'static str, usize>,
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source) -> Self {
        Self {
            source,
            entries: Vec::new(),
            index: HashMap::new(),
            findings: Report::default(),
            counts: HashMap::new(),
        }
    }

    fn lines(&mut self) {
        let text = self.source.text();
        let mut line = Line::default();
        let mut at = 0;
        for physical in text.split(['\n', '\r']) {
            let start = at;
            at += physical.len() + 1;
            let rest = physical.trim_start_matches([' ', '\t']);
            let from = start + physical.len() - rest.len();
            // In a line that goes on, too.
            if rest.is_empty() || rest.starts_with(['#', '!']) {
                continue;
            }
            line.pieces.push((line.text.len(), from));
            let last = rest.len() - 1;
            if rest.ends_with('\\') && !is_escaped(rest, last) {
                line.text.push_str(&rest[..last]);
                continue;
            }
            line.text.push_str(rest);
            self.entry(&std::mem::take(&mut line));
            if self.entries.len() > ENTRIES {
                return;
            }
        }
        if !line.text.trim().is_empty() {
            let end = line.source(line.text.len().saturating_sub(1));
            let message = "the file ends in a line that is to go on";
            let help = "OpenRTM-aist does not read such a line: take the last `\\` away";
            self.warn(
                "conf-dangling-continuation",
                message.into(),
                Span::new(end, end + 1),
                help,
            );
            self.entry(&line);
        }
    }

    fn entry(&mut self, line: &Line) {
        let text = line.text.as_str();
        let unescaped = |wanted: &[char]| {
            let mut found = text.char_indices().filter(|(_, c)| wanted.contains(c));
            found
                .find(|(at, _)| !is_escaped(text, *at))
                .map(|(at, _)| at)
        };
        let marked = unescaped(&[':', '=']);
        let at = marked.or_else(|| unescaped(&[' '])).unwrap_or(text.len());
        let key_text = text[..at].trim();
        let start = line.source(text.len() - text.trim_start().len());
        let span = Span::new(start, start + key_text.len().max(1));
        if marked.is_none() {
            let message = format!("there is no `:` behind `{key_text}`");
            let help = "write `key: value`; without it the value begins at the first blank";
            self.warn("conf-no-separator", message, span, help);
        }
        let key = unescape(key_text, |at| at).0.replace(is_unsayable, " ");
        let key = key.trim().to_owned();
        let value_at = (at + 1).min(text.len());
        let value = &text[value_at..];
        let lead = value.len() - value.trim_start().len();
        let raw = value.trim();
        let (mut value, runs) = unescape(raw, |at| line.source(value_at + lead + at));
        if value.contains(is_unsayable) {
            let message = format!("the value of `{key}` has a control character");
            let help = "write `\\\\` for a backslash; the character is left out";
            self.warn("conf-bad-value", message, span, help);
            // One for one: places stay what they are.
            value = value.replace(is_unsayable, " ");
        }
        let entry = Entry {
            key: Text::new(key, span),
            value,
            raw: raw.contains('\\').then(|| raw.to_owned()),
            runs,
        };
        match self.index.get(&entry.key.value).copied() {
            Some(old) => self.again(old, entry),
            None => {
                self.index
                    .insert(entry.key.value.clone(), self.entries.len());
                self.entries.push(entry);
            }
        }
    }

    fn again(&mut self, old: usize, entry: Entry) {
        let before = std::mem::replace(&mut self.entries[old], entry);
        let span = before.key.span;
        let line = self.source.place(span.start, span.end).line;
        let key = &self.entries[old].key;
        let message = format!("`{}` is given again, after line {line}", key.value);
        let span = key.span;
        let help = "the last value counts: take the other away";
        self.warn("conf-repeated-key", message, span, help);
    }

    fn warn(&mut self, code: &'static str, message: String, span: Span, help: &str) {
        let count = self.counts.entry(code).or_default();
        *count += 1;
        if *count <= FINDINGS {
            let place = Some(self.source.place(span.start, span.end));
            let finding = Finding::new(Severity::Warning, code, message);
            self.findings.push(finding.at(place).help(help));
        }
    }
}

/// A control character, which a profile cannot hold; each is one byte.
fn is_unsayable(c: char) -> bool {
    c.is_ascii_control() && !matches!(c, '\t' | '\n' | '\r')
}

/// True if an odd number of backslashes stands before it.
fn is_escaped(text: &str, at: usize) -> bool {
    let before = text[..at].bytes().rev().take_while(|b| *b == b'\\');
    before.count() % 2 == 1
}

/// The text without escapes, and from which offset on it stands where.
fn unescape(text: &str, source: impl Fn(usize) -> usize) -> (String, Vec<(u32, u32)>) {
    let mut plain = String::with_capacity(text.len());
    let mut runs: Vec<(u32, u32)> = Vec::new();
    let mut note = |plain: usize, at: usize| {
        let (plain, at) = (plain as u32, source(at) as u32);
        let goes_on = runs
            .last()
            .is_some_and(|(p, a)| plain - p == at.wrapping_sub(*a));
        if !goes_on {
            runs.push((plain, at));
        }
    };
    let mut chars = text.char_indices();
    while let Some((at, c)) = chars.next() {
        note(plain.len(), at);
        let escaped = (c == '\\').then(|| chars.next()).flatten();
        plain.push(match escaped {
            None => c,
            Some((_, 't')) => '\t',
            Some((_, 'n')) => '\n',
            Some((_, 'f')) => '\u{c}',
            Some((_, 'r')) => '\r',
            Some((_, c)) => c,
        });
    }
    (plain, runs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(text: &str) -> Vec<(String, String)> {
        let conf = read("rtc.conf", text.as_bytes()).unwrap();
        conf.entries
            .into_iter()
            .map(|e| (e.key.value, e.value))
            .collect()
    }

    fn pair(key: &str, value: &str) -> (String, String) {
        (key.to_owned(), value.to_owned())
    }

    #[test]
    fn lines_are_read_as_openrtm_reads_them() {
        let text =
            "# comment\n! comment\n\n a.b: c d \r\ne=f:g\nUser Interface.x.config_file:y\nempty:\n";
        assert_eq!(
            entries(text),
            [
                pair("a.b", "c d"),
                pair("e", "f:g"),
                pair("User Interface.x.config_file", "y"),
                pair("empty", "")
            ]
        );
        assert_eq!(
            entries("a: 1, \\\n   # in between\n\n   2,\\\n\t3\nb: 4\n"),
            [pair("a", "1, 2,3"), pair("b", "4")]
        );
        assert_eq!(
            entries("a\\:b: c\\\\\nd: e\\tf\n"),
            [pair("a:b", "c\\"), pair("d", "e\tf")]
        );
    }

    #[test]
    fn oddities_are_warnings_with_their_place() {
        let conf = read("rtc.conf", b"a: 1\nb c d\na: 2\ne: f \\").unwrap();
        let said: Vec<_> = conf
            .findings
            .findings
            .iter()
            .map(|f| {
                let place = f.place.as_ref().unwrap();
                (f.code.as_str(), place.line, place.column)
            })
            .collect();
        assert_eq!(
            said,
            [
                ("conf-no-separator", 2, 1),
                ("conf-repeated-key", 3, 1),
                ("conf-dangling-continuation", 4, 5)
            ]
        );
        assert_eq!(conf.get("a").unwrap().value, "2");
        assert_eq!(conf.get("b").unwrap().value, "c d");
        assert_eq!(conf.get("e").unwrap().value, "f");
    }

    #[test]
    fn a_part_of_a_value_is_found_in_its_line() {
        let text = "list: one, \\\n  two, \\\n  th\\:ree\n";
        let conf = read("rtc.conf", text.as_bytes()).unwrap();
        let entry = conf.get("list").unwrap();
        assert_eq!(entry.value, "one, two, th:ree");
        for word in ["one", "two", "th", ":ree"] {
            let at = entry.value.find(word).unwrap();
            let span = entry.span(at, at + word.len());
            let place = conf.place(span).unwrap();
            let line = text.lines().nth(place.line - 1).unwrap();
            let column = line
                .find(if word == ":ree" { "\\:ree" } else { word })
                .unwrap()
                + 1;
            assert_eq!(place.column, column, "{word}");
        }
    }

    #[test]
    fn paths_keep_their_backslashes() {
        let conf = read("rtc.conf", b"x: conf\\new.conf").unwrap();
        assert_eq!(conf.entries[0].path(), "conf/new.conf");
        assert_eq!(conf.entries[0].value, "conf\new.conf");
        let conf = read("rtc.conf", b"x: conf\\foo.conf").unwrap();
        assert_eq!(conf.entries[0].path(), "conf/foo.conf");
        assert_eq!(conf.entries[0].value, "conf oo.conf");
        assert_eq!(conf.findings.findings[0].code, "conf-bad-value");
    }

    #[test]
    fn too_many_entries_are_refused() {
        let many = (0..=ENTRIES).fold(String::new(), |text, n| text + &format!("k{n}\n"));
        assert_eq!(
            read("rtc.conf", many.as_bytes()).unwrap_err().findings[0].code,
            "too-large"
        );
    }
}
