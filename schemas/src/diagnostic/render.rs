//! A finding as plain text, the way a compiler shows it. Colour is for the terminal's program to add.

use std::fmt::Write as _;

use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

use super::{Finding, Place, Severity};

/// Columns of the shown line, so that a finding fits a terminal.
const WIDTH: usize = 100;

/// Columns shown before the place when the line is cut there.
const BEFORE: usize = 30;

/// Blanks that a tab is shown as.
const TAB: &str = "    ";

/// Renders a finding; the last line has no newline.
///
/// ```text
/// error[unknown-port]: component `Filter0` has no port `ot`
///   --> system.xml:52:84
///    |
/// 52 |         <rts:sourceDataPort rts:portName="Filter0.ot" …
///    |                                           ^^^^^^^^^^
///    = help: did you mean `out`? declared: in, out
/// ```
pub fn render(finding: &Finding) -> String {
    let severity = match finding.severity {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    };
    let mut out = format!(
        "{severity}[{}]: {}",
        finding.code,
        visible(&finding.message)
    );
    let margin = match &finding.place {
        Some(place) => snippet(place, &mut out),
        None => 1,
    };
    if let Some(help) = &finding.help {
        let indent = " ".repeat(margin + 1);
        let _ = write!(out, "\n{indent}= help: {}", visible(help));
    }
    out
}

/// Appends the place; returns the width of the line number.
fn snippet(place: &Place, out: &mut String) -> usize {
    let number = place.line.to_string();
    let margin = number.len();
    let blank = " ".repeat(margin);
    let (line, column, length) = window(place);
    let _ = write!(
        out,
        "\n{blank}--> {}:{}:{}\n{blank} |\n{number} | {line}\n{blank} | {}{}",
        visible(&place.file),
        place.line,
        place.column,
        " ".repeat(column),
        "^".repeat(length.max(1)),
    );
    margin
}

/// The part of the line to show, and where in it the marks go, in terminal columns.
fn window(place: &Place) -> (String, usize, usize) {
    let at = place.column.saturating_sub(place.text_column);
    let chars: Vec<char> = place.text.chars().collect();
    let at = at.min(chars.len());
    let end = at.saturating_add(place.length).min(chars.len());
    let columns = |from: usize, to: usize| -> usize {
        chars[from..to].iter().map(|c| shown(*c).width()).sum()
    };

    let mut first = 0;
    if columns(0, end) > WIDTH {
        first = at;
        while first > 0 && columns(first - 1, at) <= BEFORE {
            first -= 1;
        }
    }
    let cut_before = place.text_column > 1 || first > 0;
    let mut last = first;
    let mut width = 0;
    while last < chars.len() && width + shown(chars[last]).width() <= WIDTH {
        width += shown(chars[last]).width();
        last += 1;
    }
    let (lead, tail) = (
        if cut_before { "…" } else { "" },
        if last < chars.len() { "…" } else { "" },
    );
    let body: String = chars[first..last].iter().map(|c| shown(*c)).collect();
    let column = lead.width() + columns(first, at);
    let marks = columns(at, end.clamp(at, last.max(at)));
    (
        format!("{lead}{body}{tail}").trim_end().to_owned(),
        column,
        marks,
    )
}

/// One character as a terminal may show it: tabs as blanks, control characters by their pictures.
fn shown(c: char) -> String {
    match c {
        '\t' => TAB.to_owned(),
        '\u{0}'..='\u{1f}' => char::from_u32(0x2400 + u32::from(c))
            .unwrap_or('?')
            .to_string(),
        c if c.width().is_none() => char::REPLACEMENT_CHARACTER.to_string(),
        c => c.to_string(),
    }
}

/// A text from a file must not send escape codes to a terminal.
fn visible(text: &str) -> String {
    text.chars().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::Source;

    fn at(text: &str, word: &str) -> String {
        let start = text.find(word).unwrap();
        let place = Source::new("f.xml", text).place(start, start + word.len());
        render(
            &Finding::error("code", "message")
                .at(Some(place))
                .help("mend it"),
        )
    }

    #[test]
    fn plain() {
        insta::assert_snapshot!(at("one\n  two three\n", "three"), @r"
        error[code]: message
         --> f.xml:2:7
          |
        2 |   two three
          |       ^^^^^
          = help: mend it
        ");
        insta::assert_snapshot!(render(&Finding::warning("code", "message").help("mend it")), @r"
        warning[code]: message
          = help: mend it
        ");
    }

    #[test]
    fn wide_characters_and_tabs_keep_the_marks_below() {
        insta::assert_snapshot!(at("\t日本語 <x>カメラ</x>", "カメラ"), @r"
        error[code]: message
         --> f.xml:1:9
          |
        1 |     日本語 <x>カメラ</x>
          |               ^^^^^^
          = help: mend it
        ");
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let long = format!("{}HERE{}", "abcdefghi ".repeat(30), " klmnopqrs".repeat(30));
        insta::assert_snapshot!(at(&long, "HERE"), @r"
        error[code]: message
         --> f.xml:1:301
          |
        1 | …abcdefghi abcdefghi abcdefghi abcdefghi HERE klmnopqrs klmnopqrs klmnopqrs klmnopqrs klmnopqrs klmno…
          |                                          ^^^^
          = help: mend it
        ");
    }

    #[test]
    fn escape_codes_are_pictures() {
        assert!(!at("a\u{1b}[31mred", "red").contains('\u{1b}'));
    }
}
