//! What came of removing copies over there, as the far side tells it, which is not trusted.

use crate::answer::tame;

/// Longest answer that is looked at in bytes.
const MAX_ANSWER: usize = 1024 * 1024;
/// Most sentences that are taken.
const MAX_TOLD: usize = 4;

/// What came of it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Collected {
    /// How many digests were removed.
    pub removed: usize,
    /// What did not work, in sentences: that nothing was removed, or that the lease could not be written.
    pub told: Vec<String>,
}

impl Collected {
    /// The answer of the script; none for half of one.
    pub fn parse(answer: &[u8]) -> Option<Self> {
        let answer = answer.get(..MAX_ANSWER).unwrap_or(answer);
        let text = String::from_utf8_lossy(answer);
        let mut collected = Self::default();
        for line in text.lines() {
            match line.split_once(' ') {
                Some(("gone", _)) => collected.removed += 1,
                Some(("told", said)) if collected.told.len() < MAX_TOLD => {
                    collected.told.push(tame(said));
                }
                _ => {}
            }
        }
        (text.lines().last() == Some("done")).then_some(collected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_an_answer_is_none_and_what_is_said_moves_no_cursor() {
        assert_eq!(Collected::parse(b"gone a\ngone b\n"), None);
        let collected = Collected::parse(b"gone a\ntold x\x1b[2J\ngone b\ndone\n").unwrap();
        assert_eq!(
            (collected.removed, collected.told),
            (2, vec!["x[2J".to_owned()])
        );
    }
}
