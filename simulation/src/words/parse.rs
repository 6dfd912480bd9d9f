//! Reads faults.

use std::time::Duration;

use jiff::SignedDuration;

use super::error::WordError;
use super::print::MISBEHAVIOURS;
use super::token::{Token, Words, listed};
use super::{CONTROLLER, span};
use crate::faults::{Fault, Timed, When};

/// Words that a text may begin with; else it begins with a host.
pub const FIRST: [&str; 11] = [
    "agent",
    CONTROLLER,
    "node",
    "manager",
    "managers",
    "module",
    "component",
    "network",
    "disk",
    "clock",
    "usurper",
];
/// How long something lasts of which nothing is said.
const A_WHILE: Duration = Duration::from_secs(10);
/// The same of the network.
const WEATHER: Duration = Duration::from_secs(30);
/// As soon as something is done.
const FIRST_STEP: When = When::Step(1);
/// From the begin on.
const BEGIN: When = When::At(Duration::ZERO);

/// What stands behind the fault itself.
#[derive(Default)]
struct Tail {
    when: Option<When>,
    lasts: Option<Duration>,
    node: Option<String>,
}

/// Which parts a tail may have beside its time.
#[derive(Clone, Copy)]
struct Parts {
    lasts: bool,
    node: bool,
}

const TIME: Parts = Parts {
    lasts: false,
    node: false,
};
const LASTING: Parts = Parts {
    lasts: true,
    node: false,
};
const PLACED: Parts = Parts {
    lasts: false,
    node: true,
};
const BOTH: Parts = Parts {
    lasts: true,
    node: true,
};

/// Reads a fault; some are more than one ([`Fault::Cut`] in both directions). A node that is not named is empty.
pub fn parse(text: &str) -> Result<Vec<Timed>, WordError> {
    let mut words = Words::of(text)?;
    let words = &mut words;
    let Some(first) = words.next() else {
        return Err(words.wrong(None, "a fault", &[]));
    };
    let known = FIRST.iter().find(|w| !first.quoted && **w == first.word);
    match known.copied() {
        Some("agent") => agent(words),
        Some(CONTROLLER) => match words.one_of(&["crashes", "cannot"])? {
            "crashes" => crash(words, CONTROLLER.to_owned()),
            _ => cut(words, CONTROLLER.to_owned()),
        },
        Some("node") => {
            let node = words.name("the name of a node")?;
            words.one_of(&["reboots"])?;
            let tail = tail(words, LASTING)?;
            let down = tail.lasts.unwrap_or(A_WHILE);
            Ok(tail.one(FIRST_STEP, Fault::Reboot { node, down }))
        }
        Some("manager") => manager(words),
        Some("managers") => {
            words.one_of(&["on"])?;
            let node = words.name("the name of a node")?;
            for word in ["fail", "to", "start"] {
                words.one_of(&[word])?;
            }
            let tail = tail(words, LASTING)?;
            let lasts = tail.lasts.unwrap_or(A_WHILE);
            Ok(tail.one(BEGIN, Fault::ManagersFailToStart { node, lasts }))
        }
        Some("module") => {
            let type_name = words.name("the name of a type")?;
            words.one_of(&["fails"])?;
            let mut tail = tail(words, BOTH)?;
            let fault = Fault::ModuleFails {
                node: tail.node.take().unwrap_or_default(),
                type_name,
                lasts: tail.lasts,
            };
            Ok(tail.one(BEGIN, fault))
        }
        Some("component") => component(words),
        Some("network") => network(words),
        Some("disk") => disk(words),
        Some("clock") => {
            words.one_of(&["of"])?;
            let host = words.name("a node or `controller`")?;
            words.one_of(&["jumps"])?;
            let by = jump(words)?;
            let tail = tail(words, TIME)?;
            Ok(tail.one(FIRST_STEP, Fault::ClockJumps { host, by }))
        }
        Some("usurper") => {
            words.one_of(&["appears"])?;
            let tail = tail(words, TIME)?;
            Ok(tail.one(FIRST_STEP, Fault::Usurper))
        }
        _ => host(words, first),
    }
}

