//! Stand-ins, in real manager processes.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use rts_manager_api::client::Client;
use rts_manager_api::control::*;

use crate::support::*;
use crate::{C, bound, connector};

/// A request for a stand-in with an in-port and an out-port of a type.
pub fn stand_in(manager: &Running, instance: &str, data_type: &str) -> CreateRequest {
    let port = |name: &str, data_type: &str| PortInfo {
        name: name.to_owned(),
        direction: name.to_owned(),
        data_type: data_type.to_owned(),
    };
    let RequestBody::Create(mut request) = manager.testmod(instance, &[("gain", "2")]) else {
        panic!("no Create");
    };
    request.type_name = "Camera".to_owned();
    request.rate = Some(200.0);
    request.stand_in = Some(StandInShape {
        ports: vec![
            port("in", data_type),
            port("out", data_type),
            port("service", ""),
        ],
        parameters: [("gain".to_owned(), String::new())].into(),
        ..StandInShape::default()
    });
    request
}

/// Creates it; its incarnation.
pub fn make(client: &mut Client, request: CreateRequest) -> String {
    match ok(client, RequestBody::Create(request)) {
        ResponseBody::Created { incarnation } => incarnation,
        other => panic!("{other:?}"),
    }
}

#[test]
fn stand_ins_of_any_type_send_to_each_other_and_count() {
    for data_type in ["IDL:Img/TimedCameraImage:1.0", "IDL:RTC/TimedShort:1.0"] {
        let (left, right) = (start("left"), start("right"));
        let (mut l, mut r) = (left.client(), right.client());
        make(&mut l, stand_in(&left, "A", data_type));
        let incarnation = make(&mut r, stand_in(&right, "B", data_type));
        ok(&mut r, binding(C, "B", "in", "A.out"));
        let request = connection("A", "B", &incarnation, Some(&right.socket()));
        ok(&mut l, RequestBody::Connect(request));
        ok(&mut r, activate("B"));
        ok(&mut l, activate("A"));
        until("samples flow", || bound(&mut r).samples_received >= 20);
        ok(&mut l, deactivate("A"));
        until("all is read", || {
            bound(&mut r).samples_received == connector(&mut l).samples_sent
        });
        ok(&mut r, deactivate("B"));
        let received = bound(&mut r).samples_received;
        let log = right.log("B");
        let line = format!("port in: {received} samples, 0 gaps, 0 out of order, 0 faulty");
        assert!(log.contains(&line), "{log}");
        let info = component(&mut r, "B");
        assert!(info.stand_in && info.sets["default"]["gain"] == "2");
        let ports: Vec<_> = info.ports.iter().map(|port| port.name.as_str()).collect();
        assert_eq!(ports, ["in", "out", "service"]);
        assert!(inventory(&mut r).modules.is_empty());
    }
}

#[test]
fn a_stand_in_fails_and_crashes_when_it_is_told_to() {
    let mut manager = start("m");
    let mut client = manager.client();
    let told = |instance: &str, tell: &dyn Fn(&mut StandInShape)| {
        let mut request = stand_in(&manager, instance, "IDL:RTC/TimedLong:1.0");
        request.stand_in.as_mut().map(tell);
        request
    };
    let initialize = told("I", &|shape| shape.fail = Some("initialize".to_owned()));
    let activated = told("A", &|shape| shape.fail = Some("activate".to_owned()));
    let execute = told("E", &|shape| shape.fail = Some("execute".to_owned()));
    let slow = told("S", &|shape| shape.startup_ms = Some(600_000));
    let crash = told("C", &|shape| shape.crash_after_ms = Some(100));
    let failure = refused(&mut client, RequestBody::Create(initialize), SOON);
    assert_eq!(
        (failure.code, failure.message.as_str()),
        (
            FailureCode::ComponentFailed,
            "I: on_initialize: fails as its stand-in was told to"
        )
    );
    make(&mut client, activated);
    refused(&mut client, activate("A"), SOON);
    assert_eq!(component(&mut client, "A").state, "Error");
    make(&mut client, execute);
    ok(&mut client, activate("E"));
    until("it is in Error", || {
        component(&mut client, "E").state == "Error"
    });
    let failure = refused(
        &mut client,
        RequestBody::Create(slow),
        std::time::Duration::from_millis(50),
    );
    assert_eq!(failure.code, FailureCode::Deadline);
    make(&mut client, crash);
    ok(&mut client, activate("C"));
    assert!(!manager.wait().success());
    assert!(
        manager
            .log("C")
            .contains("crashes 100 ms after its activation")
    );
}
