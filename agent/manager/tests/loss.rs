//! What components do when a connector's other end is lost, with real manager processes and nobody else alive.

mod support;

use std::time::{Duration, Instant};

use rts_manager_api::client::Client;
use rts_manager_api::control::*;
use support::*;

const C: &str = "A.out-B.in";
const DEACTIVATED: &str =
    "deactivated: connector A.out-B.in lost its other end (rtsctl.onDisconnect: deactivate)";

/// A in one manager, B in another, connected, both active and both with this policy. No samples flow.
struct Pair {
    left: Running,
    l: Client,
    right: Running,
    r: Client,
}

fn pair(policy: &str) -> Pair {
    pair_with(policy, &[])
}

fn pair_with(policy: &str, parameters: &[(&str, &str)]) -> Pair {
    let (left, right) = (start("left"), start("right"));
    let (mut l, mut r) = (left.client(), right.client());
    left.create("A", parameters);
    let incarnation = right.create("B", parameters);
    ok(&mut l, on_disconnect("A", policy));
    ok(&mut r, on_disconnect("B", policy));
    ok(&mut r, binding(C, "B", "in", "A.out"));
    let request = connection("A", "B", &incarnation, Some(&right.socket()));
    ok(&mut l, RequestBody::Connect(request));
    ok(&mut r, activate("B"));
    ok(&mut l, activate("A"));
    Pair { left, l, right, r }
}

fn delete(instance: &str) -> RequestBody {
    RequestBody::Delete {
        instance: instance.to_owned(),
    }
}

fn is_there(client: &mut Client, instance: &str) -> bool {
    let components = inventory(client).components;
    components.iter().any(|c| c.instance == instance)
}

/// It is deactivated by itself, and says why until it is active again.
fn is_deactivated(
    manager: &Running,
    client: &mut Client,
    events: &mut Listener,
    name: &str,
    removed: RequestBody,
) {
    assert_eq!(events.event(&format!("component/{name}")), DEACTIVATED);
    let seen = component(client, name);
    assert_eq!(seen.state, "Inactive");
    assert_eq!(seen.message.as_deref(), Some(DEACTIVATED));
    assert_eq!(seen.on_disconnect.as_deref(), Some("deactivate"));
    let log = manager.log(name);
    assert!(
        log.contains("on_deactivated") && log.contains(DEACTIVATED),
        "{log}"
    );
    ok(client, deactivate(name));
    assert_eq!(
        component(client, name).message.as_deref(),
        Some(DEACTIVATED)
    );
    ok(client, removed);
    ok(client, activate(name));
    assert_eq!(component(client, name).message, None);
}

#[test]
fn a_source_deactivates_itself_when_its_target_is_killed() {
    let mut pair = pair("deactivate");
    let mut events = Listener::connect(&pair.left);
    pair.right.signal("-KILL");
    let removed = disconnect("A", C);
    is_deactivated(&pair.left, &mut pair.l, &mut events, "A", removed);
}

#[test]
fn a_target_deactivates_itself_when_its_source_is_killed() {
    let mut pair = pair("deactivate");
    let mut events = Listener::connect(&pair.right);
    pair.left.signal("-KILL");
    let removed = unbind(C);
    is_deactivated(&pair.right, &mut pair.r, &mut events, "B", removed);
}

#[test]
fn nobody_has_to_be_connected_for_it() {
    let Pair { left, l, right, r } = pair_with("deactivate", &[("produce", "1")]);
    drop((l, r));
    left.signal("-KILL");
    until("B is inactive", || {
        right.log("B").contains("Active -> Inactive")
    });
}

#[test]
fn with_the_policy_stop_it_is_deleted() {
    for kill_left in [true, false] {
        let mut pair = pair("stop");
        let (killed, kept, client, name) = match kill_left {
            true => (&pair.left, &pair.right, &mut pair.r, "B"),
            false => (&pair.right, &pair.left, &mut pair.l, "A"),
        };
        let mut events = Listener::connect(kept);
        killed.signal("-KILL");
        let target = format!("component/{name}");
        assert_eq!(
            events.event(&target),
            "stopped: connector A.out-B.in lost its other end (rtsctl.onDisconnect: stop)"
        );
        assert_eq!(
            events.event(&target),
            "was deleted after the loss of a peer"
        );
        assert!(!is_there(client, name));
        let log = kept.log(name);
        assert!(
            log.contains("on_deactivated") && log.contains("on_finalize"),
            "{log}"
        );
        // The name is free again.
        kept.create(name, &[]);
    }
}

