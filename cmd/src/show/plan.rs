//! Plans on stdout, as text or as the JSON that scripts may rely on.

use clap::ValueEnum;
use rts_controller_api::requests::PlanResult;
use rts_plan::plan::Plan;
use rts_schemas::system::SystemSpec;

use crate::error::CliError;
use crate::output::Output;
use crate::show::table::Table;

/// How to print a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlanFormat {
    /// For people
    Text,
    /// JSON
    Json,
    /// YAML
    Yaml,
}

/// Option of verbs that print a plan.
#[derive(Debug, Clone, clap::Args)]
pub struct PlanFormatArgs {
    /// How to print
    #[arg(short, long, value_name = "FORMAT", default_value = "text")]
    pub output: PlanFormat,
}

/// Prints what changes and what restarts, with the remarks.
pub fn print(result: &PlanResult, format: PlanFormat, out: &Output) -> Result<(), CliError> {
    match format {
        PlanFormat::Text => {
            remarks(result, out);
            out.result(&rts_plan::render::render(&result.plan))
        }
        PlanFormat::Json => out.result(&format!("{:#}", value(result))),
        PlanFormat::Yaml => {
            let text = serde_yaml::to_string(&value(result)).map_err(std::io::Error::other)?;
            out.result(&text)
        }
    }
}

/// The same, and in text every step too.
pub fn print_with_steps(
    result: &PlanResult,
    format: PlanFormat,
    out: &Output,
) -> Result<(), CliError> {
    if format == PlanFormat::Text && !result.plan.steps.is_empty() {
        out.result(&steps(&result.plan).render(true, false))?;
        out.result("\n")?;
    }
    print(result, format, out)
}

fn steps(plan: &Plan) -> Table {
    let mut table = Table::new(&["STEP", "KIND", "TARGET", "NODE", "NEEDS"]);
    for step in &plan.steps {
        let needs = step.needs.iter().map(ToString::to_string);
        table.row([
            step.id.to_string(),
            step.work.kind().to_owned(),
            step.target.clone(),
            step.node.clone(),
            needs.collect::<Vec<_>>().join(","),
        ]);
    }
    table
}

/// True when a plan has something to do, or something that waits, for a system; other systems' affairs do not count.
pub fn concerns(plan: &Plan, spec: &SystemSpec) -> bool {
    let own = |system: Option<&str>| system.is_none_or(|system| system == spec.name);
    plan.changes.iter().any(|c| own(c.system.as_deref()))
        || plan
            .steps
            .iter()
            .any(|s| own(s.system.as_ref().map(|s| s.name.as_str())))
        || plan.waiting_on.iter().any(|w| is_of(&w.target, spec))
}

/// True when a target is a part of the system, or something that it may need.
fn is_of(target: &str, spec: &SystemSpec) -> bool {
    let (kind, name) = target.split_once('/').unwrap_or((target, ""));
    let at = name.rsplit_once('@');
    match kind {
        "component" => spec.components.iter().any(|c| c.instance == name),
        "connector" => spec.connectors.iter().any(|c| c.name == name),
        "manager" => owns(spec, name),
        "module" => at.is_some_and(|(_, manager)| owns(spec, manager)),
        "package" => at
            .is_some_and(|(type_name, _)| spec.components.iter().any(|c| c.type_name == type_name)),
        // Which nodes it needs is for the controller to know: rather a difference too many than one that is hidden.
        _ => true,
    }
}

fn owns(spec: &SystemSpec, manager: &str) -> bool {
    manager
        .split_once('.')
        .is_some_and(|(system, _)| system == spec.name)
}

/// A line for each process of a system that restarts, with what that stops.
pub fn restarts(plan: &Plan, spec: &SystemSpec) -> Vec<String> {
    let own = plan.restarts.iter().filter(|r| owns(spec, &r.manager));
    let alone = Plan {
        restarts: own.cloned().collect(),
        ..Plan::default()
    };
    let text = rts_plan::render::render(&alone);
    let lines = text.lines().filter(|line| line.starts_with("restarts: "));
    lines.map(str::to_owned).collect()
}

/// What is said of the system beyond the plan's own notes, which its text has.
fn remarks(result: &PlanResult, out: &Output) {
    let notes = result
        .notes
        .iter()
        .filter(|note| !result.plan.notes.contains(note));
    for note in notes {
        out.say(&format!("note: {note}"));
    }
}

