//! What a picture shows: blocks with ports, in frames, and wires between ports.

use std::collections::BTreeSet;

use rts_controller_api::objects::{Component, Connector};
use rts_schemas::system::{ComponentSpec, Direction, PortKind, PortRef, PortSpec, SystemSpec};

/// State of what nobody reports.
const UNKNOWN: &str = "Unknown";

/// All of it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Model {
    /// Name of the system.
    pub name: String,
    /// Nodes, sorted.
    pub frames: Vec<String>,
    /// Components, in the order of the profile.
    pub blocks: Vec<Block>,
    /// Connectors, in the order of the profile.
    pub wires: Vec<Wire>,
}

/// A component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Instance name.
    pub name: String,
    /// Type name.
    pub type_name: String,
    /// `Active`.
    pub state: String,
    /// It stands in for another one.
    pub stand_in: bool,
    /// Index of its frame.
    pub frame: usize,
    /// Ports on its left side: what comes in.
    pub left: Vec<String>,
    /// Ports on its right side: what goes out.
    pub right: Vec<String>,
}

/// A connector: from the right side of a block to the left side of one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wire {
    /// Name.
    pub name: String,
    /// Data or service.
    pub kind: PortKind,
    /// `Connected`.
    pub state: String,
    /// Index of its block, and of its port there.
    pub from: (usize, usize),
    /// Index of its block, and of its port there.
    pub to: (usize, usize),
}

/// A system with the states of its parts.
pub fn of(spec: &SystemSpec, components: &[Component], connectors: &[Connector]) -> Model {
    let node = |c: &ComponentSpec| node_of(c, components);
    let nodes: BTreeSet<String> = spec.components.iter().map(node).collect();
    let frames: Vec<String> = nodes.into_iter().collect();
    let mut blocks: Vec<Block> = Vec::new();
    for component in &spec.components {
        let node = node(component);
        let frame = frames.iter().position(|name| *name == node);
        blocks.push(block(component, frame.unwrap_or_default(), components));
    }
    let mut wires = Vec::new();
    for connector in &spec.connectors {
        let from = end(&mut blocks, &connector.source, |block| &mut block.right);
        let to = end(&mut blocks, &connector.target, |block| &mut block.left);
        let Some((from, to)) = from.zip(to) else {
            continue;
        };
        let mut seen = connectors.iter();
        let seen = seen.find(|c| c.metadata.name == connector.name);
        wires.push(Wire {
            name: connector.name.clone(),
            kind: connector.kind,
            state: seen.map_or(UNKNOWN, |c| &c.status.state).to_owned(),
            from,
            to,
        });
    }
    for (block, component) in blocks.iter_mut().zip(&spec.components) {
        for port in &component.ports {
            if !block.left.contains(&port.name) && !block.right.contains(&port.name) {
                block.right.push(port.name.clone());
            }
        }
    }
    Model {
        name: spec.name.clone(),
        frames,
        blocks,
        wires,
    }
}

fn seen<'c>(spec: &ComponentSpec, components: &'c [Component]) -> Option<&'c Component> {
    components.iter().find(|c| c.metadata.name == spec.instance)
}

/// Where it is; where it is to be, when nobody has seen it.
fn node_of(spec: &ComponentSpec, components: &[Component]) -> String {
    let seen = seen(spec, components).map(|c| &c.status.node);
    let placement = &spec.placement;
    let wanted = placement.node.as_ref().or(placement.host.as_ref());
    let node = seen.filter(|node| !node.is_empty()).or(wanted);
    node.map_or("local", String::as_str).to_owned()
}

fn block(spec: &ComponentSpec, frame: usize, components: &[Component]) -> Block {
    let seen = seen(spec, components);
    let ports = |direction: Direction| {
        let own = spec
            .ports
            .iter()
            .filter(move |p| side(p) == Some(direction));
        own.map(|port| port.name.clone()).collect()
    };
    Block {
        name: spec.instance.clone(),
        type_name: spec.type_name.clone(),
        state: seen.map_or(UNKNOWN, |c| &c.status.state).to_owned(),
        stand_in: seen.is_some_and(|c| c.status.stand_in),
        frame,
        left: ports(Direction::In),
        right: ports(Direction::Out),
    }
}

/// The side of a port that may be without a connector; none for one that is only where its connectors have it.
fn side(port: &PortSpec) -> Option<Direction> {
    match port.kind {
        PortKind::Data => port.direction,
        PortKind::Service => None,
    }
}

/// The port of an end on the side that is meant, which gets it when it has none of that name.
fn end(
    blocks: &mut [Block],
    port: &PortRef,
    side: fn(&mut Block) -> &mut Vec<String>,
) -> Option<(usize, usize)> {
    let block = blocks.iter().position(|b| b.name == port.instance)?;
    let ports = side(&mut blocks[block]);
    let at = ports.iter().position(|name| *name == port.port);
    let at = at.unwrap_or_else(|| {
        ports.push(port.port.clone());
        ports.len() - 1
    });
    Some((block, at))
}

impl Block {
    /// Its type, and that it is a stand-in.
    pub fn title(&self) -> String {
        let type_name = &self.type_name;
        match self.stand_in {
            true => format!("{type_name} (stand-in)"),
            false => type_name.clone(),
        }
    }
}
