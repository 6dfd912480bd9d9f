//! What the controller tells at one moment.

use std::time::Instant;

use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Component, Connector, Kind, Manager};
use serde::de::DeserializeOwned;

use super::{Args, What};
use crate::error::CliError;

/// Objects of a kind, and when they were asked for.
#[derive(Debug, Clone)]
pub struct Seen<T> {
    /// The middle between question and answer.
    pub at: Instant,
    /// The objects, as they were then.
    pub items: Vec<T>,
}

/// Everything that is wanted.
#[derive(Debug, Clone)]
pub struct Look {
    /// Components; those say, too, where connectors are.
    pub components: Seen<Component>,
    /// Connectors.
    pub connectors: Seen<Connector>,
    /// Managers.
    pub managers: Seen<Manager>,
}

impl Look {
    /// Asks now.
    pub(super) async fn at(controller: &Controller, args: &Args) -> Result<Self, CliError> {
        let wants = |what| args.shows(what);
        Ok(Self {
            components: list(controller, Kind::Component, true).await?,
            connectors: list(controller, Kind::Connector, wants(What::Connectors)).await?,
            managers: list(controller, Kind::Manager, wants(What::Managers)).await?,
        })
    }
}

async fn list<T: DeserializeOwned>(
    controller: &Controller,
    kind: Kind,
    wanted: bool,
) -> Result<Seen<T>, CliError> {
    let began = Instant::now();
    let items = match wanted {
        false => Vec::new(),
        true => {
            let list = controller.list(kind).await;
            let what = format!("list {}", kind.plural());
            list.map_err(CliError::request(what))?.items
        }
    };
    Ok(Seen {
        at: began + began.elapsed() / 2,
        items,
    })
}
