use std::time::Duration;

use rts_plan::observed::Inventory;

use super::*;
use crate::fleet::http_agent;

fn greeting(session: &str) -> SessionGreeting {
    SessionGreeting {
        protocol_version: PROTOCOL_VERSION,
        version: "0.1.0".into(),
        session: session.into(),
        endpoint: "/nowhere".into(),
        aliases: Vec::new(),
        ledger: None,
        inventory: Inventory::default(),
    }
}

fn greet(sessions: &Sessions, session: &str) -> Result<bool, Problem> {
    let agent = Arc::new(http_agent("/nowhere").unwrap());
    let now = Timestamp::UNIX_EPOCH;
    sessions.greet("n", greeting(session), agent, "uid".into(), now)
}

fn beat(sessions: &Sessions, session: &str, revision: u64) -> Result<Beat, u16> {
    sessions
        .beat("n", session, revision, Timestamp::UNIX_EPOCH)
        .map_err(|problem| problem.status)
}

#[tokio::test(start_paused = true)]
async fn the_newest_session_wins_and_the_old_one_is_told() {
    let sessions = Sessions::default();
    assert_eq!(beat(&sessions, "a", 0), Err(404));
    assert!(greet(&sessions, "a").unwrap());
    assert!(
        !greet(&sessions, "a").unwrap(),
        "a repeated greeting is no new session"
    );
    assert!(greet(&sessions, "b").unwrap());
    assert_eq!(beat(&sessions, "a", 0), Err(409));
    assert_eq!(greet(&sessions, "a").unwrap_err().code, "superseded");
    assert_eq!(beat(&sessions, "c", 0), Err(404));
    assert!(beat(&sessions, "b", 1).unwrap().inventory_changed);
    assert!(!beat(&sessions, "b", 1).unwrap().inventory_changed);
}

#[tokio::test(start_paused = true)]
async fn three_seconds_of_silence_make_a_node_unknown_and_a_heartbeat_brings_it_back() {
    let sessions = Sessions::default();
    greet(&sessions, "a").unwrap();
    tokio::time::advance(Duration::from_millis(2900)).await;
    assert!(sessions.expire().0.is_empty());
    tokio::time::advance(Duration::from_millis(100)).await;
    assert_eq!(sessions.expire().0, ["n"]);
    assert_eq!(sessions.get("n").unwrap().state(), "Unknown");
    tokio::time::timeout(Duration::from_secs(1), sessions.ended("n", "a"))
        .await
        .unwrap();
    assert!(beat(&sessions, "a", 0).unwrap().back);
    assert_eq!(sessions.get("n").unwrap().state(), "Ready");
}

#[tokio::test(start_paused = true)]
async fn the_time_out_of_an_old_session_does_not_touch_the_new_one() {
    let sessions = Sessions::default();
    greet(&sessions, "a").unwrap();
    tokio::time::advance(Duration::from_millis(2900)).await;
    greet(&sessions, "b").unwrap();
    tokio::time::advance(Duration::from_millis(200)).await;
    assert!(sessions.expire().0.is_empty());
}

#[tokio::test]
async fn another_protocol_names_the_side_to_upgrade() {
    let sessions = Sessions::default();
    let mut greeting = greeting("a");
    greeting.protocol_version = PROTOCOL_VERSION + 1;
    let agent = Arc::new(http_agent("/nowhere").unwrap());
    let refused = sessions.greet("n", greeting, agent, "u".into(), Timestamp::UNIX_EPOCH);
    insta::assert_snapshot!(refused.unwrap_err(), @"the agent of node n speaks protocol 2, this controller 1: upgrade rts-controller");
}
