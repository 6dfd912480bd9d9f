//! Any bytes as an overlay, laid over the example system.
#![no_main]

#[path = "../counting.rs"]
mod counting;

use libfuzzer_sys::fuzz_target;
use rts_schemas::diagnostic::{Report, render};
use rts_schemas::{check, overlay, rts_profile};

const SYSTEM: &[u8] = include_bytes!("../../manifests/hello/system.xml");

fuzz_target!(|bytes: &[u8]| {
    match counting::bounded(bytes, |bytes| overlay::read("overlay.yaml", bytes)) {
        Ok(overlay) => {
            let (mut spec, _) =
                rts_profile::load("system.xml", SYSTEM, None, &[]).expect("the example is right");
            let report = overlay::apply(&mut spec, &overlay);
            // A refused value changes nothing, so the system stays sound whatever the overlay says.
            assert_eq!(check::spec(&spec), Report::default());
            report.findings.iter().for_each(|finding| drop(render(finding)));
            // What is written says the same.
            let text = overlay::write(&overlay.deployment);
            let again = overlay::read("again.yaml", text.as_bytes()).expect("what is written is right");
            assert_eq!(overlay::write(&again.deployment), text);
        }
        Err(report) => assert!(report.has_errors()),
    }
});
