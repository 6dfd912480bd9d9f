//! A plan for tests.

use rts_controller_api::requests::PlanResult;
use rts_plan::desired::ManagerKey;
use rts_plan::plan::{Action, Change, Plan, Step, Work};

/// A plan of two steps with a wait.
pub fn result() -> PlanResult {
    let step = |id: u32, needs: &[u32], target: &str, work| Step {
        needs: needs.to_vec(),
        reason: "is not there yet".to_owned(),
        ..Step::new(id, "local", target, work)
    };
    let manager = ManagerKey {
        system: None,
        name: "main".to_owned(),
    };
    let activate = Work::Activate {
        manager: manager.clone(),
        instance: "Sine0".to_owned(),
    };
    let start = Work::StartManager { manager };
    let mut steps = vec![
        step(1, &[], "manager/main", start),
        step(2, &[1], "component/Sine0", activate),
    ];
    steps[1].wait_ms = 500;
    let plan = Plan {
        changes: vec![Change {
            action: Action::Add,
            target: "component/Sine0".to_owned(),
            system: Some("hello".to_owned()),
            node: None,
            reason: "is not there yet".to_owned(),
            fields: Vec::new(),
        }],
        critical_path: vec![1, 2],
        steps,
        notes: vec!["preference dropped".to_owned()],
        ..Plan::default()
    };
    PlanResult {
        index: 3,
        digest: "0123abcd".to_owned(),
        plan,
        notes: vec![
            "host h is node local".to_owned(),
            "preference dropped".to_owned(),
        ],
    }
}
