//! Names of what steps, changes and blocks speak of. The controller blocks a target by the same text.

use crate::desired::ManagerKey;
use crate::plan::Blocked;

/// `component/Sine0`
pub fn component(instance: &str) -> String {
    format!("component/{instance}")
}

/// `connector/Sine0.out-Filter0.in`
pub fn connector(name: &str) -> String {
    format!("connector/{name}")
}

/// `manager/hello.main`
pub fn manager(key: &ManagerKey) -> String {
    format!("manager/{}", key.display_name())
}

/// `module/Printer@hello.Printer0`: a module in a manager.
pub fn module(type_name: &str, key: &ManagerKey) -> String {
    format!("module/{type_name}@{}", key.display_name())
}

/// `package/Printer@local`: a module file on a node.
pub fn package(type_name: &str, node: &str) -> String {
    format!("package/{type_name}@{node}")
}

/// `node/local`
pub fn node(name: &str) -> String {
    format!("node/{name}")
}

/// `local|component/Sine0`: a target on one node, the key of [`Blocked`].
pub fn on(node: &str, target: &str) -> String {
    format!("{node}|{target}")
}

/// Why a target must not be tried on a node now. Its name is made only when anything is blocked at all: most of the time
/// nothing is, and names are what a plan spends its time on.
pub(crate) fn why_blocked<'b>(
    blocked: &'b Blocked,
    node: &str,
    target: impl FnOnce() -> String,
) -> Option<&'b String> {
    if blocked.is_empty() {
        return None;
    }
    blocked.get(&on(node, &target()))
}
