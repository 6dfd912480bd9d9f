//! `rtsctl check --explain`.

use rts_schemas::{codes, suggest};

use crate::error::CliError;

/// The explanation of a code; without one all codes with their titles.
pub(super) fn explain(code: Option<&str>) -> Result<String, CliError> {
    let Some(code) = code else {
        return Ok(list());
    };
    // As it stands in a message: `error[unknown-port]`.
    let bare = code.split_once('[').map_or(code, |(_, rest)| rest);
    let bare = bare.trim_end_matches(']').trim().to_ascii_lowercase();
    if let Some(found) = codes::find(&bare) {
        return Ok(format!(
            "{}: {}\n\n{}\n",
            found.code,
            found.title,
            found.explain.trim()
        ));
    }
    let near = suggest::nearest(&bare, codes::all().map(|known| known.code));
    let list = "`rtsctl check --explain` lists all codes";
    let help = match near {
        Some(near) => format!("did you mean `{near}`? {list}"),
        None => list.to_owned(),
    };
    Err(CliError::usage_help(
        format!("`{bare}` is no code of a finding"),
        help,
    ))
}

fn list() -> String {
    let mut all: Vec<_> = codes::all().collect();
    all.sort_by_key(|code| code.code);
    let width = all.iter().map(|code| code.code.len()).max().unwrap_or(0);
    let line = |code: &&codes::Code| format!("{:width$}  {}\n", code.code, code.title);
    all.iter().map(line).collect()
}
