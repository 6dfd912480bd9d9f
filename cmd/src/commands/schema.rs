//! `rtsctl schema`.

use clap::ValueEnum;
use rts_schemas::json_schema;

use crate::error::CliError;
use crate::exit::Exit;
use crate::output::Output;

/// Print the JSON Schema of a kind of file
///
/// Editors complete and check YAML with it: `rtsctl schema > deployment.json`, and `# yaml-language-server:
/// $schema=deployment.json` as the first line of an overlay.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The kind of file
    #[arg(value_name = "KIND", default_value = "overlay")]
    document: Document,
}

/// Of the manifest that `rtsctl node add -f` reads.
const NODE: &str = include_str!("../../../docs/schema/node.json");

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Document {
    /// Deployment overlay
    Overlay,
    /// RTS Profile as YAML
    RtsProfile,
    /// RTC Profile as YAML
    RtcProfile,
    /// A system as the API has it
    System,
    /// Node that is reached by SSH
    Node,
}

/// Prints it.
pub fn run(args: &Args, out: &Output) -> Result<Exit, CliError> {
    let document = match args.document {
        Document::Overlay => json_schema::Document::Overlay,
        Document::RtsProfile => json_schema::Document::RtsProfile,
        Document::RtcProfile => json_schema::Document::RtcProfile,
        Document::System => json_schema::Document::System,
        Document::Node => {
            out.result(NODE.trim_end())?;
            return Ok(Exit::Ok);
        }
    };
    out.result(&format!("{:#}", json_schema::of(document)))?;
    Ok(Exit::Ok)
}
