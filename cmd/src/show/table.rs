//! Tables as kubectl prints them: no borders, two spaces between columns, upper-case headers.

use anstyle::{AnsiColor, Style};
use comfy_table::{ContentArrangement, Table as Layout, presets};

/// A table: headers and rows of the same length.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// Upper-case headers.
    pub headers: Vec<&'static str>,
    /// Rows.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(headers: &[&'static str]) -> Self {
        Self {
            headers: headers.to_vec(),
            rows: Vec::new(),
        }
    }

    /// Adds a row; an empty cell becomes `-`.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let cells = cells.into_iter().map(|cell| {
            let cell = cell.replace(['\n', '\t'], " ");
            if cell.is_empty() {
                "-".to_owned()
            } else {
                cell
            }
        });
        self.rows.push(cells.collect());
    }

    /// The text, each line ended.
    pub fn render(&self, headers: bool, color: bool) -> String {
        let mut layout = Layout::new();
        layout
            .load_style(presets::NOTHING)
            .set_content_arrangement(ContentArrangement::Disabled)
            .set_header(self.headers.clone())
            .add_rows(self.rows.clone());
        for column in layout.column_iter_mut() {
            column.set_padding((0, 2));
        }
        let text = layout.trim_fmt();
        let state = if color {
            self.column_at(&text, "STATE")
        } else {
            None
        };
        let mut out = String::with_capacity(text.len());
        for (index, line) in text.lines().enumerate() {
            match state {
                _ if index == 0 && !headers => continue,
                Some(at) if index > 0 => out.push_str(&colored(line, at)),
                _ => out.push_str(line),
            }
            out.push('\n');
        }
        out
    }

    /// Where a column begins, in characters.
    fn column_at(&self, text: &str, header: &str) -> Option<usize> {
        self.headers.iter().find(|h| **h == header)?;
        let first = format!("{}  ", text.lines().next()?);
        let at = first.find(&format!(" {header} "))? + 1;
        Some(first[..at].chars().count())
    }
}

/// The line with the word at a column in the colour that the RT System Editor gives to that state.
fn colored(line: &str, column: usize) -> String {
    let start = line
        .char_indices()
        .nth(column)
        .map_or(line.len(), |(at, _)| at);
    let end = line[start..].find(' ').map_or(line.len(), |at| start + at);
    let word = &line[start..end];
    let style = style_of(word);
    format!("{}{style}{word}{style:#}{}", &line[..start], &line[end..])
}

fn style_of(state: &str) -> Style {
    match state {
        "Created" => AnsiColor::White.on_default(),
        "Inactive" => AnsiColor::Blue.on_default(),
        "Active" | "Connected" | "Ready" => AnsiColor::BrightGreen.on_default(),
        "Error" | "Disconnected" | "NotReady" | "Unresponsive" => AnsiColor::Red.on_default(),
        // Black cannot be seen on a dark terminal.
        "Unknown" => AnsiColor::BrightBlack.on_default(),
        _ => Style::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new(&["NAME", "STATE", "AGE"]);
        table.row(["Sine0", "Active", "5s"].map(str::to_owned));
        table.row(["P", "", "-"].map(str::to_owned));
        table
    }

    #[test]
    fn columns_are_two_spaces_apart_and_lines_end_without_blanks() {
        assert_eq!(
            table().render(true, false),
            "NAME   STATE   AGE\nSine0  Active  5s\nP      -       -\n"
        );
        assert_eq!(
            table().render(false, false),
            "Sine0  Active  5s\nP      -       -\n"
        );
    }

    #[test]
    fn only_the_word_of_the_state_is_coloured() {
        let text = table().render(false, true);
        let line = text.lines().next().unwrap();
        assert_eq!(line, "Sine0  \u{1b}[92mActive\u{1b}[0m  5s");
    }
}
