//! The difference of two texts, as `diff -u` shows it.

use std::time::Duration;

use similar::TextDiff;

/// After this a coarser difference is shown.
const LIMIT: Duration = Duration::from_secs(5);

/// The old text against the new one.
pub fn diff(name: &str, old: &str, new: &str) -> String {
    if old == new {
        return format!("{name}: the text stays, its encoding changes\n");
    }
    let mut config = TextDiff::configure();
    let difference = config.timeout(LIMIT).diff_lines(old, new);
    let mut unified = difference.unified_diff();
    let head = unified
        .header(name, &format!("{name} (canonical)"))
        .to_string();
    // The end of a line of DOS would only move the cursor.
    head.replace('\r', "␍")
}

#[cfg(test)]
mod tests {
    use super::diff;

    #[test]
    fn lines_are_shown_with_their_ends() {
        insta::assert_snapshot!(diff("a.xml", "<a>\r\n <b/>\n</a>", "<a>\n <b/>\n</a>\n"));
        assert!(diff("a.xml", "x", "x").contains("encoding"));
    }
}
