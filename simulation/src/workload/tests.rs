use super::*;
use crate::seed::Seed;

#[test]
fn systems_and_their_changes_have_no_fault() {
    for seed in 0..300 {
        let stream = Seed(seed).stream("workload");
        let mut spec = random(&stream, "alpha", 'A', 3);
        for _ in 0..5 {
            let findings = rts_schemas::check::spec_by_pointer(&spec);
            let faults: Vec<_> = findings
                .iter()
                .filter(|(_, f)| f.severity == rts_schemas::diagnostic::Severity::Error)
                .collect();
            assert!(faults.is_empty(), "{seed}: {faults:#?}");
            assert_eq!(rts_plan::check_orders(&spec), [], "{seed}: {spec:#?}");
            spec = change(&stream, &spec.clone(), 3).make(&spec);
        }
    }
}

#[test]
fn a_component_that_is_left_out_is_named_nowhere() {
    for seed in 0..100 {
        let stream = Seed(seed).stream("workload");
        let spec = without(&random(&stream, "alpha", 'A', 3), "A0");
        let text = serde_json::to_string(&spec).unwrap();
        assert!(!text.contains("\"A0\""), "{text}");
    }
}