/// `changes`, `steps`, `restarts`, `waitingOn`, `notes`: the plan's, and the remarks about the system among the notes.
fn value(result: &PlanResult) -> serde_json::Value {
    let mut plan = result.plan.clone();
    let more = result
        .notes
        .iter()
        .filter(|note| !result.plan.notes.contains(note));
    plan.notes.splice(0..0, more.cloned());
    serde_json::json!(plan)
}

#[cfg(test)]
mod tests {
    use rts_plan::plan::{Action, Change, Step, Work};

    use super::*;

    fn result() -> PlanResult {
        let step = |id: u32, needs: &[u32], target: &str, work| Step {
            id,
            node: "local".to_owned(),
            target: target.to_owned(),
            system: None,
            needs: needs.to_vec(),
            after_start_of: Vec::new(),
            after_end_of: Vec::new(),
            limits: Vec::new(),
            because: Vec::new(),
            wait_ms: 0,
            reason: "it is not there".to_owned(),
            work,
        };
        let manager = rts_plan::desired::ManagerKey {
            system: None,
            name: "main".to_owned(),
        };
        let activate = Work::Activate {
            manager: manager.clone(),
            instance: "Sine0".to_owned(),
        };
        let plan = Plan {
            changes: vec![Change {
                action: Action::Add,
                target: "component/Sine0".to_owned(),
                system: Some("hello".to_owned()),
                reason: "it is not there".to_owned(),
                fields: Vec::new(),
            }],
            steps: vec![
                step(1, &[], "manager/main", Work::StartManager { manager }),
                step(2, &[1], "component/Sine0", activate),
            ],
            notes: vec!["preference dropped".to_owned()],
            ..Plan::default()
        };
        PlanResult {
            index: 3,
            digest: plan.digest(),
            plan,
            notes: vec![
                "host h is node local".to_owned(),
                "preference dropped".to_owned(),
            ],
        }
    }

    #[test]
    fn steps_are_listed_with_what_they_need() {
        insta::assert_snapshot!(steps(&result().plan).render(true, false), @r"
        STEP  KIND          TARGET           NODE   NEEDS
        1     StartManager  manager/main     local  -
        2     Activate      component/Sine0  local  1
        ");
    }

    fn hello() -> SystemSpec {
        let text = include_bytes!("../../../manifests/hello/system.xml");
        rts_schemas::rts_profile::load("hello.xml", text, None, &[])
            .unwrap()
            .0
    }

    #[test]
    fn what_waits_is_a_difference_and_what_others_wait_for_is_not() {
        let mut plan = Plan::default();
        assert!(!concerns(&plan, &hello()));
        let waits = |target: &str| rts_plan::plan::WaitingOn {
            target: target.to_owned(),
            reason: "its module failed".to_owned(),
            transient: false,
        };
        plan.waiting_on = vec![waits("component/Elsewhere0"), waits("manager/other.main")];
        assert!(!concerns(&plan, &hello()));
        for target in [
            "component/Sine0",
            "manager/hello.main",
            "package/Printer@local",
            "node/local",
            "module/Printer@hello.main",
        ] {
            plan.waiting_on = vec![waits(target)];
            assert!(concerns(&plan, &hello()), "{target}");
        }
        assert!(concerns(&result().plan, &hello()));
    }

    #[test]
    fn only_own_restarts_are_told() {
        let restart = |manager: &str| rts_plan::plan::Restart {
            node: "local".to_owned(),
            manager: manager.to_owned(),
            pid: Some(7),
            components: vec!["Sine0".to_owned()],
            reason: "type changed".to_owned(),
        };
        let plan = Plan {
            restarts: vec![restart("hello.main"), restart("hello2.main")],
            ..Plan::default()
        };
        let lines = restarts(&plan, &hello());
        assert_eq!(lines.len(), 1);
        assert!(
            lines[0].starts_with("restarts: process hello.main (pid 7)"),
            "{lines:?}"
        );
    }

    #[test]
    fn json_has_what_scripts_rely_on() {
        let value = value(&result());
        assert_eq!(value["changes"][0]["action"], "add");
        assert_eq!(value["changes"][0]["target"], "component/Sine0");
        assert_eq!(value["changes"][0]["reason"], "it is not there");
        assert_eq!(value["steps"][1]["kind"], "Activate");
        assert_eq!(value["steps"][1]["needs"], serde_json::json!([1]));
        assert!(value["restarts"].is_array());
        let notes = serde_json::json!(["host h is node local", "preference dropped"]);
        assert_eq!(value["notes"], notes);
    }
}
