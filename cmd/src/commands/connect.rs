//! `rtsctl connect`.

use rts_agent_api::messages::Act;
use rts_controller_api::objects::{Component, Connector, Kind};

use super::by_hand::{Hand, find};
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Connect an out-port with an in-port by hand (rtcon)
///
/// What becomes of it in a system is for `rtsctl.drift` to say: by default the controller removes it again.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The out-port (`Sine0.out`)
    #[arg(value_name = "SOURCE.PORT")]
    source: String,
    /// The in-port (`Filter0.in`)
    #[arg(value_name = "TARGET.PORT")]
    target: String,
    /// Name of the connector [default: Source.port-Target.port]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// A connector property (`dataport.subscription_type=new`)
    #[arg(short, long = "property", value_name = "KEY=VALUE", value_parser = pair)]
    properties: Vec<(String, String)>,
    /// Only say what would be done
    #[arg(long)]
    dry_run: bool,
}

/// Connects them.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    if let Some(key) = repeated(&args.properties) {
        return Err(CliError::usage(format!("property {key} is said twice")));
    }
    let hand = Hand::reach(args.dry_run, session).await?;
    let components: Vec<Component> = hand.list(Kind::Component).await?;
    let connectors: Vec<Connector> = hand.list(Kind::Connector).await?;
    let source = find::end(&args.source, &components)?;
    let target = find::end(&args.target, &components)?;
    let name = args.name.as_deref();
    let so = connectors.iter().any(|c| {
        let ends = source.sends(c) && target.receives(c) && c.status.state == "Connected";
        ends && name.is_none_or(|name| c.metadata.name == name)
    });
    let act = Act::Connect {
        source: source.port,
        target: target.port,
        name: args.name,
        properties: args.properties.into_iter().collect(),
    };
    hand.act(&source.component.status.node, act, so, "").await?;
    Ok(Exit::Ok)
}

/// `KEY=VALUE`.
pub(super) fn pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.to_owned()))
        }
        _ => Err("write KEY=VALUE".to_owned()),
    }
}

/// A key that occurs twice.
pub(super) fn repeated(pairs: &[(String, String)]) -> Option<&str> {
    let repeats = |(i, (key, _)): (usize, &'_ (String, String))| {
        pairs[..i].iter().any(|(before, _)| before == key)
    };
    let mut all = pairs.iter().enumerate();
    all.find(|(i, pair)| repeats((*i, pair)))
        .map(|(_, (key, _))| key.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_split_at_the_first_equals_sign() {
        let both = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(pair("a.b=c=d"), Ok(both("a.b", "c=d")));
        assert_eq!(pair("a="), Ok(both("a", "")));
        assert!(pair("a").is_err() && pair("=b").is_err() && pair("").is_err());
        let pairs = [both("a", "1"), both("b", "1"), both("a", "2")];
        assert_eq!(repeated(&pairs), Some("a"));
        assert_eq!(repeated(&pairs[..2]), None);
    }
}
