//! Profiles that users wrote. Some run with stand-ins in real processes; of all, every one that has no error gets a plan:
//! its orders form no cycle, and a plan from nothing creates and activates each of its components.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rts_plan::check::check_orders;
use rts_plan::desired::SystemRef;
use rts_plan::observed::{Inventory, NodeObserved, Observed};
use rts_plan::place::{NodeFacts, StoredSystem, place};
use rts_plan::plan::{Blocked, Work};
use rts_schemas::rts_profile::load;
use rts_schemas::system::SystemSpec;
use rts_tests::Stack;
use serde_json::Value;

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
        nodes: BTreeMap::from([("local".to_owned(), NodeObserved::Known(nothing.into()))]),
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
        planned >= 85 && refused.len() <= 4,
        "{planned} planned, refused: {refused:?}"
    );
}

/// Applies a profile with stand-ins alone: all are Active, and samples arrive on every data connector.
fn runs_with_stand_ins(profile: &str, components: usize, data: usize) {
    let Ok(corpus) = std::env::var("RTSCTL_CORPUS") else {
        println!("skipped: RTSCTL_CORPUS is not set");
        return;
    };
    let file = format!("{corpus}/rts/{profile}");
    let stack = Stack::new();
    stack.expect(0, &["up"]);
    let most = (components - 1).to_string();
    let refused = stack.expect(
        3,
        &["apply", &file, "--stand-ins", "--max-stand-ins", &most],
    );
    assert!(refused.err.contains("would be a stand-in"), "{refused:#?}");
    assert!(stack.get("systems").is_empty());

    let said = stack.expect(0, &["apply", &file, "--stand-ins"]);
    let told = format!("{components} of {components} are stand-ins");
    assert!(said.out.contains(&told), "{said:#?}");
    let all = stack.get("components");
    assert_eq!(all.len(), components);
    for component in &all {
        let status = &component["status"];
        assert_eq!(
            (&status["state"], &status["standIn"]),
            (&"Active".into(), &true.into())
        );
    }
    let flowing = |connectors: &[Value]| {
        let data_ones = connectors.iter().filter(|c| c["spec"]["kind"] == "data");
        let received = data_ones.map(|c| c["status"]["samplesReceived"].as_u64());
        let received: Vec<_> = received.collect();
        received.len() == data && received.iter().all(|count| *count >= Some(3))
    };
    stack.until("connectors", "samples arrive everywhere", flowing);

    // What was decided is in the export, which needs no option.
    let system = stack.get("systems").remove(0);
    let name = system["metadata"]["name"].as_str().expect("a name");
    let exported = stack.expect(0, &["export", name]).out;
    let exported = stack.write("exported.xml", exported);
    let again = stack.expect(
        0,
        &["apply", &exported.display().to_string(), "--name", name],
    );
    assert!(again.out.contains("no changes"), "{again:#?}");
    stack.expect(0, &["teardown", name, "--yes"]);
    stack.leaves_nothing();
}

#[test]
fn a_crawler_runs_with_stand_ins() {
    runs_with_stand_ins("Nobu19800__CrawlerSystem__Crawler.rtsys", 8, 8);
}

#[test]
fn a_simulated_robot_runs_with_stand_ins_whose_types_nobody_here_knows() {
    runs_with_stand_ins(
        "sugarsweetrobotics__vrep_mcl_test__MobileRobotSystem.xml",
        6,
        7,
    );
}
