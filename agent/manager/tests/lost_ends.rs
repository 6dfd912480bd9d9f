//! A component that is not Active when a connector of it loses its other end: it is not activated before that connector
//! is connected again or removed, also not by an order that was under way.

#![allow(
    clippy::unwrap_used,
    reason = "a failure here is a failed test; clippy only knows test functions"
)]

mod support;

use rts_manager_api::client::Client;
use rts_manager_api::control::*;
use support::*;

const C: &str = "A.out-B.in";

/// A manager of which all are gone, with one component: A, the source, or B, the target, of a connector whose other end
/// was killed before it was activated.
struct Lost {
    manager: Running,
    client: Client,
    name: &'static str,
}

/// Whether the connector is seen closed at this end, or there is no component any more.
fn is_closed(client: &mut Client, name: &str) -> bool {
    let components = inventory(client).components;
    components.iter().filter(|c| c.instance == name).all(|c| {
        c.connectors.iter().all(|c| c.state == "Disconnected")
            && c.bindings.iter().all(|b| !b.connected)
    })
}

fn lost(name: &'static str, policy: &str) -> Lost {
    let (left, right) = (start("left"), start("right"));
    left.create("A", &[]);
    let incarnation = right.create("B", &[]);
    let (mut l, mut r) = (left.client(), right.client());
    ok(&mut l, on_disconnect("A", policy));
    ok(&mut r, on_disconnect("B", policy));
    ok(&mut r, binding(C, "B", "in", "A.out"));
    let request = connection("A", "B", &incarnation, Some(&right.socket()));
    ok(&mut l, RequestBody::Connect(request));
    let (manager, mut client, killed) = match name {
        "A" => (left, l, right),
        _ => (right, r, left),
    };
    killed.signal("-KILL");
    until("the loss is seen", || is_closed(&mut client, name));
    Lost {
        manager,
        client,
        name,
    }
}

impl Lost {
    fn ok(&mut self, body: RequestBody) {
        ok(&mut self.client, body);
    }

    fn is_refused(&mut self) {
        let failure = refused(&mut self.client, activate(self.name), SOON);
        assert_eq!(failure.code, FailureCode::ComponentFailed);
        assert_eq!(
            failure.message,
            format!(
                "{}: connector A.out-B.in lost its other end (rtsctl.onDisconnect: deactivate); it can be activated \
                 when that connector is connected again or removed",
                self.name
            )
        );
        assert_eq!(component(&mut self.client, self.name).state, "Inactive");
    }

    fn is_activated(&mut self) {
        self.ok(activate(self.name));
        assert_eq!(component(&mut self.client, self.name).state, "Active");
    }

    /// Another manager with the component of the other end, and that one's incarnation.
    fn other(&self) -> (Running, String) {
        let other = start("other");
        let name = if self.name == "A" { "B" } else { "A" };
        let incarnation = other.create(name, &[]);
        (other, incarnation)
    }

    /// Connects a new source to B.
    fn connect_source(&mut self, source: &Running) {
        let incarnation = component(&mut self.client, "B").incarnation;
        let request = connection("A", "B", &incarnation, Some(&self.manager.socket()));
        ok(&mut source.client(), RequestBody::Connect(request));
    }
}

#[test]
fn a_target_comes_back_when_the_same_binding_is_connected_again() {
    let mut lost = lost("B", "deactivate");
    lost.is_refused();
    let (source, _) = lost.other();
    lost.ok(binding(C, "B", "in", "A.out"));
    lost.is_refused();
    lost.connect_source(&source);
    lost.is_activated();
    // And it is lost again as any other.
    source.signal("-KILL");
    until("it acts", || {
        component(&mut lost.client, "B").state == "Inactive"
    });
    lost.is_refused();
}

#[test]
fn a_target_comes_back_when_it_is_unbound() {
    let mut lost = lost("B", "deactivate");
    lost.is_refused();
    lost.ok(unbind(C));
    lost.is_activated();
    lost.ok(deactivate("B"));
    // As the planner does it: removed, bound, connected.
    let (source, _) = lost.other();
    lost.ok(binding(C, "B", "in", "A.out"));
    lost.connect_source(&source);
    lost.is_activated();
}

