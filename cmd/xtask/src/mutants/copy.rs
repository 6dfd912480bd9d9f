//! A copy of the sources in which patches can be tried. Files that have not changed keep their times, so that cargo
//! builds again only what a patch touches.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::project;

/// The copy.
pub struct Copy {
    folder: PathBuf,
}

impl Copy {
    /// A copy in this folder, which may hold an older one.
    pub fn new(folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make {}", folder.display()))?;
        Ok(Self {
            folder: folder.to_owned(),
        })
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Makes it equal to the sources again.
    pub fn refresh(&self) -> Result<()> {
        let wanted = sources()?;
        for file in &wanted {
            let (from, to) = (project::root().join(file), self.folder.join(file));
            let new =
                std::fs::read(&from).with_context(|| format!("cannot read {}", from.display()))?;
            let new = under_another_version(file, new);
            if std::fs::read(&to).is_ok_and(|old| old == new) {
                continue;
            }
            if let Some(parent) = to.parent() {
                std::fs::create_dir_all(parent)?;
            }
            std::fs::write(&to, new).with_context(|| format!("cannot write {}", to.display()))?;
        }
        self.remove_others(&self.folder, &wanted)
    }

    /// Applies a patch.
    pub fn apply(&self, patch: &Path) -> Result<()> {
        let mut command = project::command("git");
        // Outside of any repository, so that nothing but the files counts.
        let ceiling = self.folder.parent().unwrap_or(&self.folder);
        command
            .current_dir(&self.folder)
            .env("GIT_CEILING_DIRECTORIES", ceiling)
            .args(["apply", "--whitespace=nowarn", "-p1"])
            .arg(patch);
        project::run(&mut command).with_context(|| {
            format!(
                "{} does not fit the sources any more; make it anew",
                patch.display()
            )
        })
    }

    /// Removes files that the sources do not have.
    fn remove_others(&self, folder: &Path, wanted: &BTreeSet<PathBuf>) -> Result<()> {
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            let path = entry.path();
            if entry.file_type()?.is_dir() {
                self.remove_others(&path, wanted)?;
            } else if path
                .strip_prefix(&self.folder)
                .is_ok_and(|own| !wanted.contains(own))
            {
                std::fs::remove_file(&path)?;
            }
        }
        Ok(())
    }
}

/// The packages of the copy have a version of their own. Cargo keeps what it built of two packages of one name and version
/// in the same files: what was built of a mutant would otherwise be taken for the real one.
fn under_another_version(file: &Path, text: Vec<u8>) -> Vec<u8> {
    if file != Path::new("Cargo.toml") {
        return text;
    }
    let text = String::from_utf8_lossy(&text);
    let lines = text
        .lines()
        .map(|line| match line.starts_with("version = ") {
            true => "version = \"0.0.0-mutant\"\n".to_owned(),
            false => format!("{line}\n"),
        });
    lines.collect::<String>().into_bytes()
}

/// Files of the project, as far as they are not ignored.
fn sources() -> Result<BTreeSet<PathBuf>> {
    let mut command = project::command("git");
    command.args([
        "ls-files",
        "-z",
        "--cached",
        "--others",
        "--exclude-standard",
    ]);
    let output = command.output().context("cannot start git")?;
    if !output.status.success() {
        bail!("{} ended with {}", project::shown(&command), output.status);
    }
    let names = String::from_utf8(output.stdout).context("a file name is not text")?;
    let files = names
        .split('\0')
        .filter(|name| !name.is_empty())
        .map(PathBuf::from);
    // The copy lies below the sources, whose settings of cargo hold for it too; twice the same would be other settings.
    Ok(files
        .filter(|file| !file.starts_with(".cargo") && project::root().join(file).is_file())
        .collect())
}
