//! Exit codes and how a refusal of the controller maps to them.

use rts_controller_api::{ClientError, Problem};

/// How the program ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// Done; no difference.
    Ok,
    /// Only: differences or problems were found; a simulation did not come to what is desired.
    Different,
    /// The command line is wrong, or names something that is not there; or the output cannot be written.
    Usage,
    /// The profile or the plan is invalid.
    Invalid,
    /// The controller or an agent cannot be reached, or failed.
    Unreachable,
    /// A part was applied; the rest waits or cannot be done.
    Partly,
    /// The deadline passed while work went on.
    Deadline,
    /// Conflict with what is there.
    Conflict,
    /// Not authorised.
    Forbidden,
    /// A safety gate refused it.
    Refused,
    /// Ctrl-C.
    Interrupted,
    /// The reader of stdout went away, as a shell shows SIGPIPE.
    BrokenPipe,
}

impl Exit {
    /// The number.
    pub fn code(self) -> u8 {
        match self {
            Exit::Ok => 0,
            Exit::Different => 1,
            Exit::Usage => 2,
            Exit::Invalid => 3,
            Exit::Unreachable => 4,
            Exit::Partly => 5,
            Exit::Deadline => 6,
            Exit::Conflict => 7,
            Exit::Forbidden => 8,
            Exit::Refused => 9,
            Exit::Interrupted => 130,
            Exit::BrokenPipe => 141,
        }
    }

    /// The one with this number; [`Exit::Unreachable`] when there is none.
    pub fn of_code(code: u8) -> Self {
        let known = [
            Exit::Usage,
            Exit::Invalid,
            Exit::Partly,
            Exit::Deadline,
            Exit::Conflict,
            Exit::Forbidden,
            Exit::Refused,
        ];
        let found = known.into_iter().find(|exit| exit.code() == code);
        found.unwrap_or(Exit::Unreachable)
    }

    /// Of a request that failed.
    pub fn of_client(error: &ClientError) -> Self {
        match error {
            ClientError::Unreachable { .. } | ClientError::Protocol { .. } => Exit::Unreachable,
            ClientError::Problem(problem) => Self::of_problem(problem),
        }
    }

    /// Of something that was done by SSH.
    pub fn of_ssh(kind: rts_ssh::Kind) -> Self {
        use rts_ssh::Kind;
        match kind {
            Kind::Unreachable => Exit::Unreachable,
            Kind::Forbidden => Exit::Forbidden,
            Kind::Partly => Exit::Partly,
            Kind::Usage => Exit::Usage,
            Kind::Conflict => Exit::Conflict,
        }
    }

    /// Of a problem document: the code says more than the status.
    pub fn of_problem(problem: &Problem) -> Self {
        let code = problem.code.as_str();
        if matches!(code, "order-cycle" | "module-not-found") || code.starts_with("invalid-") {
            return Exit::Invalid;
        }
        match code {
            "would-restart" => return Exit::Refused,
            // A name on the command line.
            "unknown-target" | "bad-fault" | "bad-limit" => return Exit::Usage,
            // It was asked to do what it can do, and did not.
            "component-failed" => return Exit::Partly,
            "deadline" => return Exit::Deadline,
            _ => {}
        }
        match problem.status {
            401 | 403 => Exit::Forbidden,
            409 | 412 => Exit::Conflict,
            422 => Exit::Invalid,
            400 | 404 | 405 => Exit::Usage,
            _ => Exit::Unreachable,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_maps_by_its_code_first_and_by_its_status_then() {
        let exit = |status, code| Exit::of_problem(&Problem::new(status, code, "t", "")).code();
        assert_eq!(exit(422, "unknown-port"), 3);
        assert_eq!(exit(400, "invalid-body"), 3);
        assert_eq!(exit(404, "module-not-found"), 3);
        assert_eq!(exit(409, "order-cycle"), 3);
        assert_eq!(exit(409, "instance-taken"), 7);
        assert_eq!(exit(409, "stale-plan"), 7);
        assert_eq!(exit(409, "would-restart"), 9);
        assert_eq!(exit(422, "unknown-target"), 2);
        assert_eq!(exit(422, "bad-fault"), 2);
        assert_eq!(exit(412, "stale"), 7);
        assert_eq!(exit(401, "unauthorised"), 8);
        assert_eq!(exit(403, "forbidden"), 8);
        assert_eq!(exit(404, "not-found"), 2);
        assert_eq!(exit(422, "component-failed"), 5);
        assert_eq!(exit(504, "deadline"), 6);
        assert_eq!(exit(500, "internal"), 4);
        assert_eq!(exit(503, "node-unknown"), 4);
    }

    #[test]
    fn silence_and_nonsense_are_unreachable() {
        let socket = std::path::PathBuf::from("/run/x.sock");
        let reason = String::new();
        let silent = ClientError::Unreachable {
            socket: socket.clone(),
            reason: reason.clone(),
        };
        let nonsense = ClientError::Protocol { socket, reason };
        assert_eq!(Exit::of_client(&silent).code(), 4);
        assert_eq!(Exit::of_client(&nonsense).code(), 4);
    }
}
