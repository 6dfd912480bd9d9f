//! What happened in a simulation, on stdout.

use rts_controller_api::simulate::{Simulated, SimulatedEnd};

use crate::error::CliError;
use crate::local::plural;
use crate::output::Output;
use crate::show::plan::{PlanFormat, yaml};
use crate::show::table::Table;

/// How to print it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// For people.
    Text,
    /// JSON.
    Json,
    /// YAML.
    Yaml,
}

impl Format {
    /// As the option says: a simulation is no graph.
    pub fn of(format: PlanFormat) -> Result<Self, CliError> {
        match format {
            PlanFormat::Text => Ok(Self::Text),
            PlanFormat::Json => Ok(Self::Json),
            PlanFormat::Yaml => Ok(Self::Yaml),
            PlanFormat::Dot | PlanFormat::Mermaid => Err(CliError::usage_help(
                "a simulation is not shown as a graph",
                "use `-o text`, `-o json` or `-o yaml`, or leave out --simulate",
            )),
        }
    }
}

/// Prints it.
pub fn print(result: &Simulated, format: Format, out: &Output) -> Result<(), CliError> {
    let value = || serde_json::to_value(result).map_err(std::io::Error::other);
    match format {
        Format::Text => {
            for note in &result.notes {
                out.say(&format!("note: {note}"));
            }
            out.result(&text(result, out.stdout_color()))
        }
        Format::Json => out.result(&format!("{:#}", value()?)),
        Format::Yaml => out.result(&yaml(&value()?)?),
    }
}

/// The faults, what happened, and the end.
fn text(result: &Simulated, color: bool) -> String {
    let mut text = String::new();
    for fault in &result.faults {
        text.push_str(&format!("fault: {fault}\n"));
    }
    for fault in &result.never_came {
        text.push_str(&format!("never came: {fault}\n"));
    }
    text.push_str(&happened(result).render(true, false));
    if result.omitted > 0 {
        let more = plural(
            "event",
            usize::try_from(result.omitted).unwrap_or(usize::MAX),
        );
        text.push_str(&format!("({more} more; `-o json` shows no more either)\n"));
    }
    text.push('\n');
    text.push_str(&components(&result.end).render(true, color));
    for undone in &result.end.undone {
        text.push_str(&format!("undone: {}: {}\n", undone.object, undone.reason));
    }
    text.push_str(&summary(result));
    text.push('\n');
    text
}

fn happened(result: &Simulated) -> Table {
    let mut table = Table::new(&["TIME", "STEP", "OBJECT", "REASON", "MESSAGE"]);
    for event in &result.events {
        table.row([
            seconds(event.at_ms),
            event.step.map_or_else(String::new, |step| step.to_string()),
            event.object.clone(),
            event.reason.clone(),
            event.message.clone(),
        ]);
    }
    table
}

fn components(end: &SimulatedEnd) -> Table {
    let mut table = Table::new(&[
        "SYSTEM",
        "COMPONENT",
        "NODE",
        "MANAGER",
        "STATE",
        "RESTARTS",
    ]);
    for component in &end.components {
        table.row([
            component.system.clone().unwrap_or_default(),
            component.name.clone(),
            component.node.clone(),
            component.manager.clone(),
            component.state.clone(),
            component.restarts.to_string(),
        ]);
    }
    table
}

/// How it ended, in a line.
fn summary(result: &Simulated) -> String {
    let Simulated { end, seed, .. } = result;
    match (end.converged, end.converged_ms) {
        (true, Some(at)) => format!("converged after {} (seed {seed})", seconds(at)),
        (true, None) => format!("converged (seed {seed})"),
        (false, _) => {
            let bad = |s: &&rts_controller_api::simulate::SimulatedSystem| !(s.synced && s.healthy);
            let systems = end.systems.iter().filter(bad).map(|system| {
                let synced = if system.synced {
                    "synced"
                } else {
                    "not synced"
                };
                let healthy = if system.healthy {
                    "healthy"
                } else {
                    "not healthy"
                };
                format!("system/{} is {synced}, {healthy}", system.name)
            });
            let systems: Vec<String> = systems.collect();
            let after = seconds(end.simulated_ms);
            let what = if systems.is_empty() {
                String::new()
            } else {
                format!(": {}", systems.join("; "))
            };
            format!("not converged after {after}{what} (seed {seed})")
        }
    }
}

fn seconds(ms: u64) -> String {
    format!("{}.{:03}s", ms / 1000, ms % 1000)
}

#[cfg(test)]
mod tests {
    use rts_controller_api::simulate::{
        SimulatedComponent, SimulatedEvent, SimulatedSystem, Undone,
    };

    use super::*;

    fn sample(converged: bool) -> Simulated {
        let event = |at_ms, object: &str, reason: &str, step| SimulatedEvent {
            at_ms,
            object: object.to_owned(),
            reason: reason.to_owned(),
            message: format!("about {object}"),
            step,
        };
        Simulated {
            seed: 7,
            faults: vec!["agent local drops at step 1 for 3s".to_owned()],
            notes: Vec::new(),
            plan: Default::default(),
            events: vec![
                event(0, "system/hello", "Applied", None),
                event(52, "manager/hello.main", "StepStarted", Some(1)),
                event(12_004, "node/local", "NodeUnknown", None),
            ],
            omitted: u64::from(!converged),
            never_came: match converged {
                true => Vec::new(),
                false => vec!["agent local drops at step 1 for 3s".to_owned()],
            },
            end: SimulatedEnd {
                converged,
                converged_ms: converged.then_some(14_250),
                simulated_ms: 300_000,
                systems: vec![SimulatedSystem {
                    name: "hello".to_owned(),
                    synced: true,
                    healthy: converged,
                }],
                components: vec![SimulatedComponent {
                    name: "Sine0".to_owned(),
                    system: Some("hello".to_owned()),
                    node: "local".to_owned(),
                    manager: "main".to_owned(),
                    state: if converged { "Active" } else { "Error" }.to_owned(),
                    restarts: 2,
                }],
                undone: match converged {
                    true => Vec::new(),
                    false => vec![Undone {
                        object: "component/Sine0".to_owned(),
                        reason: "on_activated returned ERROR".to_owned(),
                    }],
                },
            },
        }
    }

    #[test]
    fn it_is_told_line_by_line() {
        insta::assert_snapshot!(format!(
            "{}\n{}",
            text(&sample(true), false),
            text(&sample(false), false)
        ));
    }

    #[test]
    fn a_graph_is_refused() {
        assert!(Format::of(PlanFormat::Dot).is_err());
        assert_eq!(Format::of(PlanFormat::Yaml).unwrap(), Format::Yaml);
    }
}
