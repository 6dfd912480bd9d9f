//! What shows why a check failed: the plan, what happened, and the last log lines of the components in question.

use std::time::Duration;

use rts_agent_api::messages::LogQuery;
use rts_controller_api::objects::{Event, Kind};
use rts_controller_api::requests::PlanResult;
use rts_plan::plan::Step;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::time::timeout;

use super::check::Check;
use super::context::Context;
use super::report::Report;
use crate::follow::{Log, LogNews};
use crate::show::plan::{self, View};
use crate::show::table::Table;

/// Most components whose log is read.
const LOGS: usize = 3;
/// Lines of each.
const LINES: usize = 20;
/// Most events.
const EVENTS: usize = 60;
/// How long all logs may take.
const PATIENCE: Duration = Duration::from_secs(5);

/// What was gathered.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    plan: Option<PlanResult>,
    events: Vec<Value>,
    /// Whose, and its lines.
    logs: Vec<(String, Vec<String>)>,
}

impl Evidence {
    /// All that can be had.
    pub async fn gather(context: &Context<'_>, report: &Report) -> Self {
        let mut evidence = Self {
            plan: context.plan.clone(),
            ..Self::default()
        };
        if !report.passed(Check::Start) {
            evidence.logs = daemons(context);
        }
        let Ok(controller) = context.controller() else {
            return evidence;
        };
        if let Ok(list) = controller.list::<Value>(Kind::Event).await {
            let from = list.items.len().saturating_sub(EVENTS);
            evidence.events = list.items[from..].to_vec();
        }
        for instance in report.culprits().into_iter().take(LOGS) {
            let component = context.last.component(&instance);
            let node = component.map(|c| c.status.node.clone());
            let Some(node) = node else { continue };
            let query = LogQuery {
                tail: Some(LINES),
                ..LogQuery::default()
            };
            let log = Log::new(&controller, &node, &instance, query);
            let lines = timeout(PATIENCE, lines(log)).await.unwrap_or_default();
            evidence.logs.push((format!("component/{instance}"), lines));
        }
        evidence
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if let Some(result) = &self.plan {
            let plan = plan::text(&result.plan, View::Steps { all: false }, false);
            text.push_str(&format!("\nThe plan:\n{plan}"));
        }
        if !self.events.is_empty() {
            let events = happened(&self.events);
            text.push_str(&format!("\nWhat happened:\n{events}"));
        }
        for (whose, lines) in &self.logs {
            text.push_str(&format!("\nThe last log lines of {whose}:\n"));
            text.extend(lines.iter().map(|line| format!("{line}\n")));
            if lines.is_empty() {
                text.push_str("none\n");
            }
        }
        text
    }

    /// For scripts.
    pub fn json(&self) -> Value {
        let logs = self.logs.iter();
        let logs = logs.map(|(of, lines)| json!({"of": of, "lines": lines}));
        json!({
            "plan": self.plan.as_ref().map(plan::json),
            "events": self.events,
            "logs": logs.collect::<Vec<_>>(),
        })
    }
}

/// Events with the time since the first one.
fn happened(events: &[Value]) -> String {
    let events: Vec<Event> = events
        .iter()
        .filter_map(|e| Event::deserialize(e).ok())
        .collect();
    let first = events.iter().find_map(|event| event.status.time);
    let mut table = Table::new(&["TIME", "TYPE", "REASON", "OBJECT", "MESSAGE"]);
    for event in events {
        let since = event.status.time.zip(first);
        let since = since.map(|(time, first)| time.duration_since(first).as_secs_f64());
        let since = since.map_or_else(String::new, |seconds| format!("{seconds:.3} s"));
        let spec = event.spec;
        table.row([since, spec.kind, spec.reason, spec.object, spec.message]);
    }
    table.render(true, false)
}

async fn lines(mut log: Log) -> Vec<String> {
    let mut lines = Vec::new();
    while let Ok(LogNews::Line(line)) = log.next().await {
        lines.push(line);
    }
    lines
}

/// The ends of the daemons' own logs: their files go with the stack.
fn daemons(context: &Context<'_>) -> Vec<(String, Vec<String>)> {
    let home = context.stack.home();
    let agents = context.stack.nodes.iter().map(|node| {
        let whose = format!("the agent of node {}", node.name);
        (whose, home.agent_log(&node.name))
    });
    let all = std::iter::once(("the controller".to_owned(), home.controller_log())).chain(agents);
    all.filter_map(|(whose, path)| {
        let text = std::fs::read(path).ok()?;
        let text = String::from_utf8_lossy(&text).into_owned();
        let lines: Vec<_> = text.lines().map(str::to_owned).collect();
        let from = lines.len().saturating_sub(LINES);
        Some((whose, lines[from..].to_vec()))
    })
    .collect()
}

/// The chain of steps that the apply could not be faster than, with the times that were seen.
pub fn critical_path(context: &Context<'_>) -> Vec<String> {
    let Some(result) = &context.plan else {
        return Vec::new();
    };
    let step = |id: &u32| result.plan.steps.iter().find(|step| step.id == *id);
    let path = result.plan.critical_path.iter().filter_map(step);
    let lines = path.map(|step| format!("critical path: {}", timed(step, context)));
    lines.collect()
}

/// `3 Activate component/Sine0 (0.25 s)`.
fn timed(step: &Step, context: &Context<'_>) -> String {
    let name = format!("{} {}", step.work.kind(), step.target);
    let seen = context.steps.iter().filter(|(known, ..)| *known == name);
    let times = seen.filter_map(|(_, since, until)| Some(until.as_ref()?.duration_since(*since)));
    let time: Duration = times.sum();
    let time = match time.as_millis() {
        0 => String::new(),
        _ => format!(" ({:.2} s)", time.as_secs_f64()),
    };
    format!("{} {name}{time}", step.id)
}
