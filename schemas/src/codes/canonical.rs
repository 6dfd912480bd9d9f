//! What `rtsctl fmt` finds.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "comments-in-yaml",
        title: "canonical YAML would lose comments",
        explain: "\
`rtsctl fmt` prints a profile from what it means, and in YAML a comment is no part of that. A file with comments would
lose them, so it is left as it is. In XML comments are kept.

Example:

    rtsProfile:
      id: RTSystem:a:b:1  # mine

Mend it by taking the comments out, by putting them into `rtsExt::comment`, or by keeping the profile as XML.",
    },
    Code {
        code: "not-canonical",
        title: "the file cannot be written in canonical form",
        explain: "\
`rtsctl fmt` reads what it printed once more and compares it with the file. When anything would be lost or be another, it
refuses, and the file stays as it is.

Example: a second key beside `rtsProfile:`, which no profile has a place for.

    rtsProfile:
      id: RTSystem:a:b:1
    notes: mine

Mend it by taking away what the message names; where it names nothing of yours, it is a mistake of the program, and a
report of it is welcome.",
    },
];
