//! `rtsctl docs`, hidden: writes `docs/cli.md`.

use crate::cli::{Cli, EXIT_CODES};
use crate::error::CliError;
use crate::exit::Exit;
use crate::output::Output;

/// Print the reference of the command line as Markdown
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Prints it.
pub fn run(_: &Args, out: &Output) -> Result<Exit, CliError> {
    out.result(&markdown())?;
    Ok(Exit::Ok)
}

/// Text of `docs/cli.md`.
pub fn markdown() -> String {
    let options = clap_markdown::MarkdownOptions::new()
        .title("rtsctl: command line".to_owned())
        .show_footer(false);
    let text = clap_markdown::help_markdown_custom::<Cli>(&options);
    // Markdown would run the lines of the list together.
    let codes = format!("```text\n{EXIT_CODES}\n```");
    let text = text.replace(EXIT_CODES, &codes);
    // A usage that was written by hand names the program, and so does what writes the page.
    let text = text.replace("`rtsctl rtsctl ", "`rtsctl ");
    format!(
        "<!-- Written by `rtsctl docs`: do not edit. -->\n\n{}\n",
        text.trim_end()
    )
}
