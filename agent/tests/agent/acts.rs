//! What people change by hand in what runs.

use std::collections::BTreeMap;

use rts_agent_api::AgentApi;
use rts_agent_api::messages::{Act, ActRequest, Acted, CreateByHand};
use rts_http::problem::Problem;
use rts_plan::desired::{NodeSpec, PlacedConnector};
use rts_plan::mark::{self, Mark};
use rts_plan::observed::{ComponentObserved, LifeCycleState, ManagerObserved};
use rts_plan::place::digest;
use rts_plan::plan::Work;
use rts_schemas::system::{Configuration, DriftPolicy, OnDisconnect, PortRef};

use crate::setup::{Node, component, connector, hello_spec, problem, step};

async fn done(node: &Node, act: Act) -> Acted {
    let dry_run = false;
    node.agent.act(&ActRequest { act, dry_run }).await.unwrap()
}

async fn refused(node: &Node, act: Act) -> Problem {
    let dry_run = false;
    problem(node.agent.act(&ActRequest { act, dry_run }).await)
}

/// Refusals as a person reads them; a dry run must be refused in the same words.
async fn refusals(node: &Node, acts: Vec<Act>) -> String {
    let mut text = String::new();
    for act in acts {
        let refused = refused(node, act.clone()).await;
        let dry_run = true;
        let dry = problem(node.agent.act(&ActRequest { act, dry_run }).await);
        assert_eq!(dry, refused);
        text += &format!("{} {}: {}\n", refused.status, refused.code, refused.detail);
    }
    text
}

/// What is told of an act, in one line and its notes.
fn say(acted: &Acted) -> String {
    assert_eq!(acted.node, "local");
    let changed = if acted.changed {
        "changed"
    } else {
        "as it was"
    };
    let policy = acted.policy.map(DriftPolicy::as_str);
    let mut text = format!("{} {changed} {:?} {policy:?}", acted.target, acted.system);
    for note in &acted.notes {
        text += &format!("\n  {note}");
    }
    text
}

fn activate(instance: &str) -> Act {
    Act::Activate {
        instance: instance.to_owned(),
    }
}

fn deactivate(instance: &str) -> Act {
    Act::Deactivate {
        instance: instance.to_owned(),
    }
}

fn reset(instance: &str) -> Act {
    Act::Reset {
        instance: instance.to_owned(),
    }
}

fn configure(instance: &str, set: Option<&str>, values: &[(&str, &str)]) -> Act {
    let values = values.iter();
    Act::Configure {
        instance: instance.to_owned(),
        set: set.map(str::to_owned),
        values: values
            .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()))
            .collect(),
        active: None,
    }
}

fn end(text: &str) -> PortRef {
    let (instance, port) = text.rsplit_once('.').unwrap();
    PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    }
}

fn connect(source: &str, target: &str, name: Option<&str>) -> Act {
    Act::Connect {
        source: end(source),
        target: end(target),
        name: name.map(str::to_owned),
        properties: BTreeMap::new(),
    }
}

fn disconnect(instance: &str, connector: &str) -> Act {
    Act::Disconnect {
        instance: instance.to_owned(),
        connector: connector.to_owned(),
    }
}

async fn observed(node: &Node, name: &str) -> ComponentObserved {
    component(&node.agent.inventory().await.unwrap(), name).clone()
}

/// Accepts the hello system with another policy for drift.
async fn accept(node: &Node, generation: u64, change: impl FnOnce(&mut NodeSpec)) {
    let mut envelope = hello_spec(generation);
    change(&mut envelope.spec);
    envelope.digest = digest(&envelope.spec);
    node.agent.put_node_spec(&envelope).await.unwrap();
}

fn settings(instance: &str) -> String {
    let spec = hello_spec(1).spec;
    let mut all = spec.systems[0].components.iter();
    let placed = all.find(|c| c.spec.instance == instance).unwrap();
    placed.settings_digest()
}

fn first() -> PlacedConnector {
    connector("Sine0", "main", "Filter0", "main")
}

