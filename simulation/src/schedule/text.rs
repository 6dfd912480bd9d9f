//! Schedules for people, a line for each item.

use std::fmt;
use std::time::Duration;

use rts_agent_api::messages::Act;
use rts_schemas::system::{ComponentSpec, OnDisconnect, OnHang, SystemSpec, WaitFor};

use super::{Deed, Named, Schedule, What};
use crate::faults::{Fault, When};
use crate::workload::{Change, NODES, node_of};

impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nodes = NODES[..self.nodes.min(NODES.len())].join(", ");
        writeln!(
            f,
            "seed {} on {nodes}; quiet from {}",
            self.seed,
            time(self.quiet)
        )?;
        for system in &self.systems {
            write_system(f, system)?;
        }
        for deed in &self.deeds {
            writeln!(f, "{deed}")?;
        }
        for fault in &self.faults {
            writeln!(f, "{fault}")?;
        }
        Ok(())
    }
}

fn time(time: Duration) -> String {
    format!("{:.3} s", time.as_secs_f64())
}

fn lasting(lasts: Option<Duration>) -> String {
    lasts.map_or_else(
        || "for ever".to_owned(),
        |lasts| format!("for {}", time(lasts)),
    )
}

fn write_system(f: &mut fmt::Formatter<'_>, spec: &SystemSpec) -> fmt::Result {
    writeln!(f, "system {}", spec.name)?;
    for component in &spec.components {
        writeln!(f, "  {}", words(component))?;
    }
    for connector in &spec.connectors {
        writeln!(f, "  {}", connector.name)?;
    }
    let orders = &spec.orders;
    let lists = [
        ("start-up", &orders.start_up),
        ("shut-down", &orders.shut_down),
        ("activation", &orders.activation),
        ("deactivation", &orders.deactivation),
    ];
    for (name, list) in lists {
        for condition in list {
            write!(f, "  {name} {} at {}", condition.target, condition.sequence)?;
            match &condition.wait {
                None => writeln!(f)?,
                Some(WaitFor::Time { milliseconds }) => writeln!(f, " after {milliseconds} ms")?,
                Some(WaitFor::Preceding {
                    timing,
                    timeout_ms,
                    components,
                }) => {
                    let names = components.join(", ");
                    writeln!(f, " after {names} ({timing:?}, within {timeout_ms} ms)")?;
                }
            }
        }
    }
    Ok(())
}

fn words(component: &ComponentSpec) -> String {
    let ComponentSpec {
        instance,
        type_name,
        placement,
        policy,
        ..
    } = component;
    let mut words = vec![format!("{instance}: {type_name} on {}", node_of(component))];
    match &placement.manager {
        _ if placement.isolated => words.push("isolated".to_owned()),
        Some(manager) => words.push(format!("in {manager}")),
        None => {}
    }
    for (parameter, value) in component.configuration.sets.values().flatten() {
        words.push(format!("{parameter}={value}"));
    }
    if let Some(rate) = component.execution_context.rate {
        words.push(format!("{rate} Hz"));
    }
    words.push(format!("restart {}", policy.restart.as_str()));
    if let Some(limit) = policy.restart_limit {
        words.push(format!("at most {limit} times"));
    }
    if policy.on_disconnect != OnDisconnect::Keep {
        words.push(format!("on disconnect {}", policy.on_disconnect.as_str()));
    }
    if policy.on_hang != OnHang::Report {
        words.push(format!("on hang {}", policy.on_hang.as_str()));
    }
    if policy.reset_on_error {
        words.push("reset on error".to_owned());
    }
    if !component.required {
        words.push("optional".to_owned());
    }
    words.join(", ")
}

impl fmt::Display for Deed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {}: {}", self.name, time(self.at), self.what)
    }
}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Apply {
                system,
                change: Change::None,
            } => write!(f, "apply {system}"),
            Self::Apply { system, change } => write!(f, "apply {system} with {change}"),
            Self::Delete { system } => write!(f, "delete {system}"),
            Self::Module { type_name, version } => {
                write!(f, "put module {version} of {type_name} in place")
            }
            Self::Act(act) => act_words(f, act),
        }
    }
}

