//! Findings on stderr.

use rts_schemas::diagnostic::{Finding, Report, Severity, render};

use crate::output::{Output, severity_style};

/// Prints all findings: errors always, warnings unless less is wanted, notes when more is.
pub fn print(report: &Report, out: &Output) {
    for finding in &report.findings {
        let text = colored(finding);
        match finding.severity {
            Severity::Error => out.stderr(&text),
            Severity::Warning => out.say(&text),
            Severity::Note => out.detail(&text),
        }
    }
}

/// All findings as one text, notes too, with a blank line between them.
pub fn text(report: &Report) -> String {
    let all: Vec<String> = report.findings.iter().map(colored).collect();
    all.join("\n\n")
}

/// The text with the severity and code in colour; the output takes colour away where it is not wanted.
fn colored(finding: &Finding) -> String {
    let text = render(finding);
    let style = severity_style(finding.severity);
    match text.split_once("]: ") {
        Some((head, rest)) => format!("{style}{head}]{style:#}: {rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_severity_is_coloured_and_the_message_is_not() {
        let finding = Finding::error("unknown-port", "no port [x]: out").help("did you mean in?");
        let text = colored(&finding);
        let plain = anstream::adapter::strip_str(&text).to_string();
        assert_eq!(plain, render(&finding));
        assert!(text.starts_with("\u{1b}[1m\u{1b}[31merror[unknown-port]\u{1b}[0m: no port"));
    }
}
