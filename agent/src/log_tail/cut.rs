//! Splits bytes into lines, however the bytes come, with a bound on each line.

/// Longest line in bytes that is kept; the rest of it is left out.
pub(super) const MAX_LINE: usize = 256 * 1024;
/// Ends a line that was cut.
const CUT: &str = "…";

/// Holds the beginning of the line that has not ended yet.
#[derive(Debug, Default)]
pub(super) struct Cutter {
    rest: Vec<u8>,
    cut: bool,
}

impl Cutter {
    /// Gives each line that ends in these bytes, without its end. Bytes that are not UTF-8 are replaced.
    pub fn push(&mut self, mut bytes: &[u8], mut line: impl FnMut(String)) {
        while let Some(at) = bytes.iter().position(|b| *b == b'\n') {
            self.keep(&bytes[..at]);
            line(self.take());
            bytes = &bytes[at + 1..];
        }
        self.keep(bytes);
    }

    /// The last line, when it has no end.
    pub fn finish(&mut self) -> Option<String> {
        (!self.rest.is_empty()).then(|| self.take())
    }

    fn keep(&mut self, bytes: &[u8]) {
        let room = MAX_LINE - self.rest.len();
        self.cut |= bytes.len() > room;
        self.rest.extend_from_slice(&bytes[..bytes.len().min(room)]);
    }

    fn take(&mut self) -> String {
        let mut text = String::from_utf8_lossy(&self.rest).into_owned();
        self.rest.clear();
        if std::mem::take(&mut self.cut) {
            text.push_str(CUT);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lines<'a>(chunks: impl IntoIterator<Item = &'a [u8]>) -> Vec<String> {
        let mut cutter = Cutter::default();
        let mut lines = Vec::new();
        for chunk in chunks {
            cutter.push(chunk, |line| lines.push(line));
        }
        lines.extend(cutter.finish());
        lines
    }

    #[test]
    fn lines_come_without_their_ends_and_the_last_one_may_have_none() {
        assert_eq!(lines([&b"a\n\nb"[..]]), ["a", "", "b"]);
        assert_eq!(lines([&b"a"[..], b"b\n"]), ["ab"]);
        assert_eq!(lines([&b""[..]]), [""; 0]);
        // A character that is torn apart is whole again, and no UTF-8 is no reason to stop.
        assert_eq!(
            lines([&b"\xe5"[..], b"\xb7\xa6\n\xff\n"]),
            ["左", "\u{fffd}"]
        );
    }

    #[test]
    fn a_huge_line_is_cut_and_the_next_one_is_whole() {
        let huge = vec![b'x'; 3 * MAX_LINE];
        let got = lines([&huge[..], b"yy\nnext\n"]);
        assert_eq!(got[0].len(), MAX_LINE + CUT.len());
        assert_eq!(got[1..], ["next"]);
    }

    proptest! {
        #[test]
        fn any_chunking_gives_the_same_lines(
            text in proptest::collection::vec(prop_oneof![Just(b'\n'), any::<u8>()], 0..400),
            sizes in proptest::collection::vec(1usize..20, 1..80),
        ) {
            let mut chunks = Vec::new();
            let mut rest = &text[..];
            for size in sizes.iter().cycle() {
                if rest.is_empty() {
                    break;
                }
                let (chunk, after) = rest.split_at((*size).min(rest.len()));
                chunks.push(chunk);
                rest = after;
            }
            prop_assert_eq!(lines(chunks), lines([&text[..]]));
        }
    }
}