fn act_words(f: &mut fmt::Formatter<'_>, act: &Act) -> fmt::Result {
    match act {
        Act::Activate { instance } => write!(f, "activate {instance} by hand"),
        Act::Deactivate { instance } => write!(f, "deactivate {instance} by hand"),
        Act::Reset { instance } => write!(f, "reset {instance} by hand"),
        Act::Tick { instance, cycles } => write!(f, "tick {instance} {cycles} times"),
        Act::Configure {
            instance, values, ..
        } => {
            write!(f, "configure {instance} by hand: {values:?}")
        }
        Act::Connect { source, target, .. } => write!(f, "connect {source} with {target} by hand"),
        Act::Disconnect { connector, .. } => write!(f, "disconnect {connector} by hand"),
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => write!(f, "no change"),
            Self::Configure {
                instance,
                parameter,
                value,
            } => {
                write!(f, "{instance}.{parameter}={value}")
            }
            Self::Rate { instance, rate } => write!(f, "{instance} at {rate} Hz"),
            Self::Add(new) => write!(f, "the new component {}", words(new)),
            Self::Remove { instance } => write!(f, "{instance} removed"),
            Self::Connect { source, target } => write!(f, "{source} connected with {target}"),
            Self::Disconnect { source, target } => {
                write!(f, "{source} disconnected from {target}")
            }
            Self::Property { source, value } => write!(f, "connectors of {source} as {value}"),
            Self::Manager { instance, manager } if manager.is_empty() => {
                write!(f, "{instance} isolated")
            }
            Self::Manager { instance, manager } => write!(f, "{instance} in manager {manager}"),
            Self::Move { instance, node } => write!(f, "{instance} moved to {node}"),
        }
    }
}

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fault.when {
            When::At(at) => write!(f, "{} at {}: ", self.name, time(at))?,
            When::Step(step) => write!(f, "{} at step {step}: ", self.name)?,
        }
        write!(f, "{}", self.fault.fault)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let any = |name: &Option<String>| name.clone().unwrap_or_else(|| "a manager".to_owned());
        match self {
            Self::Crash {
                host,
                calls: 0,
                down,
            } => {
                write!(f, "{host} crashes, {}", lasting(*down))
            }
            Self::Crash { host, calls, down } => {
                write!(
                    f,
                    "{host} crashes after {calls} passages, {}",
                    lasting(*down)
                )
            }
            Self::Reboot { node, down } => write!(f, "{node} reboots, for {}", time(*down)),
            Self::Cut { from, to, lasts } => {
                write!(f, "cut from {from} to {to}, {}", lasting(*lasts))
            }
            Self::Weather {
                lost,
                doubled,
                delay,
                lasts,
            } => {
                let delay = time(*delay);
                let lasts = time(*lasts);
                write!(
                    f,
                    "weather: {lost}‰ lost, {doubled}‰ doubled, up to {delay} late, for {lasts}"
                )
            }
            Self::DiskFails { host, lasts } => {
                write!(f, "writes of {host} fail, for {}", time(*lasts))
            }
            Self::DiskSlow { host, delay, lasts } => {
                write!(
                    f,
                    "writes of {host} take up to {}, for {}",
                    time(*delay),
                    time(*lasts)
                )
            }
            Self::ClockJumps { host, by } => write!(f, "the clock of {host} jumps by {by:#}"),
            Self::ManagerDies { node, manager } => write!(f, "{} on {node} dies", any(manager)),
            Self::ManagerHangs { node, manager } => write!(f, "{} on {node} hangs", any(manager)),
            Self::ManagersFailToStart { node, lasts } => {
                write!(f, "managers on {node} fail to start, for {}", time(*lasts))
            }
            Self::ModuleFails {
                node,
                type_name,
                lasts,
            } => {
                write!(
                    f,
                    "the module of {type_name} on {node} fails, {}",
                    lasting(*lasts)
                )
            }
            Self::Misbehaves {
                instance,
                how,
                lasts,
            } => {
                let how = serde_json::to_value(how).unwrap_or_default();
                let how = how.as_str().unwrap_or_default();
                write!(f, "{instance} misbehaves: {how}, {}", lasting(*lasts))
            }
            Self::Usurper => write!(f, "a controller from a backup takes over"),
        }
    }
}
