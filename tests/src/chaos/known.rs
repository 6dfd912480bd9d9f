//! What the stack does not do yet, and what is not held against it until it does. Each is turned on when it is mended.

/// A controller that lives makes its lock file anew when somebody removes it. Without it `rtsctl up` starts another one,
/// which fails: so nobody removes that file.
pub const CONTROLLER_KEEPS_ITS_LOCK: bool = true;

/// An apply does not count it as a failure of its components that another one has changed the node's specification.
pub const APPLIES_DO_NOT_DISTURB_EACH_OTHER: bool = true;

/// An agent that starts and finds a process that hangs replaces it when its policy says so.
pub const A_NEW_AGENT_REPLACES_WHAT_HANGS: bool = true;
