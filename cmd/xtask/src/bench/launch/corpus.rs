//! Whole systems as OpenRTM tools wrote them: ten components and ten connectors, with stand-ins where there is no module.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::super::stack::Stack;
use super::{Case, MANY};

/// Row, file of the corpus, and whether each component has a process of its own.
const SYSTEMS: [(&str, &str, bool); 2] = [
    (
        "system-10-one-process",
        "derived/ten_1proc.rtsys.xml",
        false,
    ),
    (
        "system-10-ten-processes",
        "derived/ten_10procs.rtsys.xml",
        true,
    ),
];

/// Apply and teardown of each system; none when there is no corpus.
pub fn cases(stack: &Stack) -> Result<Vec<Case<'_>>> {
    let Some(corpus) = std::env::var_os("RTSCTL_CORPUS") else {
        eprintln!("RTSCTL_CORPUS is not set: the rows of whole systems are left out");
        return Ok(Vec::new());
    };
    let corpus = PathBuf::from(corpus);
    let cases = SYSTEMS.into_iter();
    cases
        .map(|(row, file, isolated)| case(stack, row, &corpus.join(file), isolated))
        .collect()
}

fn case<'a>(stack: &'a Stack, row: &str, file: &Path, isolated: bool) -> Result<Case<'a>> {
    let overlay = stack.folder.path().join(format!("{row}.yaml"));
    let text = format!(
        "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec: {{ defaults: {{ isolated: {isolated} }} }}\n"
    );
    std::fs::write(&overlay, text)
        .with_context(|| format!("cannot write {}", overlay.display()))?;
    let (file, overlay) = (path(file)?, path(&overlay)?);
    Ok(Case {
        rows: vec![row.to_owned(), format!("{row}-teardown")],
        components: MANY,
        measure: Box::new(move || {
            let apply = [
                "apply",
                "--stand-ins",
                "--name",
                "ten",
                "-f",
                &file,
                "-f",
                &overlay,
            ];
            let up = stack.timed(&apply)?;
            let down = stack.timed(&["teardown", "ten", "--yes"])?;
            Ok(vec![up, down])
        }),
    })
}

fn path(path: &Path) -> Result<String> {
    let path = path.to_str().context("a path that is no text")?;
    Ok(path.to_owned())
}
