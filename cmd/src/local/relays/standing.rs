//! How the sessions are of the nodes that this process holds awake: one that was lost is waited for, one that was given up ends
//! what waits.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use rts_controller_api::ClientError;
use rts_controller_api::objects::Waiting;
use tokio::sync::watch;

use crate::error::CliError;
use crate::exit::Exit;
use crate::local::LocalError;

/// How long something may be wrong with a node whose session looks well: a connection that carries nothing any more is noticed
/// within 8 s.
const SETTLE: Duration = Duration::from_secs(12);
/// Time between two tries.
const PAUSE: Duration = Duration::from_millis(200);

/// The session of one node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Standing {
    /// It is there.
    Up {
        /// An agent lives there on its own.
        resident: bool,
    },
    /// It was lost, and is being made anew.
    Lost {
        /// Why.
        reason: String,
        /// The relay's log.
        log: PathBuf,
    },
    /// Nobody tries any more.
    GivenUp {
        /// Why.
        reason: String,
        /// How to mend it.
        help: Option<String>,
        /// The exit code of a command that needs the node.
        exit: Exit,
        /// The relay's log.
        log: PathBuf,
    },
}

/// Nodes by name.
type Held = BTreeMap<String, Standing>;

static HELD: LazyLock<watch::Sender<Held>> = LazyLock::new(watch::Sender::default);

/// True when this process holds the node awake already.
pub(super) fn holds(node: &str) -> bool {
    HELD.borrow().contains_key(node)
}

/// Notes how a session is.
pub(super) fn note(node: &str, standing: Standing) {
    HELD.send_modify(|held| drop(held.insert(node.to_owned(), standing)));
}

/// Nodes of this process that nothing heals between commands.
pub fn on_demand() -> Vec<String> {
    let held = HELD.borrow();
    let alone = held
        .iter()
        .filter(|(_, standing)| **standing != Standing::Up { resident: true });
    alone.map(|(node, _)| node.clone()).collect()
}

/// Why a node is not reached, when it is being reached again.
pub fn lost() -> Option<LocalError> {
    lost_of(&HELD.borrow())
}

fn lost_of(held: &Held) -> Option<LocalError> {
    held.iter().find_map(|(node, standing)| match standing {
        Standing::Lost { reason, log } => Some(LocalError::Relay {
            node: node.clone(),
            reason: format!("its session was lost and not made again in time: {reason}"),
            help: Some(resume()),
            exit: Exit::Unreachable,
            log: log.clone(),
        }),
        _ => None,
    })
}

fn given_up_of(held: &Held) -> Option<LocalError> {
    held.iter().find_map(|(node, standing)| match standing {
        Standing::GivenUp {
            reason,
            help,
            exit,
            log,
        } => Some(LocalError::Relay {
            node: node.clone(),
            reason: format!("its session was lost and cannot be made again: {reason}"),
            help: Some(match help {
                Some(help) => format!("{help}; {}", resume()),
                None => resume(),
            }),
            exit: *exit,
            log: log.clone(),
        }),
        _ => None,
    })
}

fn resume() -> String {
    "what was done stays done: run the same again once the node can be reached, and it goes on"
        .to_owned()
}

/// Waits for something that needs the sessions; ends with an error as soon as one of them is given up.
pub async fn while_reached<T>(
    work: impl Future<Output = Result<T, CliError>>,
) -> Result<T, CliError> {
    let mut held = HELD.subscribe();
    let given_up = async {
        loop {
            let error = given_up_of(&held.borrow_and_update());
            if let Some(error) = error {
                return error;
            }
            if held.changed().await.is_err() {
                std::future::pending::<()>().await;
            }
        }
    };
    tokio::select! {
        biased;
        done = work => done,
        error = given_up => Err(error.into()),
    }
}

