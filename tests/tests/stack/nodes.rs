//! Several nodes on one machine, with connectors between them.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use rts_tests::{Stack, kill_9, processes_of};
use serde_json::Value;

use super::HELLO;

const NODES: &str = "manifests/hello/nodes.yaml";
const APPLY: [&str; 5] = ["apply", "-f", HELLO, "-f", NODES];

/// Sine0 and Printer0 on arm, Filter0 between them on base.
fn two_nodes() -> Stack {
    let stack = Stack::new();
    let said = stack.expect(0, &["up", "--node", "arm", "--node", "base"]);
    let started = "started a local controller and 2 agents (arm, base)";
    assert!(said.err.contains(started), "{said:#?}");
    stack.expect(0, &APPLY);
    flows(&stack);
    stack
}

/// Samples arrive at both in-ports: more than have before.
#[track_caller]
fn flows(stack: &Stack) {
    let received = |c: &Value| c["status"]["samplesReceived"].as_u64().unwrap_or_default();
    let connected = |c: &Value| c["status"]["state"] == "Connected";
    let before = stack.until("connectors", "both are connected", |connectors| {
        connectors.len() == 2 && connectors.iter().all(connected)
    });
    stack.until("connectors", "samples arrive at both ends", |connectors| {
        let more = |(old, new): (&Value, &Value)| connected(new) && received(new) > received(old);
        connectors.len() == 2 && before.iter().zip(connectors).all(more)
    });
}

/// Incarnation and process of each component.
fn components(stack: &Stack) -> BTreeMap<String, (String, u32)> {
    let of = |c: Value| {
        let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
        let status = &c["status"];
        let pid = status["pid"].as_u64().and_then(|pid| pid.try_into().ok());
        let name = text(&c["metadata"]["name"]);
        (
            name,
            (text(&status["incarnation"]), pid.unwrap_or_default()),
        )
    };
    stack.get("components").into_iter().map(of).collect()
}

/// The agent of a node.
fn agent(stack: &Stack, node: &str) -> u32 {
    let is = |pid: &&u32| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        let words: Vec<&[u8]> = line.split(|byte| *byte == 0).collect();
        words
            .windows(2)
            .any(|two| two == [b"--node", node.as_bytes()])
    };
    let agents = stack.daemons("rts-agent");
    *agents.iter().find(is).expect("an agent of the node")
}

/// All components are Active, and only these were made anew.
#[track_caller]
fn healed(stack: &Stack, before: &BTreeMap<String, (String, u32)>, anew: &[&str]) {
    stack.until("components", "all are Active again", |components| {
        let active = |c: &Value| c["status"]["state"] == "Active";
        let fresh = |name: &&str| {
            components.iter().any(|c| {
                c["metadata"]["name"] == **name
                    && c["status"]["incarnation"] != before[*name].0.as_str()
            })
        };
        components.len() == 3 && components.iter().all(active) && anew.iter().all(fresh)
    });
    flows(stack);
    for (name, was) in before {
        let now = &components(stack)[name];
        assert_eq!(
            now != was,
            anew.contains(&name.as_str()),
            "{name}: {was:?} is {now:?}"
        );
    }
}

#[test]
fn samples_go_from_node_to_node_and_nothing_is_left() {
    let stack = two_nodes();
    let nodes = stack.get("nodes");
    let names: Vec<_> = nodes.iter().map(|n| &n["metadata"]["name"]).collect();
    assert_eq!(names, ["arm", "base"]);
    for (component, node) in [("Sine0", "arm"), ("Filter0", "base"), ("Printer0", "arm")] {
        assert_eq!(stack.named("components", component)["status"]["node"], node);
    }
    for connector in stack.get("connectors") {
        let status = &connector["status"];
        assert_eq!(status["transport"], "tcp");
        assert!(status["samplesReceived"].as_u64() <= status["samplesSent"].as_u64());
    }
    let before = components(&stack);
    let said = stack.expect(0, &APPLY);
    assert!(said.out.contains("no changes"), "{said:#?}");
    assert_eq!(components(&stack), before, "nothing restarts");

    stack.expect(0, &["teardown", "hello", "--yes"]);
    assert_eq!(stack.get("managers").len(), 0);
    for node in ["arm", "base"] {
        let left = processes_of(&stack.home().join("run").join(node));
        assert!(left.is_empty(), "manager processes are left: {left:?}");
    }

    // A home keeps its nodes until it is purged.
    stack.expect(0, &["down"]);
    let said = stack.expect(0, &APPLY);
    assert!(said.err.contains("2 agents (arm, base)"), "{said:#?}");
    flows(&stack);
    stack.leaves_nothing();
}

#[test]
fn a_dead_manager_is_connected_again_across_nodes_and_nobody_else_restarts() {
    let stack = two_nodes();
    for name in ["Filter0", "Sine0", "Printer0"] {
        let before = components(&stack);
        kill_9(before[name].1);
        healed(&stack, &before, &[name]);
    }
    stack.leaves_nothing();
}

#[test]
fn a_dead_agent_disturbs_nobody_and_what_dies_meanwhile_is_connected_again() {
    let stack = two_nodes();
    let before = components(&stack);
    for node in ["arm", "base"] {
        kill_9(agent(&stack, node));
        stack.until("nodes", "the node is not Ready", |nodes| {
            nodes
                .iter()
                .any(|n| n["metadata"]["name"] == node && n["status"]["state"] != "Ready")
        });
        let said = stack.expect(0, &["up"]);
        let started = format!("started an agent (node {node})");
        assert!(said.err.contains(&started), "{said:#?}");
        healed(&stack, &before, &[]);
    }
    // In-ports and out-ports of both nodes have to be found anew.
    kill_9(agent(&stack, "base"));
    kill_9(before["Filter0"].1);
    kill_9(before["Printer0"].1);
    stack.expect(0, &["up"]);
    healed(&stack, &before, &["Filter0", "Printer0"]);
    stack.leaves_nothing();
}