#[test]
fn with_the_policy_keep_it_goes_on() {
    for kill_left in [true, false] {
        let mut pair = pair("keep");
        let (killed, kept, client, name) = match kill_left {
            true => (&pair.left, &pair.right, &mut pair.r, "B"),
            false => (&pair.right, &pair.left, &mut pair.l, "A"),
        };
        let mut events = Listener::connect(kept);
        killed.signal("-KILL");
        events.event("connector/A.out-B.in");
        let before = component(client, name).executions;
        until("it goes on", || {
            component(client, name).executions > before + 5
        });
        assert_eq!(component(client, name).state, "Active");
    }
}

/// Whether both are untouched after the connection has ended.
fn both_go_on(what: &str, order: impl Fn(&mut Pair)) {
    for (policy, produce) in [("deactivate", "0"), ("stop", "1")] {
        let mut pair = pair_with(policy, &[("produce", produce)]);
        order(&mut pair);
        // The loss would have come with the end of the connection, and be obeyed before the next cycle.
        for (client, name) in [(&mut pair.l, "A"), (&mut pair.r, "B")] {
            if what.contains(name) {
                continue;
            }
            until("its end is seen", || {
                let seen = component(client, name);
                seen.connectors.iter().all(|c| c.state == "Disconnected")
                    && seen.bindings.iter().all(|b| !b.connected)
            });
            let before = component(client, name).executions;
            until("it goes on", || {
                let seen = component(client, name);
                let state = (seen.state.as_str(), seen.message);
                assert_eq!(state, ("Active", None), "{name} after {what}, {policy}");
                seen.executions > before + 5
            });
        }
    }
}

#[test]
fn what_is_ordered_is_no_loss() {
    both_go_on("disconnect", |pair| {
        ok(&mut pair.l, disconnect("A", C));
    });
    both_go_on("unbind", |pair| {
        ok(&mut pair.r, unbind(C));
    });
    both_go_on("delete A", |pair| {
        ok(&mut pair.l, delete("A"));
    });
    both_go_on("delete B", |pair| {
        ok(&mut pair.r, delete("B"));
    });
}

#[test]
fn the_orderly_end_of_a_whole_manager_is_no_loss() {
    both_go_on("shutdown of the left one, with A", |pair| {
        ok(&mut pair.l, RequestBody::Shutdown);
        pair.left.wait();
    });
    both_go_on("shutdown of the right one, with B", |pair| {
        ok(&mut pair.r, RequestBody::Shutdown);
        pair.right.wait();
    });
    both_go_on("SIGTERM to the left one, with A", |pair| {
        pair.left.signal("-TERM");
        pair.left.wait();
    });
}

#[test]
fn a_manager_ends_after_all_its_good_byes() {
    let mut pair = pair("deactivate");
    let incarnation = component(&mut pair.r, "B").incarnation;
    for number in 0..100 {
        let mut request = connection("A", "B", &incarnation, Some(&pair.right.socket()));
        request.connector = format!("c{number}");
        ok(&mut pair.r, binding(&request.connector, "B", "in", "A.out"));
        ok(&mut pair.l, RequestBody::Connect(request));
    }
    ok(&mut pair.l, RequestBody::Shutdown);
    pair.left.wait();
    until("all ends are seen", || {
        let seen = component(&mut pair.r, "B");
        seen.bindings.iter().all(|b| !b.connected)
    });
    let before = component(&mut pair.r, "B").executions;
    until("it goes on", || {
        component(&mut pair.r, "B").executions > before + 5
    });
}

