//! How much memory the forms of one file may take: a file of nearly empty elements must not cost hundreds of times its size.

use crate::diagnostic::Finding;

/// Bytes of forms for a byte of text. A port that says nothing but its name takes a third of it.
const TIMES: usize = 16;

/// Bytes of forms that every file may have.
const AT_LEAST: usize = 256 << 10;

/// Findings of one kind of mistake that are kept: a file of nothing else needs no longer list.
pub(super) const FINDING_LIMIT: usize = 200;

/// What is left for the forms of one file.
#[derive(Debug)]
pub(super) struct Allowance {
    left: usize,
    spent: bool,
}

impl Allowance {
    /// For a text of this length.
    pub(super) fn of(length: usize) -> Self {
        Self {
            left: length.saturating_mul(TIMES).saturating_add(AT_LEAST),
            spent: false,
        }
    }

    /// For what was read before.
    pub(super) fn unlimited() -> Self {
        Self {
            left: usize::MAX,
            spent: false,
        }
    }

    /// Takes the memory of some forms; false when there is not enough, then and ever after.
    pub(super) fn take(&mut self, count: usize, size: usize) -> bool {
        match self.left.checked_sub(count.saturating_mul(size)) {
            Some(left) if !self.spent => {
                self.left = left;
                true
            }
            _ => {
                self.spent = true;
                false
            }
        }
    }

    /// True when something was refused.
    pub(super) fn is_spent(&self) -> bool {
        self.spent
    }
}

/// Said of a file that was not read to its end.
pub(super) fn too_dense() -> Finding {
    Finding::error(
        "too-dense",
        "the file has more elements than a file of its size can have, most of them nearly empty",
    )
    .help("is this the right file?")
}
