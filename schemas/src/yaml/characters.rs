//! Characters counted from the start of a text → bytes.

/// A cursor that knows both; asked for places that lie near each other it walks little.
pub(super) struct Cursor<'a> {
    text: &'a [u8],
    is_ascii: bool,
    characters: usize,
    bytes: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self {
            text: text.as_bytes(),
            is_ascii: text.is_ascii(),
            characters: 0,
            bytes: 0,
        }
    }

    /// The byte at which a character starts.
    pub(super) fn byte(&mut self, character: usize) -> usize {
        if self.is_ascii {
            return character.min(self.text.len());
        }
        while self.characters < character && self.bytes < self.text.len() {
            self.bytes += 1;
            while self.is_inside() {
                self.bytes += 1;
            }
            self.characters += 1;
        }
        while self.characters > character && self.bytes > 0 {
            self.bytes -= 1;
            while self.bytes > 0 && self.is_inside() {
                self.bytes -= 1;
            }
            self.characters -= 1;
        }
        self.bytes
    }

    /// True within a character.
    fn is_inside(&self) -> bool {
        self.text
            .get(self.bytes)
            .is_some_and(|byte| byte & 0xc0 == 0x80)
    }
}

#[cfg(test)]
mod tests {
    use super::Cursor;

    #[test]
    fn forth_and_back() {
        let text = "a日é😀z";
        let places: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
        let mut cursor = Cursor::new(text);
        for character in [0, 4, 1, 3, 2, 0, 4] {
            assert_eq!(cursor.byte(character), places[character]);
        }
        assert_eq!(cursor.byte(99), text.len());
        assert_eq!(cursor.byte(2), places[2]);
        assert_eq!(Cursor::new("abc").byte(99), 3);
    }
}
