//! `rtsctl manager create`.

use std::collections::BTreeMap;

use percent_encoding::percent_decode_str;
use rts_agent_api::messages::CreateByHand;

use super::place;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Manager that is used, and started if need be, when none is named.
const DEFAULT_MANAGER: &str = "main";

/// Create a component by hand: `TYPE?key=value&key=value`
///
/// Parameters are set before the component is initialised. Special keys, as in OpenRTM: `instance_name`, `manager`, and
/// `exec_cxt.periodic.rate` in Hz. Write `%26` for `&`, `%3D` for `=` and `%25` for `%`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Type and parameters (`ConsoleOut?instance_name=C9&manager=tools`)
    #[arg(value_name = "TYPE?KEY=VALUE&…")]
    component: String,
    /// Manager; started when it is not there [default: main]
    #[arg(long, value_name = "MANAGER")]
    manager: Option<String>,
    /// Node [default: where the manager is]
    #[arg(long, value_name = "NODE")]
    node: Option<String>,
}

/// Creates it and says where.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let wanted = parse(&args.component).map_err(|message| {
        CliError::usage_help(
            format!("{:?} is no component to create: {message}", args.component),
            "write TYPE?key=value&key=value, as in `ConsoleOut?instance_name=C9`",
        )
    })?;
    let manager = match (args.manager, wanted.manager) {
        (Some(a), Some(b)) if a != b => {
            let text = format!("two managers are named: --manager {a} and manager={b}");
            return Err(CliError::usage(text));
        }
        (a, b) => a.or(b).unwrap_or_else(|| DEFAULT_MANAGER.to_owned()),
    };
    let controller = session.connect().await?;
    let place = place::manager(&controller, &manager, args.node.as_deref()).await?;
    let made = controller
        .create(&place.node, &place.manager, &wanted.request)
        .await;
    let what = format!(
        "create a {} in manager/{}",
        wanted.request.type_name, place.manager
    );
    let made = made.map_err(CliError::request(what))?;
    if !place.runs {
        let text = format!("rtsctl: manager/{} did not run: started it", made.manager);
        session.out.say(&text);
    }
    session.out.result(&format!(
        "component/{} created in manager/{} on node/{}",
        made.instance, made.manager, made.node
    ))?;
    Ok(Exit::Ok)
}

/// What a create string says.
#[derive(Debug, Clone, PartialEq)]
struct Wanted {
    manager: Option<String>,
    request: CreateByHand,
}

fn parse(text: &str) -> Result<Wanted, String> {
    let (type_name, query) = text.split_once('?').unwrap_or((text, ""));
    let type_name = decode(type_name)?;
    if type_name.is_empty() {
        return Err("it names no type".to_owned());
    }
    let mut wanted = Wanted {
        manager: None,
        request: CreateByHand {
            type_name,
            instance: None,
            parameters: BTreeMap::new(),
            rate: None,
        },
    };
    for pair in query.split('&').filter(|pair| !pair.is_empty()) {
        let (key, value) = pair
            .split_once('=')
            .ok_or_else(|| format!("{pair:?} has no `=`"))?;
        set(&mut wanted, decode(key)?, decode(value)?)?;
    }
    Ok(wanted)
}

fn set(wanted: &mut Wanted, key: String, value: String) -> Result<(), String> {
    let request = &mut wanted.request;
    let twice = match key.as_str() {
        "" => return Err(format!("the value {value:?} has no key")),
        "instance_name" => request.instance.replace(value).is_some(),
        "manager" => wanted.manager.replace(value).is_some(),
        "exec_cxt.periodic.rate" => request.rate.replace(rate(&value)?).is_some(),
        _ => request.parameters.insert(key.clone(), value).is_some(),
    };
    if twice {
        Err(format!("{key} is said twice"))
    } else {
        Ok(())
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text
        .parse()
        .ok()
        .filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    rate.ok_or_else(|| format!("{text:?} is no rate in Hz"))
}

fn decode(text: &str) -> Result<String, String> {
    let decoded = percent_decode_str(text).decode_utf8();
    let decoded = decoded.map_err(|_| format!("{text:?} is not UTF-8"))?;
    Ok(decoded.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_go_where_they_belong() {
        let wanted = parse(
            "ConsoleOut?instance_name=C9&manager=tools&path=/x%26y%3D%25&exec_cxt.periodic.rate=20&e=",
        )
        .unwrap();
        assert_eq!(wanted.manager.as_deref(), Some("tools"));
        let request = wanted.request;
        assert_eq!(request.type_name, "ConsoleOut");
        assert_eq!(request.instance.as_deref(), Some("C9"));
        assert_eq!(request.rate, Some(20.0));
        let parameters: Vec<_> = request.parameters.into_iter().collect();
        let text = |s: &str| s.to_owned();
        assert_eq!(
            parameters,
            [(text("e"), text("")), (text("path"), text("/x&y=%"))]
        );
    }

    #[test]
    fn a_type_alone_is_enough() {
        let wanted = parse("ConsoleOut").unwrap();
        assert_eq!(wanted.request.type_name, "ConsoleOut");
        assert_eq!(wanted, parse("ConsoleOut?").unwrap());
    }

    #[test]
    fn what_makes_no_sense_is_said() {
        let error = |text| parse(text).unwrap_err();
        assert_eq!(error("?a=1"), "it names no type");
        assert_eq!(error("X?a"), "\"a\" has no `=`");
        assert_eq!(error("X?=1"), "the value \"1\" has no key");
        assert_eq!(error("X?a=1&a=2"), "a is said twice");
        assert_eq!(error("X?a=%FF"), "\"%FF\" is not UTF-8");
        for rate in ["0", "-1", "inf", "NaN", "fast"] {
            let text = format!("X?exec_cxt.periodic.rate={rate}");
            assert!(parse(&text).is_err(), "{rate}");
        }
    }
}
