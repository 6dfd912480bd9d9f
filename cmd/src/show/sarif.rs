//! Findings as SARIF 2.1.0, which code hosts and editors read.

use std::collections::BTreeMap;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use rts_schemas::codes;
use rts_schemas::diagnostic::{Finding, Place, Report, Severity};
use serde_json::{Value, json};

/// What stays as it is in the path of a URI.
const PATH: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'/')
    .remove(b'-')
    .remove(b'_')
    .remove(b'.')
    .remove(b'~');

/// The whole log. Columns count characters, as in the other formats.
pub fn document(report: &Report) -> Value {
    let findings = &report.findings;
    let names: BTreeMap<&str, ()> = findings.iter().map(|f| (f.code.as_str(), ())).collect();
    let rules: Vec<&str> = names.into_keys().collect();
    let results = findings.iter().map(|finding| result(finding, &rules));
    json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "rtsctl",
                "semanticVersion": env!("CARGO_PKG_VERSION"),
                "informationUri": env!("CARGO_PKG_REPOSITORY"),
                "rules": rules.iter().map(|code| rule(code)).collect::<Vec<_>>(),
            } },
            "columnKind": "unicodeCodePoints",
            "results": results.collect::<Vec<_>>(),
        }],
    })
}

fn rule(code: &str) -> Value {
    let Some(known) = codes::find(code) else {
        return json!({ "id": code });
    };
    json!({
        "id": code,
        "shortDescription": { "text": known.title },
        "fullDescription": { "text": known.title },
        "help": { "text": known.explain.trim() },
    })
}

fn result(finding: &Finding, rules: &[&str]) -> Value {
    let level = match finding.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    let text = match &finding.help {
        Some(help) => format!("{}\nhelp: {help}", finding.message),
        None => finding.message.clone(),
    };
    let mut result = json!({
        "ruleId": finding.code,
        "ruleIndex": rules.binary_search(&finding.code.as_str()).unwrap_or_default(),
        "level": level,
        "message": { "text": text },
    });
    if let Some(place) = &finding.place {
        result["locations"] = json!([{ "physicalLocation": location(place) }]);
    }
    result
}

fn location(place: &Place) -> Value {
    json!({
        "artifactLocation": { "uri": uri(&place.file) },
        "region": {
            "startLine": place.line,
            "startColumn": place.column,
            "endLine": place.line,
            "endColumn": place.column + place.length,
        },
    })
}

/// A path as a URI: one from here stays relative.
fn uri(file: &str) -> String {
    let plain = file.strip_prefix("./").unwrap_or(file);
    let path = utf8_percent_encode(plain, PATH);
    match file.starts_with('/') {
        true => format!("file://{path}"),
        false => path.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_uris() {
        let all = ["./a b/系.xml", "/x/y.xml", "<stdin>"].map(uri);
        assert_eq!(
            all,
            ["a%20b/%E7%B3%BB.xml", "file:///x/y.xml", "%3Cstdin%3E"]
        );
    }

    #[test]
    fn a_finding_without_place_has_no_location() {
        let report = Report {
            findings: vec![Finding::warning("no-such-code", "odd")],
        };
        let log = document(&report);
        let result = &log["runs"][0]["results"][0];
        assert_eq!(result["level"], "warning");
        assert!(result.get("locations").is_none());
        assert_eq!(
            log["runs"][0]["tool"]["driver"]["rules"][0]["id"],
            "no-such-code"
        );
    }
}
