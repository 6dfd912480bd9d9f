//! `rtsctl describe`.

use clap::ValueEnum;
use jiff::Timestamp;
use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Event, Kind, List, Metadata};
use serde::de::DeserializeOwned;

use super::get::{KindName, absent, singular};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;
use crate::show::describe::{self, Scene};

/// Tell all about one object: what is wanted, what is, why it is so, what it waits for, and what happened to it
#[derive(Debug, clap::Args)]
pub struct Args {
    /// KIND/NAME (`component/Sine0`), or the kind alone
    #[arg(value_name = "KIND[/NAME]")]
    object: String,
    /// Name of the object
    name: Option<String>,
}

/// Prints it.
pub async fn run(args: &Args, session: &Session) -> Result<Exit, CliError> {
    let (kind, name) = settle(args)?;
    let controller = session.connect().await?;
    let scene = look(&controller, session).await?;
    let pages = describe::pages(kind, &name, &scene);
    if pages.is_empty() {
        return Err(absent(kind, &name, &describe::names(kind, &scene)));
    }
    session.out.result(&pages.join("\n"))?;
    Ok(Exit::Ok)
}

fn settle(args: &Args) -> Result<(Kind, String), CliError> {
    let (kind, name) = match (args.object.split_once('/'), &args.name) {
        (Some((kind, name)), None) => (kind, name),
        (None, Some(name)) => (args.object.as_str(), name.as_str()),
        _ => {
            return Err(CliError::usage_help(
                "one object is described at a time",
                "write KIND/NAME or KIND NAME, as in `rtsctl describe component/Sine0`",
            ));
        }
    };
    Ok((kind_of(kind)?, name.to_owned()))
}

/// A kind as people type it.
pub fn kind_of(text: &str) -> Result<Kind, CliError> {
    let kind = KindName::from_str(text, true).map_err(|_| {
        let kinds = Kind::ALL.map(singular).join(", ");
        CliError::usage_help(
            format!("there is no kind {text:?}"),
            format!("kinds: {kinds}"),
        )
    })?;
    Ok(kind.0)
}

/// Everything that the pages draw from.
async fn look(controller: &Controller, session: &Session) -> Result<Scene, CliError> {
    Ok(Scene {
        now: Timestamp::now(),
        lacking: session.lacking(),
        systems: list(controller, Kind::System).await?,
        nodes: list(controller, Kind::Node).await?,
        components: list(controller, Kind::Component).await?,
        connectors: list(controller, Kind::Connector).await?,
        managers: list(controller, Kind::Manager).await?,
        events: list::<Event>(controller, Kind::Event).await?,
    })
}

async fn list<T: DeserializeOwned>(
    controller: &Controller,
    kind: Kind,
) -> Result<Vec<T>, CliError> {
    let list: Result<List<T>, _> = controller.list(kind).await;
    let list = list.map_err(CliError::request(format!("list {}", kind.plural())))?;
    Ok(list.items)
}

/// The line of an object's version, for pages.
pub fn version(metadata: &Metadata) -> String {
    format!(
        "generation {}, resource version {}",
        metadata.generation, metadata.resource_version
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled(object: &str, name: Option<&str>) -> Result<(Kind, String), CliError> {
        settle(&Args {
            object: object.to_owned(),
            name: name.map(str::to_owned),
        })
    }

    #[test]
    fn an_object_is_named_in_one_word_or_two() {
        let sine = (Kind::Component, "Sine0".to_owned());
        assert_eq!(settled("component/Sine0", None).unwrap(), sine);
        assert_eq!(settled("comp", Some("Sine0")).unwrap(), sine);
        for (object, name) in [
            ("component", None),
            ("component/A", Some("B")),
            ("robot/A", None),
        ] {
            assert_eq!(settled(object, name).unwrap_err().exit().code(), 2);
        }
    }
}