/// `HOST cannot reach HOST`; else the first word is wrong.
fn host(words: &mut Words<'_>, first: Token) -> Result<Vec<Timed>, WordError> {
    match words.takes("cannot") {
        true => cut(words, first.word),
        false => {
            // A usurper is no user's business.
            let said = FIRST
                .split_last()
                .map_or(FIRST.as_slice(), |(_, said)| said);
            let expected = format!("{}, or a node that `cannot reach`", said.join(", "));
            Err(words.wrong(Some(first), &expected, said))
        }
    }
}

fn cut(words: &mut Words<'_>, from: String) -> Result<Vec<Timed>, WordError> {
    words.one_of(&["reach"])?;
    let to = words.name("a node or `controller`")?;
    let tail = tail(words, LASTING)?;
    let lasts = tail.lasts;
    Ok(tail.one(FIRST_STEP, Fault::Cut { from, to, lasts }))
}

fn agent(words: &mut Words<'_>) -> Result<Vec<Timed>, WordError> {
    let node = words.name("the name of a node")?;
    if words.one_of(&["drops", "crashes"])? == "crashes" {
        return crash(words, node);
    }
    let tail = tail(words, LASTING)?;
    let ends = [(node.as_str(), CONTROLLER), (CONTROLLER, node.as_str())];
    let cuts = ends.map(|(from, to)| Timed {
        when: tail.when.unwrap_or(FIRST_STEP),
        fault: Fault::Cut {
            from: from.to_owned(),
            to: to.to_owned(),
            lasts: tail.lasts,
        },
    });
    Ok(cuts.into())
}

fn crash(words: &mut Words<'_>, host: String) -> Result<Vec<Timed>, WordError> {
    let calls = match words.takes("after") {
        false => 0,
        true => {
            let calls = number(words, "a number of calls")?;
            words.one_of(&["calls"])?;
            calls
        }
    };
    let tail = tail(words, LASTING)?;
    let down = tail.lasts;
    Ok(tail.one(FIRST_STEP, Fault::Crash { host, calls, down }))
}

fn manager(words: &mut Words<'_>) -> Result<Vec<Timed>, WordError> {
    let name = match words.takes("any") {
        true => None,
        false => Some(words.name("the name of a manager, or `any`")?),
    };
    let verb = words.one_of(&["dies", "hangs"])?;
    let mut tail = tail(words, PLACED)?;
    let node = tail.node.take().unwrap_or_default();
    let manager = name;
    let fault = match verb {
        "dies" => Fault::ManagerDies { node, manager },
        _ => Fault::ManagerHangs { node, manager },
    };
    Ok(tail.one(FIRST_STEP, fault))
}

fn component(words: &mut Words<'_>) -> Result<Vec<Timed>, WordError> {
    let instance = words.name("the name of a component")?;
    words.one_of(&["misbehaves"])?;
    let how = words.one_of(&MISBEHAVIOURS.map(|(name, _)| name))?;
    let how = MISBEHAVIOURS.iter().find(|(name, _)| *name == how);
    let tail = tail(words, LASTING)?;
    let lasts = tail.lasts;
    let fault = how.map(|(_, how)| Fault::Misbehaves {
        instance,
        how: *how,
        lasts,
    });
    Ok(fault.map_or_else(Vec::new, |fault| tail.one(BEGIN, fault)))
}

