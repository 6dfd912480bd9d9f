//! Optional components that nobody waits for, in words.

use super::Order;
use super::walk::PassedOver;

/// Names in a sentence; a large system may have any number.
const MOST_NAMES: usize = 3;

impl Order<'_> {
    /// One remark for each.
    pub fn tell(&self, over: &PassedOver<'_>) -> Vec<String> {
        let note = |(absent, who): (&&str, &std::collections::BTreeSet<&str>)| {
            let mut names: Vec<String> = who.iter().take(MOST_NAMES).map(|n| (*n).into()).collect();
            let more = who.len() - names.len();
            if more > 0 {
                names.push(format!("{more} more"));
            }
            let (verb, order) = (if who.len() == 1 { "does" } else { "do" }, &self.name);
            format!(
                "{} {verb} not wait for {absent} ({order} order): it is optional and cannot be brought up now",
                names.join(", ")
            )
        };
        over.iter().map(note).collect()
    }
}
