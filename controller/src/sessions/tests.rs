use std::time::Duration;

use rts_plan::delta::InventoryDelta;
use rts_plan::desired::ManagerKey;
use rts_plan::observed::{Inventory, ManagerObserved};

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
        transport: None,
    }
}

fn greet(sessions: &Sessions, session: &str) -> Result<bool, Problem> {
    let agent = Arc::new(http_agent("/nowhere").unwrap());
    let now = Timestamp::UNIX_EPOCH;
    sessions.greet("n", greeting(session), agent, "uid".into(), now)
}

fn beat(sessions: &Sessions, session: &str, revision: u64) -> Result<Beat, u16> {
    told(sessions, session, revision, None)
}

fn told(
    sessions: &Sessions,
    session: &str,
    revision: u64,
    delta: Option<InventoryDelta>,
) -> Result<Beat, u16> {
    let mut heartbeat = Heartbeat {
        inventory_revision: revision,
        delta,
        events: Vec::new(),
    };
    sessions
        .beat("n", session, &mut heartbeat, Timestamp::UNIX_EPOCH)
        .map_err(|problem| problem.status)
}

/// Tells of one manager per revision: the newest has the number of the revision.
fn inventory(revision: u64) -> Inventory {
    let manager = |number: u64| ManagerObserved {
        key: ManagerKey {
            system: None,
            name: format!("m{}", number % 3),
        },
        incarnation: format!("i{number}"),
        pid: 1,
        started: String::new(),
        responsive: true,
        unseen: false,
        expired: None,
        modules: Default::default(),
        opened: Default::default(),
        components: Vec::new(),
        activity: Default::default(),
    };
    let first = revision.saturating_sub(2);
    let mut managers: Vec<_> = (first..=revision).map(manager).collect();
    managers.sort_by(|a, b| a.key.cmp(&b.key));
    Inventory {
        node: "n".into(),
        revision,
        managers,
        held: Vec::new(),
    }
}

fn delta(from: u64, to: u64) -> Option<InventoryDelta> {
    Some(inventory(to).since(&inventory(from)))
}

const AGE: Duration = Duration::from_secs(5);

fn known(sessions: &Sessions) -> Option<u64> {
    let entry = sessions.get("n").unwrap();
    let current = entry.current(AGE)?;
    assert_eq!(**current, inventory(current.revision), "it is the truth");
    Some(current.revision)
}

/// Asks for all, as the loop does when it cannot rely on what was told.
fn ask(sessions: &Sessions, revision: u64) {
    let question = sessions.get("n").unwrap().question();
    sessions.observed("n", &question, Ok(&mut inventory(revision).into()));
}

#[tokio::test(start_paused = true)]
async fn deltas_that_are_lost_doubled_or_overtaken_never_leave_a_wrong_copy() {
    let sessions = Sessions::default();
    greet(&sessions, "a").unwrap();
    ask(&sessions, 3);
    assert_eq!(known(&sessions), Some(3));
    told(&sessions, "a", 4, delta(3, 4)).unwrap();
    assert_eq!(known(&sessions), Some(4));
    let doubled = told(&sessions, "a", 4, delta(3, 4)).unwrap();
    assert!(!doubled.inventory_changed);
    assert_eq!(known(&sessions), Some(4));
    // 4 → 5 is lost.
    assert!(
        told(&sessions, "a", 6, delta(5, 6))
            .unwrap()
            .inventory_changed
    );
    assert_eq!(known(&sessions), None);
    // It comes late, and leads only half the way.
    told(&sessions, "a", 5, delta(4, 5)).unwrap();
    assert_eq!(known(&sessions), None);
    ask(&sessions, 6);
    assert_eq!(known(&sessions), Some(6));
    told(&sessions, "a", 8, delta(6, 8)).unwrap();
    assert_eq!(known(&sessions), Some(8));
}

