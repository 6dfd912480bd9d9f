//! The same by a node that is reached by SSH alone: with a session for each command, and with one that is kept.

use std::path::Path;
use std::thread::sleep;
use std::time::Duration;

use anyhow::Result;
use rts_test_sshd::{HOST, Server};

use super::{Case, MANY, Profile, apply, teardown};
use crate::bench::stack::Stack;

/// How the row and the node of each way is called, and the seconds that its session is kept; none for the usual minute.
const WAYS: [(&str, Option<u64>); 2] = [("cold", Some(1)), ("kept", None)];
/// After so long nothing is left of a session that is kept for a second.
const GONE: Duration = Duration::from_millis(3500);

/// A stack with a node for each way; none, and told so, when `rtsctl` cannot reach nodes in this way.
pub fn stack(programs: &Path, server: &Server) -> Result<Option<Stack>> {
    let stack = Stack::start(programs)?;
    let help = stack.output(&["node", "add", "--help"]).unwrap_or_default();
    let config = ["--ssh-config", "--config"];
    let config = config.into_iter().find(|option| help.contains(option));
    let (true, true, Some(config)) = (help.contains("--ssh"), help.contains("--keep"), config)
    else {
        eprintln!(
            "rtsctl has no `node add --ssh --keep --ssh-config`: the rows of ssh-fallback are left out"
        );
        stack.stop()?;
        return Ok(None);
    };
    let settings = server.config();
    let settings = settings.to_string_lossy();
    for (node, keep) in WAYS {
        let keep = keep.map(|seconds| seconds.to_string());
        let mut words = vec![
            "node", "add", "--ssh", HOST, "--name", node, config, &settings,
        ];
        words.extend(keep.iter().flat_map(|seconds| ["--keep", seconds]));
        stack.rtsctl(&words)?;
    }
    Ok(Some(stack))
}

/// The rows: one component, ten in a process each, ten in one process.
pub fn cases(stack: &Stack) -> Result<Vec<Case<'_>>> {
    let mut cases = Vec::new();
    for (node, keep) in WAYS {
        let shapes = [
            ("1", "one", 1, true),
            ("10", "ten", MANY, true),
            ("10-same", "same", MANY, false),
        ];
        for (shape, system, components, isolated) in shapes {
            let profile = Profile::new(system, components, isolated).on(node);
            let file = profile.write_as(&format!("{node}-{system}"), stack.folder.path())?;
            let row = format!("ssh-fallback-{shape}-{node}");
            cases.push(Case::one(&row, components, move || {
                if keep.is_some() {
                    sleep(GONE);
                }
                let took = apply(stack, &file);
                teardown(stack, system)?;
                took
            }));
        }
    }
    Ok(cases)
}
