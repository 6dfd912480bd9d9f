//! A patch file: lines that say what it breaks and which test must notice, then a unified diff.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

/// One mutation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    /// File name without `.patch`.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// Package of the test that must fail.
    pub package: String,
    /// Its file in the package's `tests/`; none for a unit test.
    pub file: Option<String>,
    /// Its full name in that file.
    pub name_of_test: String,
}

impl Patch {
    /// The test, for people.
    pub fn test(&self) -> String {
        let file = self.file.as_deref().unwrap_or("lib");
        format!("{}::{file} {}", self.package, self.name_of_test)
    }
}

/// All patches of a folder, sorted by name.
pub fn all(folder: &Path) -> Result<Vec<Patch>> {
    let entries =
        std::fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let mut patches = Vec::new();
    for entry in entries {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "patch") {
            let text = std::fs::read_to_string(&path);
            let text = text.with_context(|| format!("cannot read {}", path.display()))?;
            patches.push(parse(&path, &text).with_context(|| path.display().to_string())?);
        }
    }
    patches.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(patches)
}

/// Reads the head of a patch: `breaks: WORDS` and `caught by: PACKAGE FILE TEST`.
fn parse(path: &Path, text: &str) -> Result<Patch> {
    let head = || text.lines().take_while(|line| !line.starts_with("--- "));
    let field = |key: &str| {
        head()
            .find_map(|line| line.strip_prefix(key))
            .map(str::trim)
    };
    if field("breaks:").is_none_or(str::is_empty) {
        bail!("there is no line `breaks: …` that says which rule it breaks");
    }
    let test = field("caught by:").context("there is no line `caught by: PACKAGE FILE TEST`")?;
    let words: Vec<&str> = test.split_whitespace().collect();
    let [package, file, name_of_test] = words.as_slice() else {
        bail!("`caught by:` takes a package, a test file (or `lib`), and the name of a test");
    };
    let name = path.file_stem().and_then(|name| name.to_str());
    Ok(Patch {
        name: name.context("its name is not text")?.to_owned(),
        path: path.to_owned(),
        package: (*package).to_owned(),
        file: (*file != "lib").then(|| (*file).to_owned()),
        name_of_test: (*name_of_test).to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Patch> {
        parse(Path::new("mutants/a.patch"), text)
    }

    #[test]
    fn the_head_names_the_test() {
        let patch = read("breaks: a rule\ncaught by: rts-plan laws converges\n--- a/x\n").unwrap();
        assert_eq!(
            (patch.name.as_str(), patch.test().as_str()),
            ("a", "rts-plan::laws converges")
        );
        let patch = read("caught by: rts-plan lib check::tests::a\nbreaks: x\n").unwrap();
        assert_eq!(patch.file, None);
    }

    #[test]
    fn a_head_that_says_too_little_is_refused() {
        for text in [
            "",
            "breaks: a rule\n--- a/x\ncaught by: p f t\n",
            "caught by: p f t\n",
            "breaks:\ncaught by: p f t\n",
            "breaks: a\ncaught by: p f\n",
        ] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
