//! What is wrong with the text of a fault, and where.

use std::fmt;

/// A word that was not expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct WordError {
    /// The text.
    pub text: String,
    /// Characters before the word; of the whole text when it ends too early.
    pub at: usize,
    /// The word; none at the end.
    pub word: Option<String>,
    /// What was expected there.
    pub expected: String,
    /// The expected word that is nearest to what was said.
    pub nearest: Option<String>,
}

impl fmt::Display for WordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fault `{}`: expected {}, ", self.text, self.expected)?;
        let place = self.at.saturating_add(1);
        match &self.word {
            Some(word) => write!(f, "found `{word}` at character {place}")?,
            None => write!(f, "and it ends there")?,
        }
        match &self.nearest {
            Some(nearest) => write!(f, "; did you mean {nearest}?"),
            None => Ok(()),
        }
    }
}

/// The one of these that was probably meant.
pub fn nearest<'a>(word: &str, of: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let likeness = |known: &str| strsim::jaro_winkler(&word.to_lowercase(), &known.to_lowercase());
    let known = of.into_iter().map(|known| (known, likeness(known)));
    let best = known.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (best.1 > 0.8).then(|| best.0.to_owned())
}
