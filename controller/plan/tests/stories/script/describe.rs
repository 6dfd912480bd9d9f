//! A system in the short form of the transcripts.
//!
//! ```text
//! Sensor0 Sensor rate=50 gain=1.0 optional drift=ignore
//! Sensor0.out -> Motor0.in subscription=new
//! Planner0.map => Map0.map                               (consumer => provider)
//! activation Motor0 2 sync Sensor0 500
//! ```

use std::collections::BTreeMap;

use rts_plan::StoredSystem;
use rts_schemas::placement;
use rts_schemas::system::{
    ComponentSpec, Condition, ConnectorSpec, Orders, PortKind, PortRef, SendingTiming, SystemSpec,
    WaitFor,
};

use super::{Fault, number, pair};
use crate::world::specs::{component, connector, set, stored};

/// A system from its lines.
pub fn system(name: &str, lines: &[&str]) -> Result<StoredSystem, Fault> {
    let mut spec = SystemSpec {
        composites: Vec::new(),
        name: name.to_owned(),
        full_id: format!("RTSystem:rtsctl:{name}:1.0"),
        components: Vec::new(),
        connectors: Vec::new(),
        orders: Orders::default(),
    };
    for line in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            [source, "->", target, rest @ ..] => {
                spec.connectors.push(data(source, target, rest)?);
            }
            [consumer, "=>", provider] => spec.connectors.push(service(consumer, provider)?),
            [order, target, sequence, rest @ ..] if list(&mut spec.orders, order).is_some() => {
                let condition = condition(target, sequence, rest)?;
                list(&mut spec.orders, order).unwrap().push(condition);
            }
            [instance, type_name, rest @ ..] => {
                spec.components.push(one(instance, type_name, rest)?);
            }
            _ => return Err(format!("what is `{line}`?")),
        }
    }
    Ok(stored(spec))
}

fn one(instance: &str, type_name: &str, words: &[&str]) -> Result<ComponentSpec, Fault> {
    let mut component = component(instance, type_name);
    for word in words {
        if *word == "optional" {
            component.required = false;
            continue;
        }
        match pair(word)? {
            ("rate", value) => component.execution_context.rate = Some(number(value)?),
            (key, value) if placement::KEYS.contains(&key) => {
                placement::set(&mut component, key, value).map_err(|e| e.message)?;
            }
            (key, value) => set(&mut component, key, value),
        }
    }
    Ok(component)
}

fn end(text: &str) -> Result<(&str, &str), Fault> {
    text.split_once('.')
        .ok_or_else(|| format!("`{text}` is not Instance.port"))
}

fn data(source: &str, target: &str, words: &[&str]) -> Result<ConnectorSpec, Fault> {
    let mut connector = connector(end(source)?, end(target)?);
    for word in words {
        let (key, value) = pair(word)?;
        let key = match key {
            "subscription" => "dataport.subscription_type",
            key => key,
        };
        connector
            .properties
            .insert(key.to_owned(), value.to_owned());
    }
    Ok(connector)
}

/// A service connector with the binding that real profiles keep in its properties.
fn service(consumer: &str, provider: &str) -> Result<ConnectorSpec, Fault> {
    let ends = [end(consumer)?, end(provider)?];
    let [(needs, needs_port), (gives, gives_port)] = ends;
    let [source, target] = ends.map(|(instance, port)| PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    });
    let binding = (
        format!("{needs}.port.{needs_port}.required.MyService.my"),
        format!("{gives}.port.{gives_port}.provided.MyService.my"),
    );
    Ok(ConnectorSpec {
        name: format!("{source}-{target}"),
        kind: PortKind::Service,
        source,
        target,
        data_type: None,
        properties: BTreeMap::from([binding]),
    })
}

fn list<'a>(orders: &'a mut Orders, name: &str) -> Option<&'a mut Vec<Condition>> {
    Some(match name {
        "startup" => &mut orders.start_up,
        "shutdown" => &mut orders.shut_down,
        "activation" => &mut orders.activation,
        "deactivation" => &mut orders.deactivation,
        "resetting" => &mut orders.resetting,
        "initializing" => &mut orders.initializing,
        "finalizing" => &mut orders.finalizing,
        _ => return None,
    })
}

/// `Motor0 2`, `Motor0 2 wait 500`, `Motor0 2 sync Sensor0,Filter0 500`, `Motor0 2 async Sensor0`.
fn condition(target: &str, sequence: &str, words: &[&str]) -> Result<Condition, Fault> {
    let whole = |text: &str| {
        text.parse()
            .map_err(|_| format!("`{text}` is no whole number"))
    };
    let timing = |word: &str| match word {
        "sync" => Ok(SendingTiming::Sync),
        "async" => Ok(SendingTiming::Async),
        _ => Err(format!("what is `{word}`?")),
    };
    let preceding = |word: &str, names: &str, timeout_ms| {
        Ok::<_, Fault>(Some(WaitFor::Preceding {
            timing: timing(word)?,
            timeout_ms,
            components: names.split(',').map(str::to_owned).collect(),
        }))
    };
    let wait = match words {
        [] => None,
        ["wait", time] => Some(WaitFor::Time {
            milliseconds: whole(time)?,
        }),
        [word, names] => preceding(word, names, 0)?,
        [word, names, time] => preceding(word, names, whole(time)?)?,
        _ => return Err(format!("too many words: {}", words.join(" "))),
    };
    Ok(Condition {
        target: target.to_owned(),
        sequence: whole(sequence)?,
        wait,
    })
}
