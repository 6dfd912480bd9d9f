//! What the agent of another node asks: to let a connector come to an in-port.

use rts_agent_api::AgentApi;
use rts_agent_api::messages::BindRequest;
use rts_plan::desired::PlacedConnector;

use crate::setup::{Node, component, connector, hello_spec, problem, system};

/// From Sine0 on node arm to Filter0 here.
fn from_arm() -> PlacedConnector {
    let mut connector = connector("Sine0", "main", "Filter0", "main");
    connector.source.node = "arm".to_owned();
    connector
}

/// A node that runs Filter0 and Printer0, and is told of connectors from arm to Filter0 and to what does not run.
async fn node() -> Node {
    let node = Node::start().await;
    node.hello().await;
    let mut spec = hello_spec(2);
    let mut gone = connector("Sine0", "main", "Gone0", "gone");
    gone.source.node = "arm".to_owned();
    spec.spec.systems[0].connectors = vec![from_arm(), gone];
    spec.digest = rts_plan::place::digest(&spec.spec);
    node.agent.put_node_spec(&spec).await.unwrap();
    node
}

fn request(connector: PlacedConnector) -> BindRequest {
    BindRequest {
        system: system(),
        connector,
    }
}

#[tokio::test]
async fn a_connector_that_the_node_was_told_of_is_let_in_however_often_it_is_asked() {
    let node = node().await;
    let filter = component(&node.agent.inventory().await.unwrap(), "Filter0").clone();
    let first = node.agent.bind(&request(from_arm())).await.unwrap();
    assert_eq!(first.incarnation, filter.incarnation);
    let socket = std::path::Path::new(&first.socket);
    assert!(socket.starts_with(node.run()) && socket.ends_with("control.sock"));
    assert!(socket.exists());
    // Properties are the out-port's business: this node may have been told of other ones.
    let mut other = from_arm();
    let properties = &mut other.spec.properties;
    properties.insert("dataport.subscription_type".to_owned(), "new".to_owned());
    assert_eq!(node.agent.bind(&request(other)).await.unwrap(), first);
}

#[tokio::test]
async fn nothing_else_is_let_in() {
    let node = node().await;
    let changed = |change: fn(&mut BindRequest)| {
        let mut request = request(from_arm());
        change(&mut request);
        request
    };
    let wrong = [
        changed(|r| r.system.uid.push('x')),
        changed(|r| r.connector.source.node = "base".to_owned()),
        changed(|r| r.connector.spec.source.port = "other".to_owned()),
        changed(|r| r.connector.spec.target.instance = "Printer0".to_owned()),
        changed(|r| r.connector.target.manager = "Printer0".to_owned()),
        changed(|r| r.connector.target.node = "arm".to_owned()),
        changed(|r| r.connector.spec.name.push('x')),
    ];
    for request in wrong {
        let refused = problem(node.agent.bind(&request).await);
        assert_eq!(
            (refused.status, refused.code.as_str()),
            (409, "not-expected"),
            "{request:?}"
        );
    }
    let inventory = node.agent.inventory().await.unwrap();
    let ends = &component(&inventory, "Filter0").bindings;
    assert!(
        ends.iter()
            .all(|end| end.source.as_ref().is_none_or(|s| s.port != "other"))
    );

    let mut gone = connector("Sine0", "main", "Gone0", "gone");
    gone.source.node = "arm".to_owned();
    let refused = problem(node.agent.bind(&request(gone)).await);
    assert_eq!((refused.status, refused.code.as_str()), (503, "no-manager"));
    assert!(refused.detail.contains("hello.gone"), "{refused}");
}
