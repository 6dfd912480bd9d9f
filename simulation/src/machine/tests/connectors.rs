//! Connectors in a process and between two, and the loss of a peer.

use super::*;

/// A in `m` and B in `n`, connected.
async fn two(bench: &Bench, on_disconnect: &str) -> (Caller, Caller, ConnectRequest) {
    let (mut m, _) = bench.start_with("m", &["A"]).await;
    let (mut n, _) = bench.start("n").await;
    n.ok(load()).await;
    n.ok(create_with("B", Some(on_disconnect))).await;
    n.ok(activate("B")).await;
    let request = connect_to(&mut m, &mut n).await;
    (m, n, request)
}

async fn connect_to(m: &mut Caller, n: &mut Caller) -> ConnectRequest {
    let ResponseBody::Bound { incarnation } = n.ok(bind("c", "A", "B")).await else {
        panic!("it is bound");
    };
    let mut request = connect("c", "A", "B", &incarnation);
    request.target_socket = socket("n");
    m.ok(RequestBody::Connect(request.clone())).await;
    request
}

#[tokio::test(start_paused = true)]
async fn samples_flow_between_processes_while_both_ends_are_active() {
    let bench = bench();
    let (mut m, mut n, request) = two(&bench, "keep").await;
    sleep(Duration::from_secs(3)).await;
    let received = n.component("B").await.bindings[0].samples_received;
    let connector = m.component("A").await.connectors[0].clone();
    assert_eq!(connector.state, "Connected");
    assert_eq!(connector.target_incarnation, request.target_incarnation);
    let sent = connector.samples_sent;
    assert!(
        (28..=32).contains(&sent) && received <= sent,
        "{sent} {received}"
    );
    assert!(received >= 28);
    // The same again changes nothing.
    m.ok(RequestBody::Connect(request)).await;
    n.ok(deactivate("B")).await;
    sleep(Duration::from_secs(3)).await;
    let still = n.component("B").await.bindings[0].samples_received;
    assert!(still <= received + 1, "{still} {received}");
    n.ok(RequestBody::Unbind {
        connector: "c".to_owned(),
    })
    .await;
    let connector = m.component("A").await.connectors[0].clone();
    assert_eq!(connector.state, "Disconnected");
    assert!(n.component("B").await.bindings.is_empty());
    insta::assert_snapshot!(m.pushed.join("\n"), @"connector/c : disconnected: the other end closed the connection");
    let story = bench.story();
    assert_eq!(story.matches("c connected").count(), 1, "{story}");
    assert!(story.ends_with("c disconnected: Asked"), "{story}");
}

#[tokio::test(start_paused = true)]
async fn an_end_of_another_incarnation_or_without_binding_is_refused() {
    let bench = bench();
    let (mut m, mut n, mut request) = two(&bench, "keep").await;
    request.target_incarnation = "old".to_owned();
    let refusal = m.refused(RequestBody::Connect(request.clone())).await;
    assert!(
        refusal.starts_with("Conflict: B is incarnation "),
        "{refusal}"
    );
    request.connector = "d".to_owned();
    insta::assert_snapshot!(m.refused(RequestBody::Connect(request.clone())).await, @"NotFound: B.in does not expect the connector d: bind it first");
    request.target_socket = socket("nobody");
    insta::assert_snapshot!(m.refused(RequestBody::Connect(request.clone())).await, @"PeerFailed: the manager of B at /home/run/node1/nobody/control.sock cannot be reached: connection refused");
    bench.machine.hang(Some("hello.n"));
    request.target_socket = socket("n");
    insta::assert_snapshot!(m.refused(RequestBody::Connect(request)).await, @"PeerFailed: the manager of B at /home/run/node1/n/control.sock gave no answer");
    assert!(n.call_within(RequestBody::Inventory, 1).await.is_none());
    assert!(m.component("A").await.connectors.is_empty());
}

#[tokio::test(start_paused = true)]
async fn in_one_process_it_is_bound_on_the_way() {
    let bench = bench();
    let (mut m, _) = bench.start_with("m", &["A", "B"]).await;
    let incarnation = m.component("B").await.incarnation;
    m.ok(RequestBody::Connect(connect("c", "A", "B", &incarnation)))
        .await;
    assert!(m.component("B").await.bindings[0].connected);
    m.ok(RequestBody::Disconnect {
        instance: "A".to_owned(),
        connector: "c".to_owned(),
        by_hand: Some("mark".to_owned()),
    })
    .await;
    let info = m.component("A").await;
    assert!(info.connectors.is_empty());
    assert_eq!(info.by_hand.unwrap().disconnected["c"], "mark");
    assert!(!m.component("B").await.bindings[0].connected);
    m.ok(RequestBody::Connect(connect("c", "A", "B", &incarnation)))
        .await;
    assert!(
        m.component("A")
            .await
            .by_hand
            .unwrap()
            .disconnected
            .is_empty()
    );
    m.ok(delete("B")).await;
    assert_eq!(m.component("A").await.connectors[0].state, "Disconnected");
}

#[tokio::test(start_paused = true)]
async fn who_loses_a_peer_deactivates_and_stays_so_until_it_is_well_again() {
    let bench = bench();
    let (_, mut n, _) = two(&bench, "deactivate").await;
    bench.story();
    bench.machine.kill(Some("hello.m"));
    sleep(Duration::from_secs(1)).await;
    assert_eq!(n.component("B").await.state, "Inactive");
    insta::assert_snapshot!(n.refused(activate("B")).await, @"ComponentFailed: B: connector c lost its other end (rtsctl.onDisconnect: deactivate); it can be activated when that connector is connected again or removed");
    insta::assert_snapshot!(n.pushed.join("\n"), @r"
    connector/c : its source A has gone
    component/B PeerLost: deactivated: connector c lost its other end (rtsctl.onDisconnect: deactivate)
    ");
    insta::assert_snapshot!(bench.story(), @r"
    m/- blemished: it is killed
    c disconnected: Died
    n/B blemished: connector c lost its other end (rtsctl.onDisconnect: deactivate)
    A deleted: Died
    m ended: Fault
    B Active -> Inactive: Fault
    ");
    bench.grip.bury(&folder("m"), None).await.unwrap();
    let (mut m, _) = bench.start_with("m", &["A"]).await;
    connect_to(&mut m, &mut n).await;
    n.ok(activate("B")).await;
}

#[tokio::test(start_paused = true)]
async fn who_loses_a_peer_stops_where_that_is_wanted_and_not_for_an_order() {
    let bench = bench();
    let (mut m, mut n, _) = two(&bench, "stop").await;
    m.ok(RequestBody::Disconnect {
        instance: "A".to_owned(),
        connector: "c".to_owned(),
        by_hand: None,
    })
    .await;
    sleep(Duration::from_secs(1)).await;
    assert_eq!(n.component("B").await.state, "Active");
    connect_to(&mut m, &mut n).await;
    bench.story();
    bench.machine.kill(Some("hello.m"));
    sleep(Duration::from_secs(1)).await;
    assert!(n.inventory().await.components.is_empty());
    let story = bench.story();
    assert!(
        story.ends_with("B Active -> Inactive: Fault\nB deleted: Fault"),
        "{story}"
    );
}
