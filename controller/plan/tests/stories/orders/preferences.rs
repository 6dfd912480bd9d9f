//! What comes first where the profile is silent.

use rts_schemas::system::{Orders, PortKind, SendingTiming};

use super::tell::*;
use crate::world::specs::{after, connector};
use crate::world::story::Story;
use SendingTiming::Async;

fn service(consumer: &str, provider: &str) -> rts_schemas::system::ConnectorSpec {
    let mut spec = connector((consumer, "svc"), (provider, "svc"));
    spec.kind = PortKind::Service;
    let required = format!("{consumer}.port.svc.required.IDL.I");
    let provided = format!("{provider}.port.svc.provided.IDL.I");
    spec.properties.insert(required, provided);
    spec
}

#[test]
fn providers_come_up_before_consumers_and_go_down_after_them() {
    let mut system = named(&["Consumer", "Provider"], Orders::default());
    system.spec.connectors = vec![service("Consumer", "Provider")];
    let mut text = activates(system.clone());
    let mut story = Story::of(system.clone());
    story.turn();
    // Both are made again, in a new process.
    system
        .module_digests
        .insert("T".to_owned(), "another".to_owned());
    story.world.apply(system);
    text.push_str(&told(&story.plan(), "Deactivate"));
    insta::assert_snapshot!(text, @r"
    Activate Provider
    Activate Consumer: after start of Provider  [Provider provider first]
    note: service connector Consumer.svc-Provider.svc of system s: is declared, service ports are connected by a later version
    Deactivate Consumer
    Deactivate Provider: after start of Consumer  [Consumer provider first]
    note: service connector Consumer.svc-Provider.svc of system s: is declared, service ports are connected by a later version
    ");
}

#[test]
fn down_stream_comes_up_first_and_goes_down_last() {
    let mut system = named(&["Sink", "Source"], Orders::default());
    system.spec.connectors = vec![connector(("Source", "out"), ("Sink", "in"))];
    let mut text = activates(system.clone());
    let mut story = running(system);
    story.world.delete("s");
    text.push_str(&told(&story.plan(), "Deactivate"));
    insta::assert_snapshot!(text, @r"
    Activate Sink
    Activate Source: after start of Sink  [Sink down-stream first]
    Deactivate Source
    Deactivate Sink: after start of Source  [Source up-stream first]
    ");
}

/// A system that goes is still known by its services.
#[test]
fn consumers_go_down_before_providers_with_their_system() {
    let mut system = named(&["Consumer", "Provider"], Orders::default());
    system.spec.connectors = vec![service("Consumer", "Provider")];
    let mut story = Story::of(system);
    story.turn();
    story.world.delete("s");
    insta::assert_snapshot!(told(&story.plan(), "Deactivate"), @r"
    Deactivate Consumer
    Deactivate Provider: after start of Consumer  [Consumer provider first]
    ");
}

/// Data flows from the provider to its consumer: the service says who is first.
#[test]
fn in_a_cycle_services_outweigh_data_flow() {
    let mut system = named(&["A", "B", "X", "Y"], Orders::default());
    system.spec.connectors = vec![
        connector(("A", "out"), ("B", "in")),
        service("B", "A"),
        connector(("X", "out"), ("Y", "in")),
    ];
    insta::assert_snapshot!(activates(system), @r"
    Activate A
    Activate B: after start of A  [A provider first]
    Activate Y
    Activate X: after start of Y  [Y down-stream first]
    note: service connector B.svc-A.svc of system s: is declared, service ports are connected by a later version
    note: data flow gives no start or stop order among component/A, component/B: it runs in a circle, or against a written order or a service
    ");
}

#[test]
fn services_in_a_circle_give_no_order() {
    let mut system = named(&["A", "B", "C"], Orders::default());
    system.spec.connectors = vec![
        service("A", "B"),
        service("B", "C"),
        service("C", "A"),
        connector(("A", "out"), ("B", "in")),
    ];
    insta::assert_snapshot!(activates(system), @r"
    Activate A
    Activate B
    Activate C
    note: service connector A.svc-B.svc of system s: is declared, service ports are connected by a later version
    note: service connector B.svc-C.svc of system s: is declared, service ports are connected by a later version
    note: service connector C.svc-A.svc of system s: is declared, service ports are connected by a later version
    note: data flow gives no start or stop order among component/A, component/B, component/C: it runs in a circle, or against a written order or a service
    note: services give no start or stop order among component/A, component/B, component/C: they are provided in a circle, or against a written order
    ");
}

#[test]
fn a_written_order_outweighs_a_preference() {
    let mut system = named(&["A", "B"], activation(vec![after("B", 1, Async, &["A"])]));
    system.spec.connectors = vec![connector(("A", "out"), ("B", "in"))];
    insta::assert_snapshot!(activates(system), @r"
    Activate A
    Activate B: after start of A  [A ASYNC in Activation]
    note: data flow gives no start or stop order among component/A, component/B: it runs in a circle, or against a written order or a service
    ");
}
