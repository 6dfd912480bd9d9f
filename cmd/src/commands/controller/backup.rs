//! `rtsctl controller backup`.

use std::path::{Path, PathBuf};

use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Write the controller's whole store into a file
///
/// The controller goes on meanwhile. The file is for your eyes only (mode 0600), and there whole or not at all.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// File to write; `-` for stdout
    file: PathBuf,
}

/// Asks the controller for the document, and keeps it.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let document = controller.backup().await;
    let document = document.map_err(CliError::request("back the store up"))?;
    if args.file == Path::new("-") {
        session.out.result(&document)?;
        return Ok(Exit::Ok);
    }
    let written = rts_host::files::replace_durably(&args.file, document.as_bytes());
    written.map_err(|source| CliError::Write {
        path: args.file.clone(),
        source,
    })?;
    let text = format!("backed up to {}", args.file.display());
    session.out.result(&text)?;
    Ok(Exit::Ok)
}
