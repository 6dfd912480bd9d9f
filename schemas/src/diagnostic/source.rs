//! The text of a file, and the places of its bytes.

use super::Place;

/// A source text that can turn byte offsets into places.
#[derive(Debug, Clone)]
pub struct Source {
    name: String,
    text: String,
    line_starts: Vec<u32>,
    /// Characters before each [`STEP`] bytes: a file may be one line of 100 MB, and thousands of places in it are shown.
    characters: Vec<u32>,
}

/// Longest piece of a line that a place carries, in characters.
const TEXT_LIMIT: usize = 240;

/// Characters of a long line that are shown before the place.
const BEFORE: usize = 40;

/// Bytes from one count of characters to the next.
const STEP: usize = 4096;

impl Source {
    /// Keeps the text and finds its lines.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        let lines = text.bytes().filter(|b| *b == b'\n').count() + 1;
        let mut line_starts = Vec::with_capacity(lines);
        line_starts.push(0);
        line_starts.extend(text.match_indices('\n').map(|(at, _)| small(at + 1)));
        let mut characters = vec![0];
        let mut count = 0;
        for piece in text.as_bytes().chunks(STEP) {
            count += small(count_characters(piece));
            characters.push(count);
        }
        Self {
            characters,
            name: name.into(),
            text,
            line_starts,
        }
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The name that places show.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The place of a byte range; offsets past the end or inside a character are moved back.
    pub fn place(&self, start: impl TryInto<usize>, end: impl TryInto<usize>) -> Place {
        let start = self
            .text
            .floor_char_boundary(start.try_into().unwrap_or(usize::MAX));
        let end = self
            .text
            .floor_char_boundary(end.try_into().unwrap_or(usize::MAX).max(start));
        let index = self
            .line_starts
            .partition_point(|at| large(*at) <= start)
            .saturating_sub(1);
        let (from, line_end) = self.line(index);
        let (start, end) = (start.min(line_end), end.min(line_end));
        let column = self.characters(from, start) + 1;
        let length = self.characters(start, end).max(1);
        // Of a long line only a piece is walked and shown.
        let (cut_at, skip) = if self.characters(from, line_end) > TEXT_LIMIT {
            let before = self.text[from..start].char_indices().rev();
            let cut = before.take(BEFORE).nth(BEFORE - 1);
            cut.map_or((from, 0), |(at, _)| (from + at, column - 1 - BEFORE))
        } else {
            (from, 0)
        };
        let text: String = self.text[cut_at..line_end]
            .chars()
            .take(TEXT_LIMIT)
            .collect();
        let room = text
            .chars()
            .count()
            .saturating_sub(column - 1 - skip)
            .max(1);
        Place {
            file: self.name.clone(),
            line: index + 1,
            column,
            length: length.min(room),
            text,
            text_column: skip + 1,
        }
    }

    /// The place of a line and column, both from 1.
    pub fn place_at(&self, line: usize, column: usize) -> Place {
        let index = line.saturating_sub(1).min(self.line_starts.len() - 1);
        let (from, end) = self.line(index);
        let offset = self.text[from..end]
            .char_indices()
            .nth(column.saturating_sub(1))
            .map_or(end, |(at, _)| from + at);
        self.place(offset, offset + 1)
    }

    /// Where a line starts and ends, without its line end.
    fn line(&self, index: usize) -> (usize, usize) {
        let start = self.line_starts.get(index).map_or(0, |at| large(*at));
        let next = self.line_starts.get(index + 1);
        let end = next.map_or(self.text.len(), |next| large(*next) - 1);
        match self.text[start..end].ends_with('\r') && next.is_some() {
            true => (start, end - 1),
            false => (start, end),
        }
    }

    /// How many characters lie between two places.
    fn characters(&self, from: usize, to: usize) -> usize {
        let bytes = self.text.as_bytes();
        let until = |at: usize| {
            let piece = at / STEP;
            let walked = bytes.get(piece * STEP..at).unwrap_or_default();
            let before = self.characters.get(piece).map_or(0, |count| large(*count));
            before + count_characters(walked)
        };
        match to - from < STEP {
            true => count_characters(&bytes[from..to]),
            false => until(to) - until(from),
        }
    }
}

fn count_characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte & 0xc0 != 0x80).count()
}

fn small(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}

fn large(at: u32) -> usize {
    usize::try_from(at).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_a_long_line_are_characters() {
        let text = format!("x\r\n{}END\n", "日".repeat(5000));
        let source = Source::new("f", text);
        let at = source.text().find("END").unwrap();
        let place = source.place(at, at + 3);
        assert_eq!((place.line, place.column, place.length), (2, 5001, 3));
        assert_eq!(place.text_column, 4961);
        assert_eq!(place.text, format!("{}END", "日".repeat(40)));
        let again = source.place_at(2, 5001);
        assert_eq!((again.column, again.text), (5001, place.text));
        let first = source.place(0, 9);
        assert_eq!((first.line, first.length, first.text.as_str()), (1, 1, "x"));
    }

    #[test]
    fn a_piece_that_ends_within_a_character_is_counted_once() {
        let text = format!("a{}", "日".repeat(4 * STEP));
        let source = Source::new("f", text);
        for character in [0, 1, STEP / 3, STEP, 2 * STEP + 1, 4 * STEP] {
            let at = source.text().char_indices().nth(character).unwrap().0;
            assert_eq!(source.place(at, at).column, character + 1);
        }
    }
}