/// Asks again for as long as the answer is that a node is not ready and its session is being made anew.
pub async fn despite_loss<T>(
    deadline: Instant,
    mut ask: impl AsyncFnMut() -> Result<T, ClientError>,
) -> Result<T, ClientError> {
    let mut patience = Patience::default();
    loop {
        match ask().await {
            Err(ClientError::Problem(problem))
                if problem.retryable
                    && problem.code == "node-not-ready"
                    && Instant::now() < deadline
                    && patience.with(true) =>
            {
                tokio::time::sleep(PAUSE).await;
            }
            answer => return answer,
        }
    }
}

/// Puts off a verdict over what may only wait for a session.
#[derive(Debug, Default)]
pub struct Patience {
    since: Option<Instant>,
}

impl Patience {
    /// True while what does not go on may only wait for a session.
    pub fn allows(&mut self, waiting: &[Waiting]) -> bool {
        let concerns = waiting.iter().any(|w| concerns(&HELD.borrow(), w));
        self.with(concerns)
    }

    /// The same, when it is known whether something is wrong with a node.
    pub fn with(&mut self, wrong: bool) -> bool {
        self.judge(&HELD.borrow(), wrong, Instant::now())
    }

    fn judge(&mut self, held: &Held, wrong: bool, now: Instant) -> bool {
        let lost = held.values().any(|s| matches!(s, Standing::Lost { .. }));
        if lost || !wrong || held.is_empty() {
            self.since = None;
            return lost;
        }
        now.duration_since(*self.since.get_or_insert(now)) < SETTLE
    }
}

/// Something waits for a node that is held awake.
fn concerns(held: &Held, waiting: &Waiting) -> bool {
    held.keys().any(|node| {
        waiting.target.strip_prefix("node/") == Some(node)
            || waiting.reason.contains(&format!("node {node} is unknown"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(standing: Standing) -> Held {
        Held::from([("arm".to_owned(), standing)])
    }

    fn waiting(target: &str, reason: &str) -> Waiting {
        Waiting {
            target: target.to_owned(),
            reason: reason.to_owned(),
            required: true,
            transient: false,
            tries: 0,
            next_try: None,
        }
    }

    #[test]
    fn a_lost_session_is_waited_for_and_one_that_looks_well_for_a_while() {
        let up = held(Standing::Up { resident: false });
        let lost = held(Standing::Lost {
            reason: "cut".to_owned(),
            log: PathBuf::new(),
        });
        let mut patience = Patience::default();
        let now = Instant::now();
        assert!(!patience.judge(&Held::new(), true, now), "no node by SSH");
        assert!(!patience.judge(&up, false, now), "something else is wrong");
        assert!(patience.judge(&up, true, now));
        assert!(patience.judge(&lost, true, now + 10 * SETTLE));
        assert!(patience.judge(&up, true, now + 11 * SETTLE), "counted anew");
        assert!(!patience.judge(&up, true, now + 12 * SETTLE));
    }

    #[test]
    fn what_waits_for_a_node_is_told_by_its_target_or_reason() {
        let up = held(Standing::Up { resident: false });
        assert!(concerns(&up, &waiting("node/arm", "its agent was lost")));
        assert!(concerns(
            &up,
            &waiting("component/A", "node arm is unknown: x")
        ));
        assert!(!concerns(&up, &waiting("node/armada", "x")));
        assert!(!concerns(&up, &waiting("component/A", "its module failed")));
    }

    #[test]
    fn an_end_says_that_it_can_be_resumed() {
        let given_up = held(Standing::GivenUp {
            reason: "robot let nobody in".to_owned(),
            help: Some("let a key in".to_owned()),
            exit: Exit::Forbidden,
            log: PathBuf::new(),
        });
        let error = given_up_of(&given_up).unwrap();
        assert_eq!(error.exit(), Exit::Forbidden);
        insta::assert_snapshot!(format!("{error}\nhelp: {}", error.help().unwrap()), @r"
        node arm is not reached: its session was lost and cannot be made again: robot let nobody in
        help: let a key in; what was done stays done: run the same again once the node can be reached, and it goes on
        ");
        assert!(lost_of(&given_up).is_none());
    }
}