fn network(words: &mut Words<'_>) -> Result<Vec<Timed>, WordError> {
    let (mut lost, mut doubled, mut delay) = (None, None, None);
    loop {
        if lost.is_none() && words.takes("loses") {
            lost = Some(share(words)?);
        } else if doubled.is_none() && words.takes("doubles") {
            doubled = Some(share(words)?);
        } else if delay.is_none() && words.takes("delays") {
            delay = Some(time(words)?);
        } else if lost.or(doubled).is_none() && delay.is_none() {
            words.one_of(&["loses", "doubles", "delays"])?;
        } else {
            break;
        }
    }
    let tail = tail(words, LASTING)?;
    let fault = Fault::Weather {
        lost: lost.unwrap_or(0),
        doubled: doubled.unwrap_or(0),
        delay: delay.unwrap_or_default(),
        lasts: tail.lasts.unwrap_or(WEATHER),
    };
    Ok(tail.one(BEGIN, fault))
}

fn disk(words: &mut Words<'_>) -> Result<Vec<Timed>, WordError> {
    words.one_of(&["of"])?;
    let host = words.name("a node or `controller`")?;
    let delay = match words.one_of(&["fails", "is"])? {
        "fails" => None,
        _ => {
            words.one_of(&["slow"])?;
            Some(time(words)?)
        }
    };
    let tail = tail(words, LASTING)?;
    let lasts = tail.lasts.unwrap_or(A_WHILE);
    let fault = match delay {
        None => Fault::DiskFails { host, lasts },
        Some(delay) => Fault::DiskSlow { host, delay, lasts },
    };
    Ok(tail.one(BEGIN, fault))
}

impl Tail {
    /// One fault, at its time.
    fn one(self, unsaid: When, fault: Fault) -> Vec<Timed> {
        let when = self.when.unwrap_or(unsaid);
        vec![Timed { when, fault }]
    }
}

/// The rest of a text.
fn tail(words: &mut Words<'_>, parts: Parts) -> Result<Tail, WordError> {
    let mut tail = Tail::default();
    loop {
        let mut open = Vec::new();
        if tail.when.is_none() {
            open.extend(["at", "from"]);
        }
        if parts.lasts && tail.lasts.is_none() {
            open.push("for");
        }
        if parts.node && tail.node.is_none() {
            open.push("on");
        }
        let Some(token) = words.next() else {
            return Ok(tail);
        };
        let known = open.iter().find(|w| !token.quoted && **w == token.word);
        match known.copied() {
            Some("for") => tail.lasts = Some(time(words)?),
            Some("on") => tail.node = Some(words.name("the name of a node")?),
            Some(_) => tail.when = Some(when(words)?),
            None => {
                let expected = listed(&[open.as_slice(), &["the end"]].concat());
                return Err(words.wrong(Some(token), &expected, &open));
            }
        }
    }
}

fn when(words: &mut Words<'_>) -> Result<When, WordError> {
    if words.takes("step") {
        let step = number(words, "the number of a step")?;
        return Ok(When::Step(u32::try_from(step).unwrap_or(u32::MAX)));
    }
    let token = words.next();
    let time = token.as_ref().and_then(|token| span::read(&token.word));
    let expected = "step N, or a time (200ms, 2.5s, 3m, 1h)";
    time.map(When::At)
        .ok_or_else(|| words.wrong(token, expected, &["step"]))
}

fn time(words: &mut Words<'_>) -> Result<Duration, WordError> {
    read(words, "a time (200ms, 2.5s, 3m, 1h)", span::read)
}

fn jump(words: &mut Words<'_>) -> Result<SignedDuration, WordError> {
    read(words, "a time (+5s, -1h)", span::read_signed)
}

fn share(words: &mut Words<'_>) -> Result<u32, WordError> {
    read(words, "a share (0% to 100%, 2.5%)", span::read_share)
}

fn number(words: &mut Words<'_>, what: &str) -> Result<u64, WordError> {
    read(words, what, |word| word.parse().ok())
}

fn read<T>(
    words: &mut Words<'_>,
    expected: &str,
    read: impl Fn(&str) -> Option<T>,
) -> Result<T, WordError> {
    let token = words.next();
    let value = token.as_ref().and_then(|token| read(&token.word));
    value.ok_or_else(|| words.wrong(token, expected, &[]))
}