/// What the agent of a node says of its connectors, without a controller: name → state.
fn connectors_of(stack: &Stack, node: &str) -> BTreeMap<String, String> {
    let socket = stack.home().join("run").join(node).join("agent.sock");
    let mut stream = UnixStream::connect(socket).expect("the agent serves");
    let request = "GET /v1/inventory HTTP/1.1\r\nhost: agent\r\nconnection: close\r\n\r\n";
    stream
        .write_all(request.as_bytes())
        .expect("it takes a request");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("it answers");
    let body = answer.split_once("\r\n\r\n").expect("a body").1;
    let inventory: Value = serde_json::from_str(body).expect("JSON");
    let each = |value: &Value, key: &str| value[key].as_array().cloned().unwrap_or_default();
    let components = each(&inventory, "managers")
        .into_iter()
        .flat_map(|m| each(&m, "components"));
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let connectors = components.flat_map(|c| each(&c, "connectors"));
    connectors
        .map(|c| (text(&c["name"]), text(&c["state"])))
        .collect()
}

#[test]
fn agents_alone_connect_their_nodes_again() {
    let stack = two_nodes();
    let before = components(&stack);
    stack.kill_9("rts-controller");
    kill_9(before["Filter0"].1);
    let deadline = Instant::now() + Duration::from_secs(30);
    let connected = |node, name: &str| {
        connectors_of(&stack, node)
            .get(name)
            .is_some_and(|s| s == "Connected")
    };
    // Filter0 was source and target: it is made again by its own agent, and found by the one of arm.
    while !(connected("arm", "Sine0.out-Filter0.in")
        && connected("base", "Filter0.out-Printer0.in"))
    {
        assert!(
            Instant::now() < deadline,
            "after 30 s the nodes are not connected again"
        );
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(stack.daemons("rts-controller").is_empty());
    stack.expect(0, &["up"]);
    healed(&stack, &before, &["Filter0"]);
    stack.leaves_nothing();
}

#[test]
fn hosts_of_a_profile_find_their_nodes_by_alias() {
    let stack = Stack::new();
    stack.expect(
        0,
        &["up", "--node", "arm=robot-arm.local", "--node", "base"],
    );
    let profile = std::fs::read_to_string(rts_tests::root().join(HELLO)).expect("the profile");
    let at =
        |host: &str, text: &str| text.replace("localhost/Sine0.rtc", &format!("{host}/Sine0.rtc"));
    let file = stack.write("hosts.xml", at("robot-arm.local", &profile));
    let file = file.to_str().expect("a path");
    stack.expect(0, &["apply", file]);
    let node = |component: &str| stack.named("components", component)["status"]["node"].clone();
    assert_eq!(
        (node("Sine0"), node("Filter0")),
        ("arm".into(), "arm".into())
    );

    // The agent that runs is told of its new hosts; what runs on it goes on.
    let before = components(&stack);
    let said = stack.expect(
        0,
        &[
            "up",
            "--node",
            "base=10.0.0.5,robot-base.local",
            "--node",
            "more",
        ],
    );
    assert!(said.err.contains("2 agents (base, more)"), "{said:#?}");
    assert_eq!(components(&stack), before);
    let aliases = stack.named("nodes", "base")["spec"]["aliases"].clone();
    assert_eq!(aliases, serde_json::json!(["10.0.0.5", "robot-base.local"]));
    let file = stack.write("hosts.xml", at("ROBOT-BASE.local", &profile));
    stack.expect(0, &["apply", file.to_str().expect("a path")]);
    assert_eq!(node("Sine0"), "base");
    stack.leaves_nothing();
}

#[test]
fn names_that_cannot_be_are_refused_before_anything_starts() {
    let stack = Stack::new();
    for (nodes, why) in [
        (vec!["controller.sock"], "is no name of a node"),
        (vec!["a=robot:2809"], "is no host"),
        (vec!["a=x", "b=x"], "host x would mean node a and node b"),
    ] {
        let nodes = nodes.iter().flat_map(|node| ["--node", node]);
        let arguments: Vec<&str> = ["up"].into_iter().chain(nodes).collect();
        let said = stack.expect(2, &arguments);
        assert!(said.err.contains(why), "{said:#?}");
    }
    assert!(processes_of(&stack.home()).is_empty());
}

#[test]
fn a_connector_between_nodes_is_cut_and_made_again_by_hand() {
    let stack = two_nodes();
    let left = stack.write(
        "left.yaml",
        "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n    Sine0: { drift: ignore }\n",
    );
    let left = left.to_str().expect("a path");
    stack.expect(0, &[&APPLY[..], &["-f", left]].concat());
    let before = components(&stack);
    let name = "Sine0.out-Filter0.in";
    let state = |state: &'static str| {
        stack.until("connectors", state, |connectors| {
            let mut all = connectors.iter();
            all.any(|c| c["metadata"]["name"] == name && c["status"]["state"] == state)
        });
    };
    stack.expect(0, &["disconnect", name]);
    state("Disconnected");
    stack.expect(0, &["connect", "Sine0.out", "Filter0.in"]);
    state("Connected");
    flows(&stack);
    // One that no system has is for one node only.
    let said = stack.rtsctl(&["connect", "Sine0.out", "Filter0.in", "--name", "second"]);
    assert_ne!(said.code, 0, "{said:#?}");
    let why = "put one between nodes into the profile";
    assert!(said.err.contains(why), "{said:#?}");
    assert_eq!(components(&stack), before);
    stack.leaves_nothing();
}
