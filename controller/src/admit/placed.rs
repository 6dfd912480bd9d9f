//! What placing a candidate says of it.

use std::collections::{BTreeMap, BTreeSet};

use rts_controller_api::{Problem, ProblemError};
use rts_plan::{PlaceError, Placed};

use super::{check, describe, modules, summary};
use crate::store::SystemRecord;

/// Node → types that it must have → the components that need them, and whether those are required.
pub type Types = BTreeMap<String, BTreeMap<String, BTreeMap<String, bool>>>;

/// What the modules of a system's components say of themselves, as far as they say it.
pub fn described<'a>(
    placed: &'a Placed,
    candidate: &SystemRecord,
    found: &'a modules::Found,
) -> describe::Descriptions<'a> {
    let nodes = placed.desired.nodes.iter();
    let parts = nodes.flat_map(|(node, spec)| spec.systems.iter().map(move |part| (node, part)));
    parts
        .filter(|(_, part)| part.system.uid == candidate.uid)
        .flat_map(|(node, part)| part.components.iter().map(move |c| (node, &c.spec)))
        .filter(|(_, component)| !found.stand_ins.contains(&component.instance))
        .filter_map(|(node, component)| {
            let description = found.described.get(node)?.get(&component.type_name)?;
            Some((component.instance.as_str(), description))
        })
        .collect()
}

/// Refuses a candidate that wants another system's instance names; a clash between two others is not its fault.
pub fn clashes(placed: &Placed, candidate: &SystemRecord) -> Result<(), Problem> {
    let mut clashes = Vec::new();
    for problem in &placed.problems {
        if let PlaceError::InstanceClash {
            instance, systems, ..
        } = problem
            && systems.iter().any(|system| system == candidate.name())
        {
            clashes.push(ProblemError {
                pointer: check::pointer(&candidate.spec, instance),
                code: "instance-clash".to_owned(),
                detail: problem.to_string(),
                help: Some("rename the instance, or tear the other system down".to_owned()),
            });
        }
    }
    let Some(first) = clashes.first() else {
        return Ok(());
    };
    let detail = summary(&first.detail, clashes.len());
    Err(Problem::conflict("instance-clash", detail).with_errors(clashes))
}

/// What a system needs of the nodes that are known.
#[derive(Debug, Default)]
pub struct Needs {
    /// By node.
    pub types: Types,
    /// A fault for each required component on a node that nobody knows.
    pub faults: Vec<ProblemError>,
    /// A remark for each optional one: it waits for its node.
    pub notes: Vec<String>,
}

/// What a system needs of the nodes that are known, and what is to be said of those that are not.
pub fn needs(placed: &Placed, candidate: &SystemRecord) -> Needs {
    let mut needs = Needs::default();
    let mut unknown = BTreeSet::new();
    for problem in &placed.problems {
        if let PlaceError::UnknownNode {
            system,
            component,
            node,
            ..
        } = problem
            && system == candidate.name()
        {
            unknown.insert(node);
            needs.unknown(candidate, component, problem);
        }
    }
    for problem in &placed.problems {
        if let PlaceError::ContextApart {
            system, components, ..
        } = problem
            && system == candidate.name()
        {
            needs.faults.push(ProblemError {
                pointer: check::pointer(&candidate.spec, &components[1]),
                code: "execution-context-apart".to_owned(),
                detail: problem.to_string(),
                help: Some(
                    "give both the same node and manager, or each its own execution context"
                        .to_owned(),
                ),
            });
        }
    }
    let known = placed.desired.nodes.iter();
    for (node, spec) in known.filter(|(node, _)| !unknown.contains(node)) {
        let parts = spec.systems.iter();
        for part in parts.filter(|part| part.system.uid == candidate.uid) {
            for component in &part.components {
                let spec = &component.spec;
                let of_node = needs.types.entry(node.clone()).or_default();
                let of_type = of_node.entry(spec.type_name.clone()).or_default();
                of_type.insert(spec.instance.clone(), spec.required);
            }
        }
    }
    needs
}

impl Needs {
    fn unknown(&mut self, candidate: &SystemRecord, component: &str, problem: &PlaceError) {
        let mut all = candidate.spec.components.iter();
        if all.any(|c| c.instance == *component && !c.required) {
            self.notes.push(format!(
                "{problem}: it is optional and waits, the rest runs"
            ));
            return;
        }
        self.faults.push(ProblemError {
            pointer: check::pointer(&candidate.spec, component),
            code: "unknown-node".to_owned(),
            detail: problem.to_string(),
            help: Some("start an agent on that node, or change rtsctl.node".to_owned()),
        });
    }
}
