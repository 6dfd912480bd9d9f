//! How the sessions are of the nodes that this process holds awake: one that was lost is waited for, one that was given up ends
//! what waits for that node. Of no other node anything is decided.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rts_controller_api::ClientError;
use rts_controller_api::objects::Waiting;

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

static HELD: Mutex<Held> = Mutex::new(Held::new());

fn all() -> MutexGuard<'static, Held> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// True when this process holds the node awake already.
pub(super) fn holds(node: &str) -> bool {
    all().contains_key(node)
}

/// Notes how a session is.
pub(super) fn note(node: &str, standing: Standing) {
    all().insert(node.to_owned(), standing);
}

/// Those of these nodes that nothing heals between commands.
pub fn on_demand(nodes: &[String]) -> Vec<String> {
    let held = all();
    let alone = |node: &&String| {
        let standing = held.get(*node);
        standing.is_some_and(|standing| *standing != Standing::Up { resident: true })
    };
    nodes.iter().filter(alone).cloned().collect()
}

/// Why the first of these nodes is not reached of which that is so, be it reached again or given up.
pub fn away(nodes: &[String]) -> Option<LocalError> {
    away_of(&all(), nodes, true)
}

/// The node is not reached, be it reached again or given up.
pub fn is_away(node: &str) -> bool {
    let held = all();
    held.get(node)
        .is_some_and(|standing| !matches!(standing, Standing::Up { .. }))
}

/// The same as [`away`] of those that nobody tries to reach any more.
pub fn given_up(nodes: &[String]) -> Option<LocalError> {
    away_of(&all(), nodes, false)
}

/// Those of the nodes that something required waits for.
pub fn needed(nodes: &[String], waiting: &[Waiting]) -> Vec<String> {
    let required = |node: &&String| waiting.iter().any(|w| w.required && concerns(node, w));
    nodes.iter().filter(required).cloned().collect()
}

/// What a refusal comes from that names a node which is not reached.
pub fn cause(refusal: &ClientError) -> Option<LocalError> {
    away(&blamed(refusal)?)
}

/// The node that is the cause of a refusal, if it may be another one in a moment.
fn blamed(refusal: &ClientError) -> Option<[String; 1]> {
    match refusal {
        ClientError::Problem(problem) if problem.retryable => {
            Some([problem.node.as_deref()?.to_owned()])
        }
        _ => None,
    }
}

fn away_of(held: &Held, nodes: &[String], lost: bool) -> Option<LocalError> {
    let standings = nodes.iter().filter_map(|node| held.get_key_value(node));
    let mut errors = standings.filter_map(|(node, standing)| error(node, standing, lost));
    errors.next()
}

/// The error of a node that is not reached; of one that is being reached again only if `lost`.
fn error(node: &str, standing: &Standing, lost: bool) -> Option<LocalError> {
    let resume =
        "what was done stays done: run the same again once the node can be reached, and it goes on";
    match standing {
        Standing::Lost { reason, log } if lost => Some(LocalError::Relay {
            node: node.to_owned(),
            reason: format!("its session was lost and not made again in time: {reason}"),
            help: Some(resume.to_owned()),
            exit: Exit::Unreachable,
            log: log.clone(),
        }),
        Standing::GivenUp {
            reason,
            help,
            exit,
            log,
        } => Some(LocalError::Relay {
            node: node.to_owned(),
            reason: format!("its session was lost and cannot be made again: {reason}"),
            help: Some(match help {
                Some(help) => format!("{help}; {resume}"),
                None => resume.to_owned(),
            }),
            exit: *exit,
            log: log.clone(),
        }),
        _ => None,
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
            Err(e)
                if blamed(&e).is_some_and(|node| patience.with(&node))
                    && Instant::now() < deadline =>
            {
                tokio::time::sleep(PAUSE).await;
            }
            answer => return answer,
        }
    }
}

/// The error of a request that failed because of a node that is not reached, or what `otherwise` makes of it.
pub fn because<E: Into<CliError>>(
    otherwise: impl FnOnce(ClientError) -> E,
) -> impl FnOnce(ClientError) -> CliError {
    |refusal| match cause(&refusal) {
        Some(away) => away.into(),
        None => otherwise(refusal).into(),
    }
}

/// Puts off a verdict over what may only wait for a session.
#[derive(Debug, Default)]
pub struct Patience {
    since: Option<Instant>,
}

impl Patience {
    /// True while what does not go on of something that lies on these nodes may only wait for a session.
    pub fn allows(&mut self, nodes: &[String], waiting: &[Waiting]) -> bool {
        let wrong = |node: &str| waiting.iter().any(|waiting| concerns(node, waiting));
        self.judge(&all(), nodes, wrong, Instant::now())
    }

    /// The same, when something is wrong with each of the nodes.
    pub fn with(&mut self, nodes: &[String]) -> bool {
        self.judge(&all(), nodes, |_| true, Instant::now())
    }

