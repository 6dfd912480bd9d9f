use super::*;
use rts_plan::plan::{Plan, WaitingOn};

fn hello() -> SystemSpec {
    let text = include_bytes!("../../../../manifests/hello/system.xml");
    rts_schemas::rts_profile::load("hello.xml", text, None, &[])
        .unwrap()
        .0
}

fn result() -> PlanResult {
    let mut result = plan::samples::result();
    result.plan.waiting_on.push(WaitingOn {
        target: "component/Printer0".to_owned(),
        reason: "no module of type Printer".to_owned(),
        transient: false,
    });
    result
}

#[test]
fn a_step_is_meant_by_number_and_by_words() {
    let plan: Plan = result().plan;
    let find = |what: &str| Subject::find(&plan, &hello(), what);
    assert_eq!(find("2").unwrap(), Subject::Step(2));
    assert_eq!(find("Activate component/Sine0").unwrap(), Subject::Step(2));
    assert_eq!(find("activate Sine0").unwrap(), Subject::Step(2));
    assert_eq!(
        find("Sine0").unwrap(),
        Subject::Target("component/Sine0".to_owned())
    );
    assert_eq!(
        find("Filter0").unwrap(),
        Subject::Settled("component/Filter0".to_owned())
    );
    for (what, said) in [
        ("3", "there is no step 3: the plan has 2 steps"),
        (
            "99999999999",
            "there is no step 99999999999: the plan has 2 steps",
        ),
        ("Create Sine0", "there is no step Create Sine0"),
        ("Nobody0", "neither the plan nor the system has a Nobody0"),
        ("a b c", "name one step or one target"),
        ("", "name one step or one target"),
    ] {
        let error = find(what).unwrap_err();
        assert_eq!((error.line().as_str(), error.exit()), (said, Exit::Usage));
    }
}

#[test]
fn what_waits_says_why_and_what_is_settled_says_so() {
    let said = |what| told(&result(), &hello(), what).unwrap().0;
    insta::assert_snapshot!("waiting", said("Printer0"));
    insta::assert_snapshot!("settled", said("Filter0"));
    insta::assert_snapshot!("step", said("2"));
    let (_, value) = told(&result(), &hello(), "2").unwrap();
    assert_eq!(value["step"]["kind"], "Activate");
    assert_eq!(value["before"][0]["id"], 1);
    assert_eq!(value["before"][0]["until"], "succeeded");
}
