//! What is said of an act.

use rts_agent_api::messages::Act;

/// What an act was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Done {
    /// Something has changed.
    Yes,
    /// It was so before.
    Already,
    /// Nothing was done: it was only asked whether it could be.
    Would,
}

/// `deactivate component/Filter0`, for what cannot be done.
pub fn attempt(act: &Act) -> String {
    match act {
        Act::Activate { instance } => format!("activate component/{instance}"),
        Act::Deactivate { instance } => format!("deactivate component/{instance}"),
        Act::Reset { instance } => format!("reset component/{instance}"),
        Act::Tick { instance, .. } => format!("tick component/{instance}"),
        Act::Configure { instance, .. } => format!("configure component/{instance}"),
        Act::Connect { source, target, .. } => format!("connect {source} with {target}"),
        Act::Disconnect { connector, .. } => format!("remove connector/{connector}"),
    }
}

/// True when a component in this state needs no act.
pub fn is_so(act: &Act, state: &str) -> bool {
    match act {
        Act::Activate { .. } => state == "Active",
        Act::Deactivate { .. } | Act::Reset { .. } => state == "Inactive",
        Act::Tick { .. } | Act::Configure { .. } | Act::Connect { .. } | Act::Disconnect { .. } => {
            false
        }
    }
}

/// The line of the result: `component/Filter0 deactivated`.
pub fn result(act: &Act, target: &str, done: Done, details: &str) -> String {
    let verb = match act {
        Act::Activate { .. } => "activated",
        Act::Deactivate { .. } => "deactivated",
        Act::Reset { .. } => "reset",
        Act::Tick { .. } => "ticked",
        Act::Configure { .. } => "configured",
        Act::Connect { .. } => "connected",
        Act::Disconnect { .. } => "disconnected",
    };
    let already = match act {
        Act::Activate { .. } => "is Active already",
        Act::Deactivate { .. } | Act::Reset { .. } => "is Inactive already",
        Act::Tick { .. } => "was ticked already",
        Act::Configure { .. } => "is configured so already",
        Act::Connect { .. } => "is connected already",
        Act::Disconnect { .. } => "is disconnected already",
    };
    let details = if details.is_empty() {
        String::new()
    } else {
        format!(": {details}")
    };
    match done {
        Done::Yes => format!("{target} {verb}{details}"),
        Done::Would => format!("{target} would be {verb}{details}"),
        Done::Already => format!("{target} {already}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rts_schemas::system::PortRef;

    fn acts() -> Vec<Act> {
        let instance = || "Filter0".to_owned();
        let end = |instance: &str, port: &str| PortRef {
            instance: instance.to_owned(),
            port: port.to_owned(),
        };
        vec![
            Act::Activate {
                instance: instance(),
            },
            Act::Deactivate {
                instance: instance(),
            },
            Act::Reset {
                instance: instance(),
            },
            Act::Configure {
                instance: instance(),
                set: None,
                values: Default::default(),
                active: None,
            },
            Act::Connect {
                source: end("Sine0", "out"),
                target: end("Filter0", "in"),
                name: None,
                properties: Default::default(),
            },
            Act::Disconnect {
                instance: "Sine0".to_owned(),
                connector: "Sine0.out-Filter0.in".to_owned(),
            },
        ]
    }

    fn target(act: &Act) -> &'static str {
        match act {
            Act::Connect { .. } | Act::Disconnect { .. } => "connector/Sine0.out-Filter0.in",
            _ => "component/Filter0",
        }
    }

    #[test]
    fn results_are_told_in_words() {
        let mut text = String::new();
        for act in acts() {
            text.push_str(&format!("cannot {}\n", attempt(&act)));
            for done in [Done::Yes, Done::Already, Done::Would] {
                let details = if matches!(act, Act::Configure { .. }) {
                    "default.gain: 1.0 -> 2.0"
                } else {
                    ""
                };
                text.push_str(&format!(
                    "  {}\n",
                    result(&act, target(&act), done, details)
                ));
            }
        }
        insta::assert_snapshot!(text);
    }

    #[test]
    fn a_state_that_needs_no_act_is_known() {
        let so = |act: usize, state| is_so(&acts()[act], state);
        assert!(so(0, "Active") && !so(0, "Inactive"));
        assert!(so(1, "Inactive") && !so(1, "Active") && !so(1, "Unknown"));
        assert!(so(2, "Inactive") && !so(2, "Error") && !so(2, "Active"));
    }
}
