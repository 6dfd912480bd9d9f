//! `rtsctl export`.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use jiff::Timestamp;
use rts_schemas::rts_profile::{self, WriteOptions};
use rts_schemas::system::SystemSpec;

use super::smoke::Snapshot;
use crate::error::CliError;
use crate::exit::Exit;
use crate::save::save;
use crate::session::Session;
use crate::show::picture;

/// Write a system as it runs, with what was changed by hand (rtcryo)
///
/// Applying what was written changes nothing, unless something was changed by hand since.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Name of the system
    #[arg(value_name = "SYSTEM")]
    name: String,
    /// File to write, which is replaced as a whole; `-` for stdout
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    /// How to write it
    #[arg(short, long, value_name = "FORMAT", default_value = "xml")]
    output: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// RTS Profile, XML
    Xml,
    /// The system as the API has it, JSON
    Json,
    /// The system as the API has it, YAML
    Yaml,
    /// A picture of the system: components in the colours of their states, ports, connectors and nodes
    Svg,
}

/// Writes it.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    let controller = session.connect().await?;
    let name = &args.name;
    let exported = controller.export(name).await;
    let exported = exported.map_err(CliError::request(format!("export system/{name}")))?;
    let text = match args.output {
        Format::Xml => {
            let system = controller.system(name).await;
            let system = system.map_err(CliError::request(format!("find system/{name}")))?;
            let (created, now) = (system.metadata.creation_timestamp, Timestamp::now());
            profile(&exported.spec, created.unwrap_or(now), now)
        }
        Format::Json => format!("{:#}", serde_json::json!(exported.spec)),
        Format::Svg => {
            let runs = Snapshot::take(&controller, name).await?;
            picture::svg(&exported.spec, &runs.components, &runs.connectors)
        }
        Format::Yaml => serde_yaml::to_string(&exported.spec).map_err(std::io::Error::other)?,
    };
    for note in &exported.notes {
        session.out.say(&format!("note: {note}"));
    }
    if args.out == Path::new("-") {
        session.out.document(&text)?;
        return Ok(Exit::Ok);
    }
    save(&args.out, &text)?;
    let file = args.out.display();
    session
        .out
        .result(&format!("system/{name} exported to {file}"))?;
    Ok(Exit::Ok)
}

/// An RTS Profile. Its dates are in UTC.
pub fn profile(spec: &SystemSpec, created: Timestamp, now: Timestamp) -> String {
    let date = |time: Timestamp| time.strftime("%Y-%m-%dT%H:%M:%S").to_string();
    let options = WriteOptions {
        created: &date(created),
        updated: &date(now),
        abstract_text: "",
    };
    rts_profile::write(spec, &options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_that_is_written_is_the_system_again() {
        let hello = include_bytes!("../../../manifests/hello/system.xml");
        let spec = rts_profile::load("hello.xml", hello, None, &[]).unwrap().0;
        let text = profile(&spec, Timestamp::UNIX_EPOCH, Timestamp::UNIX_EPOCH);
        assert!(
            text.contains(r#"rts:creationDate="1970-01-01T00:00:00""#),
            "{text}"
        );
        let again = rts_profile::load("again.xml", text.as_bytes(), None, &[]);
        assert_eq!(again.unwrap().0, spec);
    }
}
