//! The agent with the real manager program, when it was built.

use std::path::PathBuf;

use rts_agent::Config;

use crate::setup::{Node, lives};
use rts_agent_api::AgentApi;
use rts_agent_api::messages::ModuleRequest;

/// `rts-manager` beside the test programs' folder.
fn program() -> Option<PathBuf> {
    let test = std::env::current_exe().ok()?;
    let program = test.parent()?.parent()?.join("rts-manager");
    program.exists().then_some(program)
}

#[tokio::test]
async fn the_real_manager_starts_outlives_the_agent_and_is_adopted() {
    let Some(program) = program() else {
        println!("skipped: build rts-manager first (cargo build -p rtsctl)");
        return;
    };
    let home = tempfile::Builder::new()
        .prefix("rts")
        .tempdir_in("/tmp")
        .unwrap();
    let config = Config {
        home: home.path().to_owned(),
        node: "local".to_owned(),
        aliases: Vec::new(),
        module_path: vec![home.path().to_owned()],
        manager_program: program,
        controller_socket: None,
    };
    std::fs::write(home.path().join("libnothing.so"), "no library").unwrap();
    let mut node = Node::of(home, config).await;
    let request = ModuleRequest {
        type_name: "Nothing".to_owned(),
    };
    let refused = crate::setup::problem(node.agent.load_module("bench", &request).await);
    assert_eq!(refused.code, "load-failed", "{}", refused.detail);
    let before = node.until(|i| i.managers.len() == 1).await;
    assert!(before.managers[0].responsive);
    node.stop().await;
    node.start_again().await;
    let after = node.agent.inventory().await.unwrap();
    assert_eq!(after.managers, before.managers);
    assert!(lives(after.managers[0].pid));
}
