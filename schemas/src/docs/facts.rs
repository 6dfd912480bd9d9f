//! A doc comment → its text and its facts.

/// What there is to know of a field besides what it means.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Facts {
    /// The values that it may have, as they are written.
    pub values: Vec<String>,
    /// What holds when it is not said.
    pub default: Option<String>,
    /// Who demands it: `by the schema`.
    pub required: Option<String>,
    /// In which versions of the profile it stands.
    pub versions: Option<String>,
    /// Unit of a number.
    pub unit: Option<String>,
}

/// Parts a doc comment, whose lines start with a blank, into its text and its facts.
pub(super) fn parted(doc: &str) -> (String, Facts) {
    let mut facts = Facts::default();
    let mut paragraphs = vec![String::new()];
    let mut last: Option<(String, String)> = None;
    for line in doc.lines() {
        let fact = line
            .trim()
            .strip_prefix("- ")
            .and_then(|line| line.split_once(": "));
        if let Some((name, value)) = fact {
            facts.set(last.take());
            last = Some((name.to_owned(), value.trim().to_owned()));
        } else if let (Some((_, value)), true) = (&mut last, line.starts_with("   ")) {
            value.push(' ');
            value.push_str(line.trim());
        } else if line.trim().is_empty() {
            paragraphs.push(String::new());
        } else if let Some(paragraph) = paragraphs.last_mut() {
            if !paragraph.is_empty() {
                paragraph.push(' ');
            }
            paragraph.push_str(line.trim());
        }
    }
    facts.set(last);
    paragraphs.retain(|paragraph| !paragraph.is_empty());
    (paragraphs.join("\n"), facts)
}

impl Facts {
    /// True for a name that is known; others would be lost.
    pub fn is_known(name: &str) -> bool {
        ["Values", "Default", "Required", "Versions", "Unit"].contains(&name)
    }

    fn set(&mut self, fact: Option<(String, String)>) {
        let Some((name, value)) = fact else { return };
        match name.as_str() {
            "Values" => {
                let values = value
                    .split(", ")
                    .map(|value| value.trim_matches('`').to_owned());
                self.values = values.collect();
            }
            "Default" => self.default = Some(value.trim_matches('`').to_owned()),
            "Required" => self.required = Some(value),
            "Versions" => self.versions = Some(value),
            "Unit" => self.unit = Some(value),
            _ => debug_assert!(Self::is_known(&name), "{name}"),
        }
    }
}
