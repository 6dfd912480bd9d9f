//! Samples between components of one and of two real manager processes.

#[path = "data/refused.rs"]
mod refused;
#[path = "data/stand_ins.rs"]
mod stand_ins;
mod support;
#[path = "data/transports.rs"]
mod transports;

use rts_manager_api::client::Client;
use rts_manager_api::control::*;
use support::*;

const C: &str = "A.out-B.in";

fn connector(client: &mut Client) -> ConnectorInfo {
    component(client, "A").connectors.remove(0)
}

fn bound(client: &mut Client) -> BindingInfo {
    component(client, "B").bindings.remove(0)
}

/// `dataport.interface_type` for each of the transports between processes.
const BETWEEN: [&str; 3] = ["shm", "uds", "tcp"];

fn with(request: &ConnectRequest, properties: &[(&str, &str)]) -> RequestBody {
    let own = |(name, value): &(&str, &str)| (format!("dataport.{name}"), (*value).to_owned());
    RequestBody::Connect(ConnectRequest {
        properties: properties.iter().map(own).collect(),
        ..request.clone()
    })
}

/// A in one manager, B in another, connected so, both active.
fn pair(transport: &str) -> (Running, Client, Running, Client) {
    let (left, right) = (start("left"), start("right"));
    let (mut l, mut r) = (left.client(), right.client());
    left.create("A", &[("produce", "1")]);
    let incarnation = right.create("B", &[]);
    let answer = ok(&mut r, binding(C, "B", "in", "A.out"));
    assert_eq!(
        answer,
        ResponseBody::Bound {
            incarnation: incarnation.clone()
        }
    );
    let request = connection("A", "B", &incarnation, Some(&right.socket()));
    ok(&mut l, with(&request, &[("interface_type", transport)]));
    ok(&mut r, activate("B"));
    ok(&mut l, activate("A"));
    (left, l, right, r)
}

#[test]
fn inside_a_process_samples_arrive_in_order_and_are_counted() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "1")]);
    let incarnation = manager.create("B", &[]);
    ok(&mut client, binding(C, "B", "in", "A.out"));
    let request = connection("A", "B", &incarnation, None);
    ok(&mut client, RequestBody::Connect(request.clone()));
    ok(&mut client, activate("B"));
    ok(&mut client, activate("A"));
    until("samples flow", || {
        let inventory = inventory(&mut client);
        let (a, b) = (&inventory.components[0], &inventory.components[1]);
        assert!(b.bindings[0].samples_received <= a.connectors[0].samples_sent);
        b.bindings[0].samples_received >= 50
    });
    // Again is no change; and nothing of it counts as a loss.
    ok(&mut client, RequestBody::Connect(request));
    ok(&mut client, deactivate("A"));
    until("all is read", || {
        bound(&mut client).samples_received == connector(&mut client).samples_sent
    });
    let (sent, received) = (connector(&mut client), bound(&mut client));
    assert_eq!(
        (sent.state.as_str(), sent.transport.as_str()),
        ("Connected", "direct")
    );
    assert_eq!((sent.drops, received.drops, received.gaps), (0, 0, 0));
    assert_eq!(sent.bytes, 8 * sent.samples_sent);
    assert_eq!(sent.properties["k"], "v");
    assert!(received.connected);
    assert_eq!(component(&mut client, "B").state, "Active");

    let mut events = Listener::connect(&manager);
    ok(
        &mut client,
        RequestBody::Delete {
            instance: "B".to_owned(),
        },
    );
    assert_eq!(
        events.event("connector/A.out-B.in"),
        "its target B.in has gone"
    );
    assert_eq!(connector(&mut client).state, "Disconnected");
    ok(
        &mut client,
        RequestBody::Disconnect {
            instance: "A".to_owned(),
            connector: C.to_owned(),
            by_hand: None,
        },
    );
    assert!(component(&mut client, "A").connectors.is_empty());
}

#[test]
fn a_reader_that_is_too_slow_loses_the_oldest_and_sees_gaps() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "200")]);
    let incarnation = manager.create("B", &[("hang", "on_execute"), ("hang_ms", "200")]);
    ok(
        &mut client,
        RequestBody::Connect(connection("A", "B", &incarnation, None)),
    );
    ok(&mut client, activate("B"));
    ok(&mut client, activate("A"));
    until("samples are lost", || bound(&mut client).drops > 0);
    ok(&mut client, deactivate("A"));
    until("the rest is read", || {
        let (sent, received) = (connector(&mut client), bound(&mut client));
        received.samples_received + received.drops == sent.samples_sent
    });
    let received = bound(&mut client);
    assert!(received.samples_received >= 64 && received.gaps >= 1);
    assert_eq!(component(&mut client, "B").state, "Active");
}

#[test]
fn what_was_sent_before_the_reader_was_active_is_never_read() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "1")]);
    let incarnation = manager.create("B", &[]);
    ok(
        &mut client,
        RequestBody::Connect(connection("A", "B", &incarnation, None)),
    );
    ok(&mut client, activate("A"));
    until("samples wait", || connector(&mut client).samples_sent >= 5);
    ok(&mut client, deactivate("A"));
    let early = connector(&mut client).samples_sent;
    ok(&mut client, activate("B"));
    until("B executes", || component(&mut client, "B").executions > 2);
    let seen = bound(&mut client);
    assert_eq!((seen.samples_received, seen.drops), (0, early));

    ok(&mut client, activate("A"));
    until("samples flow", || bound(&mut client).samples_received >= 3);
    ok(&mut client, deactivate("A"));
    until("all is read", || {
        bound(&mut client).samples_received + early == connector(&mut client).samples_sent
    });
    assert_eq!(bound(&mut client).gaps, 0);
}

#[test]
fn unbinding_ends_the_connection_and_disconnecting_is_idempotent() {
    for transport in BETWEEN {
        let (left, mut l, _right, mut r) = pair(transport);
        let mut events = Listener::connect(&left);
        ok(&mut r, unbind(C));
        ok(&mut r, unbind(C));
        let told = "disconnected: the other end said good-bye";
        assert_eq!(events.event("connector/A.out-B.in"), told);
        assert_eq!(connector(&mut l).state, "Disconnected");
        assert_eq!(component(&mut l, "A").state, "Active");
        for _ in 0..2 {
            ok(&mut l, disconnect("A", C));
        }
    }
}
