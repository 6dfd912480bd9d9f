//! Lists: values parted by commas, but not inside brackets.

use super::entries::Entry;
use crate::span::Text;

/// Most items of one list.
const ITEMS: usize = 1000;

/// The items of a value, without blanks around them; empty ones are left out. The second is true if there are too many.
pub(super) fn items(entry: &Entry) -> (Vec<Text>, bool) {
    let mut items = Vec::new();
    for (start, end) in ranges(&entry.value) {
        if items.len() == ITEMS {
            return (items, true);
        }
        items.push(Text::new(&entry.value[start..end], entry.span(start, end)));
    }
    (items, false)
}

fn ranges(value: &str) -> impl Iterator<Item = (usize, usize)> {
    let opened = value.chars().filter(|c| "([{".contains(*c)).count();
    let closed = value.chars().filter(|c| ")]}".contains(*c)).count();
    // Brackets that do not match are letters.
    let brackets = opened == closed;
    let mut depth = 0_usize;
    let mut from = 0;
    let mut chars = value.char_indices();
    let mut ended = false;
    std::iter::from_fn(move || {
        while !ended {
            let (at, next) = match chars.next() {
                Some((at, c)) => {
                    match c {
                        '(' | '[' | '{' if brackets => depth += 1,
                        ')' | ']' | '}' if brackets => depth = depth.saturating_sub(1),
                        _ => {}
                    }
                    if c != ',' || depth > 0 {
                        continue;
                    }
                    (at, at + 1)
                }
                None => {
                    ended = true;
                    (value.len(), value.len())
                }
            };
            let piece = &value[from..at];
            let trimmed = piece.trim();
            let start = from + (piece.len() - piece.trim_start().len());
            from = next;
            if !trimmed.is_empty() {
                return Some((start, start + trimmed.len()));
            }
        }
        None
    })
}

#[cfg(test)]
mod tests {
    use super::ranges;

    #[test]
    fn commas_in_brackets_part_nothing() {
        let items = |value: &str| -> Vec<String> {
            ranges(value)
                .map(|(start, end)| value[start..end].to_owned())
                .collect()
        };
        assert_eq!(items("a, b(c,d) ,,e,"), ["a", "b(c,d)", "e"]);
        assert_eq!(items("a(b,c"), ["a(b", "c"]);
        assert_eq!(
            items("x.out:y.in(k=v&l=(0,1)),z"),
            ["x.out:y.in(k=v&l=(0,1))", "z"]
        );
        assert!(items(" , ").is_empty());
    }
}