#[test]
fn one_that_hangs_holds_nobody_else_and_is_deactivated_when_it_can_be() {
    let (left, right) = (start("left"), start("right"));
    let (mut l, mut r) = (left.client(), right.client());
    left.create("A", &[]);
    for (name, parameters) in [
        ("H", &[("hang", "on_execute"), ("hang_ms", "3000")][..]),
        ("B", &[]),
    ] {
        let incarnation = right.create(name, parameters);
        ok(&mut r, on_disconnect(name, "deactivate"));
        let connector = format!("A.out-{name}.in");
        ok(&mut r, binding(&connector, name, "in", "A.out"));
        let request = connection("A", name, &incarnation, Some(&right.socket()));
        ok(&mut l, RequestBody::Connect(request));
        ok(&mut r, activate(name));
    }
    until("H hangs", || component(&mut r, "H").executions > 0);
    let begin = Instant::now();
    left.signal("-KILL");
    until("B is inactive", || {
        component(&mut r, "B").state == "Inactive"
    });
    assert!(begin.elapsed() < Duration::from_millis(2500));
    assert_eq!(component(&mut r, "H").state, "Active");
    until("its hang is told", || {
        component(&mut r, "H")
            .busy
            .is_some_and(|b| b.callback == "on_execute")
    });
    until("H is inactive", || {
        component(&mut r, "H").state == "Inactive"
    });
    let message = component(&mut r, "H").message.unwrap();
    assert!(
        message.starts_with("deactivated: connector A.out-H.in"),
        "{message}"
    );
    assert_eq!(component(&mut r, "H").executions, 1);
}

#[test]
fn one_that_hangs_for_too_long_is_told_of() {
    let mut pair = pair_with(
        "deactivate",
        &[("hang", "on_deactivated"), ("hang_ms", "60000")],
    );
    let mut events = Listener::connect(&pair.right);
    pair.left.signal("-KILL");
    until("it hangs", || component(&mut pair.r, "B").busy.is_some());
    // The time that a request to deactivate it would have, and a second.
    std::thread::sleep(Duration::from_secs(5));
    let message = events.event("component/B");
    assert!(
        message.starts_with("cannot obey: B has been in on_deactivated for 1"),
        "{message}"
    );
    assert!(
        message.ends_with("(rtsctl.onDisconnect: deactivate)"),
        "{message}"
    );
    let seen = component(&mut pair.r, "B");
    assert_eq!(
        (seen.state.as_str(), seen.message),
        ("Active", Some(message))
    );
}

#[test]
fn a_stop_for_a_loss_is_a_loss_to_the_next_one() {
    let mut pair = pair("stop");
    // B -> D over a socket, and B -> E in its process: both are to be deactivated.
    let incarnation = pair.left.create("D", &[]);
    ok(&mut pair.l, on_disconnect("D", "deactivate"));
    ok(&mut pair.l, binding("B.out-D.in", "D", "in", "B.out"));
    let request = connection("B", "D", &incarnation, Some(&pair.left.socket()));
    ok(&mut pair.r, RequestBody::Connect(request));
    let incarnation = pair.right.create("E", &[]);
    ok(&mut pair.r, on_disconnect("E", "deactivate"));
    let request = connection("B", "E", &incarnation, None);
    ok(&mut pair.r, RequestBody::Connect(request));
    ok(&mut pair.l, activate("D"));
    ok(&mut pair.r, activate("E"));
    // Z holds the only end that is really lost.
    let third = start("third");
    third.create("Z", &[]);
    let mut t = third.client();
    ok(&mut pair.r, binding("Z.out-B.in", "B", "in", "Z.out"));
    let b = component(&mut pair.r, "B").incarnation;
    let request = connection("Z", "B", &b, Some(&pair.right.socket()));
    ok(&mut t, RequestBody::Connect(request));
    third.signal("-KILL");
    until("B is gone", || !is_there(&mut pair.r, "B"));
    until("D and E are inactive", || {
        component(&mut pair.l, "D").state == "Inactive"
            && component(&mut pair.r, "E").state == "Inactive"
    });
}

#[test]
fn a_policy_is_reported_and_an_unknown_one_refused() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[]);
    let policy = |client: &mut Client| component(client, "A").on_disconnect;
    assert_eq!(policy(&mut client).as_deref(), Some("keep"));
    ok(&mut client, on_disconnect("A", "stop"));
    assert_eq!(policy(&mut client).as_deref(), Some("stop"));
    let failure = refused(&mut client, on_disconnect("A", "fly"), SOON);
    assert_eq!(
        failure.message,
        "onDisconnect cannot be `fly`; use keep, deactivate or stop"
    );
    let RequestBody::Create(mut request) = manager.testmod("B", &[]) else {
        panic!()
    };
    request.on_disconnect = Some("deactivate".to_owned());
    ok(&mut client, RequestBody::Create(request));
    assert_eq!(
        component(&mut client, "B").on_disconnect.as_deref(),
        Some("deactivate")
    );
}
