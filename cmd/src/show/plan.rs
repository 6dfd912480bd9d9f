//! Plans on stdout, as text or as the JSON that scripts may rely on.

use clap::ValueEnum;
use rts_controller_api::requests::PlanResult;
use rts_plan::plan::Plan;

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