proptest::proptest! {
    #[test]
    fn any_order_of_heartbeats_leads_to_the_truth_or_to_a_question(
        beats in proptest::collection::vec((1..9u64, 0..4u64), 0..40),
    ) {
        let sessions = Sessions::default();
        greet(&sessions, "a").unwrap();
        ask(&sessions, 3);
        let mut newest = 3;
        for (from, length) in beats {
            newest = newest.max(from + length);
            told(&sessions, "a", from + length, delta(from, from + length)).unwrap();
            if let Some(revision) = known(&sessions) {
                proptest::prop_assert_eq!(revision, newest);
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn what_was_told_is_of_yesterday_after_the_slow_tick_and_after_a_deed() {
    let sessions = Sessions::default();
    greet(&sessions, "a").unwrap();
    ask(&sessions, 3);
    tokio::time::advance(AGE).await;
    assert_eq!(known(&sessions), None, "all is asked for now and then");
    ask(&sessions, 3);
    assert_eq!(known(&sessions), Some(3));
    // A question that began before a deed ended says nothing about it.
    let question = sessions.get("n").unwrap().question();
    sessions.doubt("n");
    sessions.observed("n", &question, Ok(&mut inventory(3).into()));
    assert_eq!(known(&sessions), None);
    ask(&sessions, 4);
    assert_eq!(known(&sessions), Some(4));
}

#[tokio::test(start_paused = true)]
async fn what_an_old_session_still_says_does_not_touch_the_new_one() {
    let sessions = Sessions::default();
    greet(&sessions, "a").unwrap();
    ask(&sessions, 7);
    let question = sessions.get("n").unwrap().question();
    greet(&sessions, "b").unwrap();
    assert_eq!(told(&sessions, "a", 8, delta(7, 8)), Err(409));
    sessions.observed("n", &question, Ok(&mut inventory(8).into()));
    let entry = sessions.get("n").unwrap();
    assert_eq!(*entry.inventory, Inventory::default());
    assert_eq!(entry.session.id, "b");
    // Nor does the end of the old one end what is asked of the new one.
    let work = std::future::pending::<()>();
    let waits = sessions.while_live("n", "b", work);
    let waits = tokio::time::timeout(Duration::from_secs(2), waits);
    assert!(waits.await.is_err());
    let old = sessions.while_live("n", "a", std::future::pending::<()>());
    assert_eq!(old.await, Err(Lost));
}

#[tokio::test(start_paused = true)]
async fn a_greeting_that_was_overtaken_brings_nothing_back() {
    let sessions = Sessions::default();
    let agent = || Arc::new(http_agent("/nowhere").unwrap());
    let again = |revision: u64| {
        let mut greeting = greeting("a");
        greeting.inventory = inventory(revision);
        let now = Timestamp::UNIX_EPOCH;
        sessions.greet("n", greeting, agent(), "uid".into(), now)
    };
    assert!(again(3).unwrap());
    assert_eq!(known(&sessions), Some(3));
    ask(&sessions, 5);
    assert!(!again(3).unwrap());
    assert_eq!(*sessions.get("n").unwrap().inventory, inventory(5));
    // Also one that knows nothing newer may be older than what was done since.
    assert_eq!(known(&sessions), None, "all is asked for again");
    ask(&sessions, 5);
    assert!(!again(6).unwrap());
    assert_eq!(known(&sessions), None);
    assert_eq!(*sessions.get("n").unwrap().inventory, inventory(6));
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
    assert!(sessions.expire(Duration::ZERO).0.is_empty());
    tokio::time::advance(Duration::from_millis(100)).await;
    assert_eq!(sessions.expire(Duration::ZERO).0, ["n"]);
    assert_eq!(sessions.get("n").unwrap().state(), "Unknown");
    tokio::time::timeout(Duration::from_secs(1), sessions.ended("n", "a"))
        .await
        .unwrap();
    assert!(beat(&sessions, "a", 0).unwrap().back);
    assert_eq!(sessions.get("n").unwrap().state(), "Ready");
}

#[tokio::test(start_paused = true)]
async fn what_the_controller_could_not_hear_is_no_silence() {
    let sessions = Sessions::default();
    greet(&sessions, "a").unwrap();
    tokio::time::advance(Duration::from_secs(6)).await;
    assert!(sessions.expire(Duration::from_secs(5)).0.is_empty());
    tokio::time::advance(Duration::from_millis(1900)).await;
    assert!(sessions.expire(Duration::ZERO).0.is_empty());
    tokio::time::advance(Duration::from_millis(100)).await;
    assert_eq!(sessions.expire(Duration::ZERO).0, ["n"]);
}

#[tokio::test(start_paused = true)]
async fn a_node_may_be_back_for_ten_seconds_after_it_was_there_last() {
    let sessions = Sessions::default();
    greet(&sessions, "a").unwrap();
    let may_be_back = || sessions.get("n").unwrap().may_be_back();
    assert!(!may_be_back(), "it is there");
    tokio::time::advance(Duration::from_secs(3)).await;
    sessions.expire(Duration::ZERO);
    assert!(may_be_back());
    tokio::time::advance(Duration::from_secs(7)).await;
    assert!(!may_be_back());
    // Its heartbeats come, but it answers nothing.
    beat(&sessions, "a", 0).unwrap();
    let question = sessions.get("n").unwrap().question();
    let unanswered = || sessions.observed("n", &question, Err("it hangs"));
    unanswered();
    tokio::time::advance(Duration::from_secs(3)).await;
    unanswered();
    assert_eq!(sessions.get("n").unwrap().state(), "NotReady");
    assert!(may_be_back());
    tokio::time::advance(Duration::from_secs(7)).await;
    unanswered();
    assert!(!may_be_back());
}

#[tokio::test(start_paused = true)]
async fn the_time_out_of_an_old_session_does_not_touch_the_new_one() {
    let sessions = Sessions::default();
    greet(&sessions, "a").unwrap();
    tokio::time::advance(Duration::from_millis(2900)).await;
    greet(&sessions, "b").unwrap();
    tokio::time::advance(Duration::from_millis(200)).await;
    assert!(sessions.expire(Duration::ZERO).0.is_empty());
}

#[tokio::test]
async fn another_protocol_names_the_side_to_upgrade() {
    let sessions = Sessions::default();
    let refused = |version| {
        let mut greeting = greeting("a");
        greeting.protocol_version = version;
        let agent = Arc::new(http_agent("/nowhere").unwrap());
        let refused = sessions.greet("n", greeting, agent, "u".into(), Timestamp::UNIX_EPOCH);
        refused.unwrap_err().to_string()
    };
    insta::assert_snapshot!(refused(PROTOCOL_VERSION + 1), @"the agent of node n speaks protocol 4, this controller 3: upgrade rts-controller");
    insta::assert_snapshot!(refused(PROTOCOL_VERSION - 1), @"the agent of node n speaks protocol 2, this controller 3: upgrade rts-agent");
}