    fn judge(
        &mut self,
        held: &Held,
        nodes: &[String],
        wrong: impl Fn(&str) -> bool,
        now: Instant,
    ) -> bool {
        let own = nodes.iter().filter_map(|node| held.get_key_value(node));
        let (mut lost, mut concerned) = (false, false);
        for (node, standing) in own {
            match standing {
                Standing::Lost { .. } => lost = true,
                Standing::Up { .. } => concerned |= wrong(node),
                Standing::GivenUp { .. } => {}
            }
        }
        if lost || !concerned {
            self.since = None;
            return lost;
        }
        now.duration_since(*self.since.get_or_insert(now)) < SETTLE
    }
}

/// Something waits for this node.
fn concerns(node: &str, waiting: &Waiting) -> bool {
    waiting.target.strip_prefix("node/") == Some(node)
        || waiting.reason.contains(&format!("node {node} is unknown"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(standing: Standing) -> Held {
        Held::from([("arm".to_owned(), standing)])
    }

    fn lost() -> Standing {
        Standing::Lost {
            reason: "cut".to_owned(),
            log: PathBuf::new(),
        }
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
        let lost = held(lost());
        let arm = ["arm".to_owned()];
        let mut patience = Patience::default();
        let now = Instant::now();
        let none = patience.judge(&Held::new(), &arm, |_| true, now);
        assert!(!none, "no node by SSH");
        let other = patience.judge(&up, &arm, |_| false, now);
        assert!(!other, "something else is wrong");
        assert!(patience.judge(&up, &arm, |_| true, now));
        assert!(patience.judge(&lost, &arm, |_| true, now + 10 * SETTLE));
        let anew = patience.judge(&up, &arm, |_| true, now + 11 * SETTLE);
        assert!(anew, "counted anew");
        assert!(!patience.judge(&up, &arm, |_| true, now + 12 * SETTLE));
    }

    #[test]
    fn a_node_of_others_decides_nothing() {
        let (mine, now) = (["local".to_owned(), "leg".to_owned()], Instant::now());
        let mut held = held(lost());
        let mut patience = Patience::default();
        assert!(!patience.judge(&held, &mine, |_| true, now));
        assert!(away_of(&held, &mine, true).is_none());
        assert!(away_of(&held, &["arm".to_owned()], true).is_some());
        assert!(away_of(&held, &["arm".to_owned()], false).is_none());
        held.insert("leg".to_owned(), lost());
        assert!(patience.judge(&held, &mine, |_| true, now));
        let leg = away_of(&held, &mine, true).unwrap().to_string();
        assert!(leg.starts_with("node leg is not reached"), "{leg}");
    }

    #[test]
    fn what_waits_for_a_node_is_told_by_its_target_or_reason() {
        let arm = |target, reason| concerns("arm", &waiting(target, reason));
        assert!(arm("node/arm", "its agent was lost"));
        assert!(arm("component/A", "node arm is unknown: x"));
        assert!(!arm("node/armada", "x"));
        assert!(!arm("component/A", "its module failed"));
    }

    #[tokio::test(start_paused = true)]
    async fn a_refusal_is_asked_again_only_while_the_node_that_it_names_may_come_back() {
        let refusal = |node: &str| {
            let problem = rts_controller_api::Problem::unavailable("node-not-ready", "x");
            ClientError::from(problem.of_node(node))
        };
        // What this process holds is of this test alone.
        note("comes-back", lost());
        let mut asked = 0;
        let answer = despite_loss(Instant::now() + SETTLE, async || {
            asked += 1;
            match asked {
                1 => Err(refusal("comes-back")),
                2 => {
                    note("comes-back", Standing::Up { resident: false });
                    Err(refusal("comes-back"))
                }
                _ => Ok(asked),
            }
        });
        assert_eq!(answer.await.unwrap(), 3);
        note("lost-for-good", lost());
        let other = despite_loss(Instant::now() + SETTLE, async || {
            Err::<(), _>(refusal("of-others"))
        });
        assert!(cause(&other.await.unwrap_err()).is_none());
        let late = despite_loss(Instant::now(), async || {
            Err::<(), _>(refusal("lost-for-good"))
        });
        let told = because(|_| CliError::usage("another error"))(late.await.unwrap_err());
        assert_eq!(told.exit(), Exit::Unreachable);
        assert!(told.line().contains("not made again in time: cut"));
    }

    #[test]
    fn only_what_is_required_needs_a_node() {
        let (arm, leg) = ("arm".to_owned(), "leg".to_owned());
        let optional = Waiting {
            required: false,
            ..waiting("component/B", "node leg is unknown: x")
        };
        let waiting = [waiting("component/A", "node arm is unknown: x"), optional];
        assert_eq!(needed(&[arm.clone(), leg], &waiting), [arm]);
    }

    #[test]
    fn an_end_says_that_it_can_be_resumed() {
        let given_up = held(Standing::GivenUp {
            reason: "robot let nobody in".to_owned(),
            help: Some("let a key in".to_owned()),
            exit: Exit::Forbidden,
            log: PathBuf::new(),
        });
        let error = away_of(&given_up, &["arm".to_owned()], false).unwrap();
        assert_eq!(error.exit(), Exit::Forbidden);
        insta::assert_snapshot!(format!("{error}\nhelp: {}", error.help().unwrap()), @r"
        node arm is not reached: its session was lost and cannot be made again: robot let nobody in
        help: let a key in; what was done stays done: run the same again once the node can be reached, and it goes on
        ");
    }
}