#[tokio::test]
async fn states_are_changed_and_marked() {
    let node = Node::start().await;
    node.hello().await;
    insta::assert_snapshot!(say(&done(&node, deactivate("Filter0")).await), @r#"
    component/Filter0 changed Some("hello") Some("repair")
      system hello repairs drift: it will be put back; see rtsctl.drift of Filter0
    "#);
    let filter = observed(&node, "Filter0").await;
    assert_eq!(filter.state, LifeCycleState::Inactive);
    assert_eq!(filter.by_hand.deactivated, Some(settings("Filter0")));
    insta::assert_snapshot!(say(&done(&node, deactivate("Filter0")).await), @r#"component/Filter0 as it was Some("hello") None"#);
    insta::assert_snapshot!(say(&done(&node, activate("Filter0")).await), @r#"component/Filter0 changed Some("hello") None"#);
    insta::assert_snapshot!(say(&done(&node, activate("Filter0")).await), @r#"component/Filter0 as it was Some("hello") None"#);
    let filter = observed(&node, "Filter0").await;
    assert_eq!(filter.state, LifeCycleState::Active);
    assert!(filter.by_hand.is_empty());
    insta::assert_snapshot!(refusals(&node, vec![
        reset("Filter0"),
        activate("Fitler0"),
        configure("Filter0", None, &[]),
    ]).await, @r"
    409 wrong-state: Filter0 is Active: there is nothing to reset
    404 not-found: node local has no component Fitler0; did you mean `Filter0`? components: Filter0, Printer0, Sine0
    422 nothing-to-set: nothing was given to be set in Filter0
    ");
}

#[tokio::test]
async fn values_are_set_and_marked() {
    let node = Node::start().await;
    node.hello().await;
    // The pretended component knows the parameters that it was told once.
    let values = |value| [("gain", value)];
    insta::assert_snapshot!(refusals(&node, vec![
        configure("Filter0", None, &values("2")),
        configure("Filter0", Some("fast"), &values("2")),
        Act::Configure {
            instance: "Filter0".to_owned(),
            set: None,
            values: BTreeMap::new(),
            active: Some("fast".to_owned()),
        },
    ]).await, @r"
    422 unknown-parameter: Filter0 has no parameter gain; it has none
    422 unknown-set: Filter0 has no configuration set fast; it has none
    422 unknown-set: Filter0 has no configuration set fast; it has none
    ");
    let wish = CreateByHand {
        type_name: "Sine".to_owned(),
        instance: None,
        parameters: BTreeMap::from([("gain".to_owned(), "1".to_owned())]),
        rate: None,
    };
    node.agent.create("bench", &wish).await.unwrap();
    insta::assert_snapshot!(refusals(&node, vec![
        configure("Sine1", None, &[("gian", "2")]),
        configure("Sine1", Some("defualt"), &values("2")),
    ]).await, @r"
    422 unknown-parameter: Sine1 has no parameter gian; did you mean `gain`?
    422 unknown-set: Sine1 has no configuration set defualt; did you mean `default`?
    ");
    let act = configure("Sine1", Some("default"), &values("2"));
    let dry_run = true;
    let request = ActRequest {
        act: act.clone(),
        dry_run,
    };
    insta::assert_snapshot!(say(&node.agent.act(&request).await.unwrap()), @"component/Sine1 as it was None None");
    let sine = observed(&node, "Sine1").await;
    assert_eq!(sine.configuration.sets["default"]["gain"], "1");
    insta::assert_snapshot!(say(&done(&node, act.clone()).await), @"component/Sine1 changed None None");
    insta::assert_snapshot!(say(&done(&node, act).await), @"component/Sine1 as it was None None");
    let sine = observed(&node, "Sine1").await;
    assert_eq!(sine.configuration.sets["default"]["gain"], "2");
    assert!(sine.by_hand.is_empty(), "nobody desires anything of it");
}

#[tokio::test]
async fn connectors_are_removed_and_made_again_as_they_were() {
    let node = Node::start().await;
    node.hello().await;
    let name = "Sine0.out-Filter0.in";
    insta::assert_snapshot!(refusals(&node, vec![
        disconnect("Sine0", "Sine0.out-Fliter0.in"),
        disconnect("Printer0", name),
    ]).await, @r"
    404 not-found: Sine0 has no connector Sine0.out-Fliter0.in; did you mean `Sine0.out-Filter0.in`?
    404 not-found: Printer0 has no connector Sine0.out-Filter0.in; it has none
    ");
    insta::assert_snapshot!(say(&done(&node, disconnect("Sine0", name)).await), @r#"
    connector/Sine0.out-Filter0.in changed Some("hello") Some("repair")
      system hello repairs drift: it will be put back; see rtsctl.drift of Sine0
    "#);
    let sine = observed(&node, "Sine0").await;
    assert!(sine.connectors.is_empty());
    assert_eq!(sine.by_hand.disconnected[name], first().digest());
    assert!(!done(&node, disconnect("Sine0", name)).await.changed);
    assert_eq!(
        refused(&node, disconnect("Sine0", "nobody")).await.status,
        404
    );
    insta::assert_snapshot!(say(&done(&node, connect("Sine0.out", "Filter0.in", None)).await), @r#"connector/Sine0.out-Filter0.in changed Some("hello") None"#);
    let sine = observed(&node, "Sine0").await;
    assert_eq!(sine.connectors[0].by_hand, Some(first().digest()));
    assert!(sine.by_hand.is_empty());
    insta::assert_snapshot!(say(&done(&node, connect("Sine0.out", "Filter0.in", None)).await), @r#"connector/Sine0.out-Filter0.in as it was Some("hello") None"#);
}

#[tokio::test]
async fn a_connector_that_nobody_desires_is_made_and_removed() {
    let node = Node::start().await;
    node.hello().await;
    let act = connect("Sine0.out", "Printer0.in", None);
    let request = ActRequest {
        act: act.clone(),
        dry_run: true,
    };
    insta::assert_snapshot!(say(&node.agent.act(&request).await.unwrap()), @r#"
    connector/Sine0.out-Printer0.in as it was Some("hello") Some("repair")
      system hello repairs drift: it will be put back; see rtsctl.drift of Sine0
    "#);
    assert_eq!(observed(&node, "Sine0").await.connectors.len(), 1);
    insta::assert_snapshot!(say(&done(&node, act).await), @r#"
    connector/Sine0.out-Printer0.in changed Some("hello") Some("repair")
      system hello repairs drift: it will be put back; see rtsctl.drift of Sine0
    "#);
    let sine = observed(&node, "Sine0").await;
    let made = &sine.connectors[1];
    assert_eq!(made.name, "Sine0.out-Printer0.in");
    assert_eq!(
        (made.by_hand.as_deref(), made.samples_received),
        (Some(""), 7)
    );
    insta::assert_snapshot!(say(&done(&node, disconnect("Sine0", "Sine0.out-Printer0.in")).await), @r#"connector/Sine0.out-Printer0.in changed Some("hello") None"#);
    assert!(observed(&node, "Sine0").await.by_hand.is_empty());
    // Between what belongs to no system and what does.
    let wish = CreateByHand {
        type_name: "Sine".to_owned(),
        instance: None,
        parameters: BTreeMap::new(),
        rate: None,
    };
    node.agent.create("bench", &wish).await.unwrap();
    insta::assert_snapshot!(say(&done(&node, connect("Sine1.out", "Printer0.in", Some("mine"))).await), @"connector/mine changed None None");
    let sine = observed(&node, "Sine1").await;
    let made = &sine.connectors[0];
    assert_eq!((made.name.as_str(), &made.by_hand), ("mine", &None));
    assert_eq!(made.samples_received, 7);
}

#[tokio::test]
async fn ends_that_do_not_fit_are_refused_with_advice() {
    let node = Node::start().await;
    node.hello().await;
    done(&node, connect("Sine0.out", "Printer0.in", Some("mine"))).await;
    insta::assert_snapshot!(refusals(&node, vec![
        connect("Filter0.in", "Sine0.out", None),
        connect("Filter0.in", "Printer0.in", None),
        connect("Filter0.out", "Sine0.out", None),
        connect("Filter0.uot", "Printer0.in", None),
        connect("Filter0.out", "Printer9.in", None),
        connect("Filter0.out", "Printer0.in", Some("mine")),
        connect("Sine0.out", "Filter0.in", Some("mine")),
        connect("Sine0.out", "Printer0.in", Some("Sine0.out-Filter0.in")),
        connect("Sine0.out", "Printer0.in", Some(" ")),
        connect("Sine0.out", "Printer0.in", Some("a\nb")),
        connect("Sine0.out", "Printer0.in", Some("a/b")),
    ]).await, @r#"
    422 wrong-direction: Filter0.in is an in-port and Sine0.out an out-port: a connector goes the other way round: rtsctl connect Sine0.out Filter0.in
    422 wrong-direction: Filter0.in is an in-port: a connector goes from an out-port to an in-port; out-ports of Filter0: out
    422 wrong-direction: Sine0.out is an out-port: a connector goes from an out-port to an in-port; in-ports of Sine0: in
    404 not-found: Filter0 has no port uot; did you mean `out`? ports: in, out
    404 not-found: node local has no component Printer9; did you mean `Printer0`? components: Filter0, Printer0, Sine0; both ends of a connector that no system has must be on one node: put one between nodes into the profile and apply it
    409 name-taken: Sine0 has a connector mine already, from Sine0.out to Printer0.in; disconnect that first (rtsctl disconnect mine), or choose another name
    409 name-taken: Sine0 has a connector mine already, from Sine0.out to Printer0.in; disconnect that first (rtsctl disconnect mine), or choose another name
    409 name-taken: Sine0.out-Filter0.in is the name of the connector from Sine0.out to Filter0.in in this system; choose another one
    422 invalid-name: " " is no name of a connector: it is empty
    422 invalid-name: "a\nb" is no name of a connector: it has a control character
    422 invalid-name: "a/b" is no name of a connector: it has a `/`
    "#);
}

#[tokio::test]
async fn the_policy_says_what_becomes_of_a_change() {
    let node = Node::start().await;
    node.hello().await;
    accept(&node, 2, |spec| {
        let components = &mut spec.systems[0].components;
        components[0].spec.policy.drift = DriftPolicy::Ignore;
        components[1].spec.policy.drift = DriftPolicy::Adopt;
    })
    .await;
    insta::assert_snapshot!(say(&done(&node, deactivate("Sine0")).await), @r#"
    component/Sine0 changed Some("hello") Some("ignore")
      system hello leaves it so (rtsctl.drift of Sine0 is ignore)
    "#);
    insta::assert_snapshot!(say(&done(&node, deactivate("Filter0")).await), @r#"
    component/Filter0 changed Some("hello") Some("ignore")
      no profile can say that Filter0 is Inactive, so that it is not adopted, but left so until it is activated or made again
    "#);
    insta::assert_snapshot!(say(&done(&node, disconnect("Filter0", "Filter0.out-Printer0.in")).await), @r#"
    connector/Filter0.out-Printer0.in changed Some("hello") Some("adopt")
      system hello takes it over (rtsctl.drift of Filter0 is adopt)
    "#);
    accept(&node, 3, |spec| {
        spec.systems[0].components.remove(0);
        spec.systems[0].connectors.remove(0);
    })
    .await;
    insta::assert_snapshot!(say(&done(&node, activate("Sine0")).await), @r#"
    component/Sine0 changed Some("hello") None
      system hello is to be without Sine0: it is about to be removed
    "#);
}

#[tokio::test]
async fn marks_are_forgotten_when_something_else_is_desired() {
    let node = Node::start().await;
    node.hello().await;
    done(&node, deactivate("Filter0")).await;
    done(&node, disconnect("Sine0", "Sine0.out-Filter0.in")).await;
    done(&node, connect("Sine0.out", "Printer0.in", None)).await;
    let inventory = node.agent.inventory().await.unwrap();
    assert!(!component(&inventory, "Filter0").by_hand.is_empty());
    // The same again changes nothing.
    accept(&node, 2, |_| {}).await;
    let inventory = node.agent.inventory().await.unwrap();
    let sine = component(&inventory, "Sine0");
    assert!(
        sine.by_hand
            .disconnected
            .contains_key("Sine0.out-Filter0.in")
    );
    assert_eq!(sine.connectors[0].by_hand.as_deref(), Some(""));
    accept(&node, 3, |spec| {
        let part = &mut spec.systems[0];
        let gain = ("gain".to_owned(), "2".to_owned());
        let set = BTreeMap::from([gain]);
        let configuration = &mut part.components[1].spec.configuration;
        configuration.sets.insert("default".to_owned(), set);
        part.connectors[0] = connector("Sine0", "main", "Printer0", "Printer0");
    })
    .await;
    node.until(|i| {
        let (sine, filter) = (component(i, "Sine0"), component(i, "Filter0"));
        let made = sine.connectors.iter().all(|c| c.by_hand.is_none());
        made && sine.by_hand.is_empty() && filter.by_hand.deactivated.is_some()
    })
    .await;
    // That it is to be Active never changes.
    done(&node, activate("Filter0")).await;
    assert!(observed(&node, "Filter0").await.by_hand.is_empty());
}

/// hello with a policy for the drift of Filter0, and its gain.
fn wish(spec: &mut NodeSpec, gain: &str) {
    let filter = &mut spec.systems[0].components[1].spec;
    filter.policy.drift = DriftPolicy::Adopt;
    let gain = BTreeMap::from([("gain".to_owned(), gain.to_owned())]);
    filter.configuration.sets.insert("default".to_owned(), gain);
}

async fn mark(node: &Node) -> Mark {
    Mark::of(&observed(node, "Filter0").await)
}

#[tokio::test]
async fn changes_one_right_after_the_other_are_all_marked() {
    let (node, _) = crate::real_manager::hello().await;
    accept(&node, 2, |spec| wish(spec, "1")).await;
    let act = |name: &str, value: &str| done(&node, configure("Filter0", None, &[(name, value)]));
    let gains: Vec<String> = (100..110).map(|gain| gain.to_string()).collect();
    let all = gains.iter().map(|gain| act("gain", gain));
    tokio::join!(
        futures_util::future::join_all(all),
        act("alpha", "0.5"),
        done(&node, deactivate("Filter0")),
    );
    let marked = mark(&node).await;
    let gain = mark::path("default", "gain");
    let alpha = mark::path("default", "alpha");
    assert!(gains.iter().all(|value| marked.covers(&gain, value)));
    assert!(marked.covers(&gain, "1") && marked.covers(&alpha, "0.5"));

    // A plan ends the mark of what it sets, and only that.
    let values = BTreeMap::from([("alpha".to_owned(), "0.25".to_owned())]);
    let manager = node.agent.inventory().await.unwrap();
    let mut managers = manager.managers.into_iter();
    let holds = |m: &ManagerObserved| m.components.iter().any(|c| c.instance == "Filter0");
    let work = Work::Configure {
        manager: managers.find(holds).unwrap().key,
        instance: "Filter0".to_owned(),
        configuration: Configuration {
            active: None,
            sets: BTreeMap::from([("default".to_owned(), values)]),
        },
        rate: None,
        on_disconnect: None,
        order: None,
    };
    let set = crate::setup::batch("set", 2, vec![step(1, &[], "Filter0", work)]);
    assert_eq!(node.outcomes(&set).await[0].1, "ok");
    let marked = mark(&node).await;
    assert!(marked.covers(&gain, "1") && !marked.covers(&alpha, "0.5"));

    // An earlier change was adopted meanwhile: the later ones are still marked.
    accept(&node, 3, |spec| wish(spec, "103")).await;
    assert!(mark(&node).await.covers(&gain, "103"));
    // And what is as desired is not.
    let filter = observed(&node, "Filter0").await;
    let last = filter.configuration.sets["default"]["gain"].clone();
    accept(&node, 4, |spec| wish(spec, &last)).await;
    let filter = node
        .until(|i| component(i, "Filter0").by_hand.configured.is_none())
        .await;
    let filter = component(&filter, "Filter0");
    assert!(filter.by_hand.deactivated.is_some());
    assert_eq!(filter.state, LifeCycleState::Inactive);
}

#[tokio::test]
async fn values_that_no_profile_can_hold_are_refused() {
    let (node, _) = crate::real_manager::hello().await;
    insta::assert_snapshot!(refusals(&node, vec![
        configure("Printer0", None, &[("prefix", "a\u{7}b")]),
        configure("Printer0", None, &[("prefix", "a\r\n")]),
    ]).await, @r"
    422 invalid-value: the value of prefix has the control character U+0007: of those, a value may have only tab and newline
    422 invalid-value: the value of prefix has the control character U+000D: of those, a value may have only tab and newline
    ");
    done(&node, configure("Printer0", None, &[("prefix", "a\tb\n")])).await;
}

#[tokio::test]
async fn an_end_that_does_not_run_without_its_connector_is_named() {
    let node = Node::start().await;
    node.hello().await;
    for (generation, policy) in [(2, DriftPolicy::Ignore), (3, DriftPolicy::Adopt)] {
        accept(&node, generation, |spec| {
            let components = &mut spec.systems[0].components;
            components[0].spec.policy.drift = policy;
            components[0].spec.policy.on_disconnect = OnDisconnect::Deactivate;
            components[1].spec.policy.on_disconnect = OnDisconnect::Stop;
        })
        .await;
        let act = disconnect("Sine0", "Sine0.out-Filter0.in");
        let dry_run = true;
        let acted = node.agent.act(&ActRequest { act, dry_run }).await.unwrap();
        match policy {
            DriftPolicy::Ignore => insta::assert_snapshot!(say(&acted), @r#"
            connector/Sine0.out-Filter0.in as it was Some("hello") Some("ignore")
              system hello leaves it so (rtsctl.drift of Sine0 is ignore)
              Sine0 is deactivated without it (rtsctl.onDisconnect of Sine0 is deactivate)
              Filter0 is deactivated without it (rtsctl.onDisconnect of Filter0 is stop)
            "#),
            _ => insta::assert_snapshot!(say(&acted), @r#"
            connector/Sine0.out-Filter0.in as it was Some("hello") Some("adopt")
              system hello takes it over (rtsctl.drift of Sine0 is adopt)
              Sine0 is deactivated without it until that is taken over (rtsctl.onDisconnect of Sine0 is deactivate)
              Filter0 is deactivated without it until that is taken over (rtsctl.onDisconnect of Filter0 is stop)
            "#),
        }
    }
    // To what the system does not have, nothing is adopted.
    let other = CreateByHand {
        type_name: "Printer".to_owned(),
        instance: None,
        parameters: BTreeMap::new(),
        rate: None,
    };
    node.agent.create("bench", &other).await.unwrap();
    insta::assert_snapshot!(say(&done(&node, connect("Sine0.out", "Printer1.in", None)).await), @r#"
    connector/Sine0.out-Printer1.in changed Some("hello") Some("ignore")
      Printer1 is not in system hello, so that the connector is not adopted, but left until it is disconnected or an end is made again
    "#);
}

#[tokio::test]
async fn a_manager_that_keeps_no_marks_is_named() {
    let node = Node::with("old", None).await;
    node.hello().await;
    insta::assert_snapshot!(say(&done(&node, deactivate("Filter0")).await), @r#"
    component/Filter0 changed Some("hello") Some("repair")
      manager hello.main is of an older version, which does not keep what was changed by hand: system hello puts it back, whatever rtsctl.drift says, until that process is started again
    "#);
    assert!(observed(&node, "Filter0").await.by_hand.is_empty());
    insta::assert_snapshot!(say(&done(&node, deactivate("Filter0")).await), @r#"component/Filter0 as it was Some("hello") None"#);
    done(&node, connect("Sine0.out", "Printer0.in", None)).await;
    done(&node, disconnect("Sine0", "Sine0.out-Filter0.in")).await;
}

#[tokio::test]
async fn real_components_are_changed_refuse_and_are_marked() {
    let (node, _) = crate::real_manager::hello().await;
    insta::assert_snapshot!(refusals(&node, vec![configure("Filter0", None, &[("gian", "2")])]).await, @"422 unknown-parameter: Filter0 has no parameter gian; did you mean `gain`? parameters: alpha, gain");
    // What only the component knows is found when it is asked.
    let refused = refused(&node, configure("Filter0", None, &[("alpha", "1.5")])).await;
    insta::assert_snapshot!(refused, @"Filter0: parameter `alpha` = `1.5`: must be above 0 and at most 1");
    let filter = observed(&node, "Filter0").await;
    assert!(filter.by_hand.is_empty());
    let act = configure("Filter0", None, &[("gain", "2"), ("alpha", "0.5")]);
    insta::assert_snapshot!(say(&done(&node, act.clone()).await), @r#"
    component/Filter0 changed Some("hello") Some("repair")
      system hello repairs drift: it will be put back; see rtsctl.drift of Filter0
    "#);
    assert!(!done(&node, act).await.changed);
    done(&node, deactivate("Filter0")).await;
    let name = "Sine0.out-Filter0.in";
    done(&node, disconnect("Sine0", name)).await;
    let extra = connect("Sine0.out", "Printer0.in", None);
    insta::assert_snapshot!(say(&done(&node, extra).await), @r#"
    connector/Sine0.out-Printer0.in changed Some("hello") Some("repair")
      system hello repairs drift: it will be put back; see rtsctl.drift of Sine0
    "#);
    let inventory = node.agent.inventory().await.unwrap();
    let (sine, filter) = (
        component(&inventory, "Sine0"),
        component(&inventory, "Filter0"),
    );
    insta::assert_snapshot!(filter.by_hand.configured.as_ref().unwrap(), @r#"{"configuration.default.alpha":["0.1"],"configuration.default.gain":["1.0"]}"#);
    assert_eq!(filter.by_hand.deactivated, Some(settings("Filter0")));
    assert_eq!(filter.configuration.sets["default"]["gain"], "2");
    assert_eq!(sine.by_hand.disconnected[name], first().digest());
    assert_eq!(sine.connectors[0].by_hand.as_deref(), Some(""));
    // Samples flow through what a person made, to another process.
    node.until(|i| component(i, "Sine0").connectors[0].samples_received > 3)
        .await;

    done(&node, connect("Sine0.out", "Filter0.in", None)).await;
    done(&node, activate("Filter0")).await;
    let parted = disconnect("Sine0", "Sine0.out-Printer0.in");
    insta::assert_snapshot!(say(&done(&node, parted).await), @r#"connector/Sine0.out-Printer0.in changed Some("hello") None"#);
    accept(&node, 2, |spec| {
        let values = [("gain", "2"), ("alpha", "0.75")];
        let values = values.map(|(name, value)| (name.to_owned(), value.to_owned()));
        let configuration = &mut spec.systems[0].components[1].spec.configuration;
        let set = BTreeMap::from(values);
        configuration.sets.insert("default".to_owned(), set);
    })
    .await;
    node.until(|i| component(i, "Filter0").by_hand.is_empty())
        .await;
    let inventory = node.agent.inventory().await.unwrap();
    let sine = component(&inventory, "Sine0");
    assert_eq!(sine.connectors.len(), 1);
    assert_eq!(sine.connectors[0].by_hand, Some(first().digest()));
    assert!(sine.by_hand.is_empty());
}

#[tokio::test]
async fn what_nobody_knows_how_to_do_is_refused() {
    let node = Node::start().await;
    let http =
        rts_http::client::Client::unix(node.run().join("agent.sock"), crate::setup::PATIENCE);
    let http = http.unwrap();
    let body = serde_json::json!({"act": {"act": "explode", "instance": "Sine0"}});
    let sent =
        http.send::<_, serde_json::Value>(reqwest::Method::POST, rts_agent_api::paths::ACTS, &body);
    assert_eq!(problem(sent.await).status, 422);
}
