//! "Did you mean": the nearest of the names that would have been right.

/// The candidate nearest to `word`, when it is near enough to be a slip of the pen.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Longer words are no typos of each other, and the distance is quadratic.
    const LONGEST: usize = 256;
    if word.len() > LONGEST {
        return None;
    }
    let lower = word.to_lowercase();
    candidates
        .into_iter()
        .take(1000)
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| {
            let distance = strsim::damerau_levenshtein(&lower, &candidate.to_lowercase());
            (distance, candidate)
        })
        .filter(|(distance, candidate)| *distance <= candidate.chars().count().max(3) / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Names as a list for a message: `a, b, c`, at most twelve.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<&str> = names.into_iter().collect();
    let mut text = names
        .iter()
        .take(SHOWN)
        .copied()
        .collect::<Vec<_>>()
        .join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    text
}

/// Advice for a wrong word: the nearest right one, and all of them.
pub fn advice(word: &str, what: &str, candidates: &[&str]) -> String {
    let all = listed(candidates.iter().copied());
    match nearest(word, candidates.iter().copied()) {
        Some(near) if candidates.len() == 1 => format!("did you mean `{near}`?"),
        Some(near) => format!("did you mean `{near}`? {what}: {all}"),
        None => format!("{what}: {all}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_takes_slips_only() {
        let names = ["Sine0", "Filter0", "Printer0"];
        assert_eq!(nearest("sine0", names), Some("Sine0"));
        assert_eq!(nearest("Fitler0", names), Some("Filter0"));
        assert_eq!(nearest("Camera0", names), None);
        assert_eq!(nearest("ot", ["in", "out"]), Some("out"));
    }

    #[test]
    fn advice_lists_everything() {
        assert_eq!(advice("x", "ports", &["a1b2c3", "in"]), "ports: a1b2c3, in");
    }
}