#[test]
fn a_source_comes_back_when_it_is_connected_again() {
    for removed_first in [true, false] {
        let mut lost = lost("A", "deactivate");
        lost.is_refused();
        let (target, incarnation) = lost.other();
        if removed_first {
            lost.ok(disconnect("A", C));
        }
        ok(&mut target.client(), binding(C, "B", "in", "A.out"));
        let request = connection("A", "B", &incarnation, Some(&target.socket()));
        lost.ok(RequestBody::Connect(request));
        lost.is_activated();
    }
}

#[test]
fn a_source_comes_back_when_it_is_disconnected_and_not_by_an_attempt_to_connect() {
    let mut lost = lost("A", "deactivate");
    let (target, incarnation) = lost.other();
    let request = connection("A", "B", &incarnation, Some(&target.socket()));
    let failure = refused(&mut lost.client, RequestBody::Connect(request), SOON);
    assert_eq!(failure.code, FailureCode::NotFound, "it is not bound");
    lost.is_refused();
    let seen = component(&mut lost.client, "A").connectors;
    assert_eq!(seen.len(), 1);
    assert_eq!(seen[0].state, "Disconnected");
    lost.ok(disconnect("A", C));
    lost.is_activated();
}

#[test]
fn what_keeps_without_its_peer_is_activated() {
    for name in ["A", "B"] {
        lost(name, "keep").is_activated();
        let mut lost = lost(name, "deactivate");
        lost.is_refused();
        lost.ok(on_disconnect(name, "keep"));
        lost.is_activated();
    }
}

#[test]
fn with_the_policy_stop_it_is_deleted_at_once() {
    for name in ["A", "B"] {
        let mut lost = lost(name, "stop");
        until("it is gone", || {
            inventory(&mut lost.client).components.is_empty()
        });
        let log = lost.manager.log(name);
        assert!(log.contains("(rtsctl.onDisconnect: stop)"), "{log}");
    }
}

#[test]
fn a_loss_in_error_counts_after_the_reset() {
    let (left, right) = (start("left"), start("right"));
    left.create("A", &[]);
    let incarnation = right.create("B", &[("fail", "on_execute")]);
    let (mut l, mut r) = (left.client(), right.client());
    ok(&mut r, on_disconnect("B", "deactivate"));
    ok(&mut r, binding(C, "B", "in", "A.out"));
    let request = connection("A", "B", &incarnation, Some(&right.socket()));
    ok(&mut l, RequestBody::Connect(request));
    ok(&mut r, activate("B"));
    until("it fails", || component(&mut r, "B").state == "Error");
    left.signal("-KILL");
    until("the loss is seen", || is_closed(&mut r, "B"));
    let instance = "B".to_owned();
    ok(&mut r, RequestBody::Reset { instance });
    let failure = refused(&mut r, activate("B"), SOON);
    assert!(failure.message.contains("lost its other end"), "{failure}");
}

#[test]
fn a_loss_within_one_process_counts_as_well() {
    let mut lost = lost("B", "deactivate");
    let client = &mut lost.client;
    // E reads from S, in their process; S stops for the loss of a source of its own.
    let target = lost.manager.create("E", &[]);
    let s = lost.manager.create("S", &[]);
    ok(client, on_disconnect("E", "deactivate"));
    ok(client, on_disconnect("S", "stop"));
    let request = connection("S", "E", &target, None);
    ok(client, RequestBody::Connect(request.clone()));
    let third = start("third");
    third.create("Z", &[]);
    ok(client, binding("Z.out-S.in", "S", "in", "Z.out"));
    let socket = lost.manager.socket();
    let outside = connection("Z", "S", &s, Some(&socket));
    ok(&mut third.client(), RequestBody::Connect(outside));
    third.signal("-KILL");
    until("S is gone", || {
        let components = inventory(client).components;
        components.iter().all(|c| c.instance != "S")
    });
    let failure = refused(client, activate("E"), SOON);
    assert!(
        failure.message.contains("connector S.out-E.in"),
        "{failure}"
    );
    lost.manager.create("S", &[]);
    ok(client, RequestBody::Connect(request));
    ok(client, activate("E"));
}
