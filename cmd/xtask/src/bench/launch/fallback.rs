//! The same by a node that is reached by SSH alone: with a session for each command, and with one that is kept.

use std::path::Path;

use anyhow::Result;
use rts_test_sshd::{HOST, Server};

use super::{Case, MANY, Profile, case};

use crate::bench::stack::Stack;

/// How the row of each way is called, the node of it, and the seconds that a session is kept; none for the usual.
const WAYS: [(&str, &str, Option<&str>); 2] = [("cold", "cold", Some("0")), ("kept", "kept", None)];

/// A stack with a node for each way; none, and told so, when `rtsctl` cannot reach nodes in this way.
pub fn stack(programs: &Path, server: &Server) -> Result<Option<Stack>> {
    let stack = Stack::start(programs)?;
    let help = stack.output(&["node", "add", "--help"]).unwrap_or_default();
    let config = ["--config", "-F"].into_iter().find(|o| help.contains(o));
    let (true, true, Some(config)) = (help.contains("--ssh"), help.contains("--keep"), config)
    else {
        eprintln!(
            "rtsctl has no `node add --ssh --keep --config`: the rows of ssh-fallback are left out"
        );
        stack.stop()?;
        return Ok(None);
    };
    let settings = server.config();
    let settings = settings.to_string_lossy();
    for (_, node, keep) in WAYS {
        let mut words = vec![
            "node", "add", "--ssh", HOST, "--name", node, config, &settings,
        ];
        words.extend(keep.into_iter().flat_map(|seconds| ["--keep", seconds]));
        stack.rtsctl(&words)?;
    }
    Ok(Some(stack))
}

/// The rows: one component, ten in a process each, ten in one process.
pub fn cases(stack: &Stack) -> Result<Vec<Case<'_>>> {
    let mut cases = Vec::new();
    for (way, node, _) in WAYS {
        let shapes = [
            ("1", "one", 1, true),
            ("10", "ten", MANY, true),
            ("10-same", "same", MANY, false),
        ];
        for (shape, system, components, isolated) in shapes {
            let profile = Profile::new(system, components, isolated).on(node);
            let file = profile.write_as(&format!("{node}-{system}"), stack.folder.path())?;
            let row = format!("ssh-fallback-{shape}-{way}");
            cases.push(case(&row, components, stack, system, file));
        }
    }
    Ok(cases)
}
