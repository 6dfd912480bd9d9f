//! The report as a JUnit file: one test suite for the system, one test case for each check.

use quick_junit::{NonSuccessKind, Report as File, TestCase, TestCaseStatus, TestSuite};

use super::report::{Ending, Outcome, Report};
use crate::error::CliError;

/// The text of the file.
pub fn render(report: &Report) -> Result<String, CliError> {
    let name = format!("rtsctl smoke {}", report.system);
    let mut suite = TestSuite::new(report.system.as_str());
    suite.set_time(report.took);
    let (count, all) = report.stand_ins;
    suite.add_property((
        "stand-ins",
        format!("{count} of {all} are stand-ins").as_str(),
    ));
    // With the first that failed: it is long.
    let mut evidence = Some(report.evidence_text());
    for outcome in &report.outcomes {
        let mut case = TestCase::new(outcome.check.name(), status(outcome));
        case.set_classname(format!("smoke.{}", report.system));
        case.set_time(outcome.took);
        if let Some(text) = evidence.take_if(|_| matches!(outcome.ending, Ending::Failed(_))) {
            case.set_system_out(text);
        }
        suite.add_test_case(case);
    }
    let mut file = File::new(name);
    file.set_time(report.took).add_test_suite(suite);
    let text = file.to_string();
    Ok(text.map_err(std::io::Error::other)?)
}

fn status(outcome: &Outcome) -> TestCaseStatus {
    match &outcome.ending {
        Ending::Passed(_) => TestCaseStatus::success(),
        Ending::Skipped(reason) => {
            let mut skipped = TestCaseStatus::skipped();
            skipped.set_message(reason.as_str());
            skipped
        }
        Ending::Failed(failure) => {
            let mut failed = TestCaseStatus::non_success(NonSuccessKind::Failure);
            failed
                .set_message(failure.message.as_str())
                .set_type("smoke");
            failed.set_description(failure.details.join("\n"));
            failed
        }
    }
}
