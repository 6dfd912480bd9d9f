//! How to mend an error.

use rts_controller_api::ClientError;

use super::CliError;

const VERSIONS: &str = "rtsctl and the controller are probably of different versions: compare `rtsctl version`, then run \
                        `rtsctl down` and `rtsctl up` with the newer one";

/// Codes of problems that a node's agent is the cause of.
const AGENT: [&str; 2] = ["agent-unreachable", "node-not-ready"];

const PLAN_AGAIN: &str = "plan again with `rtsctl plan`, read what is different, and apply that";

const LET_RESTART: &str = "leave out --no-restart to let it restart";

/// What becomes of what does not run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Rest {
    /// The controller goes on trying.
    Tried,
    /// Nothing of it is tried again: its failure policy holds it.
    Held,
    /// These components are in Error, and nothing resets them (`rtsctl.resetOnError` is off).
    InError(Vec<String>),
    /// A person made it so by hand, and it is left so; what ends that (`rtsctl activate Filter0`), as far as is known.
    ByHand(Vec<String>),
}

impl CliError {
    /// How to mend it.
    pub fn help(&self) -> Option<String> {
        if let Some(problem) = self.problem().filter(|problem| problem.retryable) {
            let agent = AGENT.contains(&problem.code.as_str());
            let look = if agent {
                " (see `rtsctl get nodes`)"
            } else {
                ""
            };
            return Some(format!("try again later{look}"));
        }
        match self.problem().map(|problem| problem.code.as_str()) {
            Some("stale-plan") => return Some(PLAN_AGAIN.to_owned()),
            Some("would-restart") => return Some(LET_RESTART.to_owned()),
            _ => {}
        }
        match self {
            CliError::Usage { help, .. }
            | CliError::Port { help, .. }
            | CliError::SavedPlan { help, .. } => help.clone(),
            CliError::Stale { .. } => Some(PLAN_AGAIN.to_owned()),
            CliError::NoController { .. } => Some("start one with `rtsctl up`".to_owned()),
            CliError::Local(e) => e.help(),
            CliError::Ssh(e) => e.help(),
            CliError::Bootstrap(e) => e.help(),
            CliError::Request { source, .. } => match source.as_ref() {
                ClientError::Unreachable { .. } => {
                    Some("is it running? see its log, or run `rtsctl up`".to_owned())
                }
                ClientError::Protocol { .. } => Some(VERSIONS.to_owned()),
                ClientError::Problem(_) => None,
            },
            CliError::Object { .. } => Some(VERSIONS.to_owned()),
            CliError::Partly {
                system,
                target,
                rest,
                ..
            } => Some(partly(system, target.as_deref(), rest)),
            CliError::WouldRestart { .. } => Some(LET_RESTART.to_owned()),
            CliError::Deadline { .. } => {
                Some("the controller goes on: see `rtsctl get systems`".to_owned())
            }
            _ => None,
        }
    }

    /// How to mend it where these nodes are reached by SSH: nobody goes on there between commands. None when that changes nothing.
    pub fn help_on_demand(&self, nodes: &[String]) -> Option<String> {
        let (again, see) = match self {
            CliError::Partly {
                system,
                target,
                rest: Rest::Tried,
                ..
            } => {
                let see = target.clone();
                (
                    "apply again",
                    see.unwrap_or_else(|| format!("system/{system}")),
                )
            }
            CliError::Deadline { system, goal, .. } => {
                let again = match *goal {
                    "gone" => "run the same again",
                    _ => "apply again",
                };
                (again, format!("system/{system}"))
            }
            _ => return None,
        };
        let (them, is) = match nodes {
            [] => return None,
            [node] => (format!("node {node}"), "is"),
            nodes => (format!("nodes {}", nodes.join(", ")), "are"),
        };
        Some(format!(
            "{them} {is} reached by SSH: the controller goes on there only while a command needs it and as long as the session is \
             kept after that, then nothing is tried until the next command. Mend the cause and {again}; see `rtsctl describe {see}`"
        ))
    }

    /// It may be for the lack of an agent.
    pub fn needs_an_agent(&self) -> bool {
        let agent = |code: &str| AGENT.contains(&code);
        self.problem().is_some_and(|problem| agent(&problem.code))
            || matches!(self, CliError::Partly { .. } | CliError::Deadline { .. })
    }
}

fn partly(system: &str, target: Option<&str>, rest: &Rest) -> String {
    let object = target.map_or_else(|| format!("system/{system}"), str::to_owned);
    let see = format!("see `rtsctl describe {object}`");
    match rest {
        Rest::Tried => format!("the controller goes on trying: {see}"),
        Rest::Held => {
            let again = format!("run `rtsctl teardown {system}` and apply again");
            format!("it is not started again by itself: apply a change of it, or {again}; {see}")
        }
        Rest::InError(instances) => {
            let reset = instances.join(" ");
            format!(
                "nothing is tried any more while it is in Error (rtsctl.resetOnError is off): run `rtsctl reset {reset}`; {see}"
            )
        }
        Rest::ByHand(ends) if ends.is_empty() => {
            format!("it was changed by hand and is left so (rtsctl.drift): {see}")
        }
        Rest::ByHand(ends) => {
            let ends: Vec<String> = ends.iter().map(|verb| format!("`{verb}`")).collect();
            let ends = ends.join(" and ");
            format!("it was changed by hand and is left so (rtsctl.drift) until {ends}; {see}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rts_controller_api::Problem;

    #[test]
    fn what_an_agent_is_the_cause_of_is_told_apart() {
        let error = |code| CliError::request("x")(Problem::unavailable(code, "y").into());
        assert!(error("agent-unreachable").needs_an_agent());
        assert_eq!(
            error("node-not-ready").help().unwrap(),
            "try again later (see `rtsctl get nodes`)"
        );
        assert!(!error("store-failed").needs_an_agent());
        assert_eq!(error("store-failed").help().unwrap(), "try again later");
    }

    #[test]
    fn nobody_is_said_to_go_on_where_a_session_ends() {
        let deadline = CliError::Deadline {
            system: "hello".to_owned(),
            goal: "converged",
            seconds: 60.0,
            nodes: Box::default(),
        };
        assert_eq!(deadline.help_on_demand(&[]), None);
        insta::assert_snapshot!(deadline.help_on_demand(&["arm".to_owned()]).unwrap(), @"node arm is reached by SSH: the controller goes on there only while a command needs it and as long as the session is kept after that, then nothing is tried until the next command. Mend the cause and apply again; see `rtsctl describe system/hello`");
        let partly = |rest| CliError::Partly {
            system: "hello".to_owned(),
            summary: String::new(),
            target: Some("component/A".to_owned()),
            rest,
            nodes: Box::default(),
        };
        let tried = partly(Rest::Tried).help_on_demand(&["arm".to_owned(), "leg".to_owned()]);
        assert!(tried.unwrap().contains("nodes arm, leg are reached by SSH"));
        assert_eq!(partly(Rest::Held).help_on_demand(&["arm".to_owned()]), None);
    }
}
