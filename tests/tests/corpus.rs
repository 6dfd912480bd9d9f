//! Every profile that users wrote and that has no error gets a plan: its orders form no cycle, and a plan from nothing
//! creates and activates each of its components.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rts_plan::check::check_orders;
use rts_plan::desired::SystemRef;
use rts_plan::observed::{Inventory, NodeObserved, Observed};
use rts_plan::place::{NodeFacts, StoredSystem, place};
use rts_plan::plan::{Blocked, Work};
use rts_schemas::rts_profile::load;
use rts_schemas::system::SystemSpec;

fn files(corpus: &str) -> Vec<PathBuf> {
    let folders = ["rts", "derived"].map(|name| PathBuf::from(corpus).join(name));
    let entries = folders
        .iter()
        .flat_map(|f| std::fs::read_dir(f).expect("a folder of the corpus"));
    let mut files: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.retain(|file| file.extension().is_none_or(|e| e != "tsv"));
    files.sort();
    files
}

fn every_component_is_planned(spec: SystemSpec) {
    let wanted = spec.components.len();
    let system = StoredSystem {
        reference: SystemRef {
            name: spec.name.clone(),
            uid: "uid".to_owned(),
        },
        spec,
        module_digests: BTreeMap::new(),
        stand_ins: Default::default(),
        deleting: false,
    };
    let node = NodeFacts {
        name: "local".to_owned(),
        aliases: Vec::new(),
    };
    let placed = place(&[system], &[node], "local");
    let nothing = Inventory {
        node: "local".to_owned(),
        ..Inventory::default()
    };
    let observed = Observed {
        nodes: BTreeMap::from([("local".to_owned(), NodeObserved::Known(nothing))]),
    };
    let plan = rts_plan::plan(&placed.desired, &observed, &Blocked::new());
    let count = |kind: &str| plan.steps.iter().filter(|s| s.work.kind() == kind).count();
    assert_eq!(
        (count("Create"), count("Activate")),
        (wanted, wanted),
        "{plan}"
    );
    let late = plan
        .steps
        .iter()
        .find(|s| s.needs.iter().any(|need| *need >= s.id));
    assert!(
        late.is_none(),
        "a step comes before one that it needs: {late:?}"
    );
    let early = |s: &&rts_plan::plan::Step| {
        matches!(s.work, Work::StartManager { .. }) && !s.needs.is_empty()
    };
    assert!(
        !plan.steps.iter().any(|s| early(&s)),
        "processes start at once"
    );
}

#[test]
fn every_real_profile_without_an_error_gets_a_plan() {
    let Ok(corpus) = std::env::var("RTSCTL_CORPUS") else {
        println!("skipped: RTSCTL_CORPUS is not set");
        return;
    };
    let (mut planned, mut refused) = (0, Vec::new());
    for file in files(&corpus) {
        let name = file
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let bytes = std::fs::read(&file).expect("a file of the corpus");
        match load(&name, &bytes, Some("corpus"), &[]) {
            Err(_) => refused.push(name),
            Ok((spec, _)) => {
                assert_eq!(check_orders(&spec), [], "{name}");
                every_component_is_planned(spec);
                planned += 1;
            }
        }
    }
    println!("{planned} profiles planned; with errors of their own: {refused:?}");
    assert!(
        planned >= 85 && refused.len() <= 3,
        "{planned} planned, refused: {refused:?}"
    );
}
