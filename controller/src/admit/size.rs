//! What is admitted must fit through every door: to a node's agent, into a manager, into lists and backups.

use rts_controller_api::{Problem, ProblemError};
use rts_plan::Placed;
use rts_schemas::system::SystemSpec;

use super::check;
use crate::json_size::json_size;
use crate::store::SystemRecord;

/// Largest spec of one node, as JSON; an agent takes requests of twice that.
const MAX_NODE: usize = 32 * 1024 * 1024;
/// Most of all systems together, as JSON: lists are read up to 64 MiB.
const MAX_ALL: usize = 48 * 1024 * 1024;
/// Largest component or connector, as JSON: it goes to its manager in one frame of at most 4 MiB, with a little more.
const MAX_PART: usize = 4 * 1024 * 1024 - 64 * 1024;
/// Faults that are listed.
const MAX_FAULTS: usize = 100;

/// Components and connectors that no manager would take.
pub fn parts(spec: &SystemSpec) -> Vec<ProblemError> {
    let fault = |pointer: String, what: String, size: usize| ProblemError {
        pointer,
        code: "too-large".to_owned(),
        detail: format!("{what} has {size} bytes as JSON; a manager takes {MAX_PART} at once"),
        help: Some("put large data into a file, and its path into the parameter".to_owned()),
    };
    let mut faults = Vec::new();
    for component in &spec.components {
        let size = json_size(component);
        if size > MAX_PART && faults.len() < MAX_FAULTS {
            let pointer = check::pointer(spec, &component.instance);
            faults.push(fault(
                pointer,
                format!("component {}", component.instance),
                size,
            ));
        }
    }
    for (index, connector) in spec.connectors.iter().enumerate() {
        let size = json_size(connector);
        if size > MAX_PART && faults.len() < MAX_FAULTS {
            let pointer = format!("/spec/connectors/{index}");
            faults.push(fault(
                pointer,
                format!("connector {}", connector.name),
                size,
            ));
        }
    }
    faults
}

/// Refuses a candidate that makes the spec of a node of its, or all systems together, too large.
pub fn whole<'a>(
    placed: &Placed,
    uid: &str,
    records: impl Iterator<Item = &'a SystemRecord>,
) -> Result<(), Problem> {
    let of = |node: &&rts_plan::desired::NodeSpec| node.systems.iter().any(|s| s.system.uid == uid);
    for node in placed.desired.nodes.values().filter(of) {
        let size = json_size(node);
        if size > MAX_NODE {
            return Err(too_large(format!(
                "all that node {} is to run would have {size} bytes as JSON, and {MAX_NODE} can be sent to it; tear other \
                 systems down, or put large data into files",
                node.node
            )));
        }
    }
    let all: usize = records.map(json_size).sum();
    if all > MAX_ALL {
        return Err(too_large(format!(
            "all systems together would have {all} bytes as JSON, and {MAX_ALL} can be listed and backed up; tear other \
             systems down, or put large data into files"
        )));
    }
    Ok(())
}

fn too_large(detail: String) -> Problem {
    Problem::new(413, "too-large", "content too large", detail)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(bytes: usize) -> SystemSpec {
        let sets = serde_json::json!({"default": {"x": "y".repeat(bytes)}});
        let component =
            serde_json::json!({"instance": "A", "type": "T", "configuration": {"sets": sets}});
        let spec = serde_json::json!({"name": "s", "components": [component], "connectors": []});
        serde_json::from_value(spec).unwrap()
    }

    #[test]
    fn what_no_manager_takes_is_a_fault() {
        assert!(parts(&spec(1024)).is_empty());
        let faults = parts(&spec(MAX_PART));
        assert_eq!(faults[0].pointer, "/spec/components/0");
        assert!(faults[0].detail.contains("component A has"));
    }

    #[test]
    fn a_node_takes_only_so_much() {
        let place = |bytes: usize| {
            let system = rts_plan::StoredSystem {
                reference: rts_plan::desired::SystemRef {
                    name: "s".into(),
                    uid: "u".into(),
                },
                spec: spec(bytes),
                module_digests: [].into(),
                stand_ins: [].into(),
                deleting: false,
            };
            rts_plan::place(&[system], &[], "local")
        };
        let none = std::iter::empty;
        assert!(whole(&place(1024), "u", none()).is_ok());
        let refused = whole(&place(MAX_NODE), "u", none()).unwrap_err();
        assert_eq!((refused.status, refused.code.as_str()), (413, "too-large"));
        assert!(refused.detail.contains("node local"));
        assert!(whole(&place(MAX_NODE), "another", none()).is_ok());
    }
}
