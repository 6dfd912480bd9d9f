//! Names that faults may speak of: those of the cluster. Where a node was left out, the right one is found.

use std::collections::{BTreeMap, BTreeSet};

use super::CONTROLLER;
use super::error::{WordError, nearest};
use super::token::Words;
use crate::faults::{Fault, Timed};

/// Names listed in an error.
const LISTED: usize = 20;

/// What is there.
#[derive(Debug, Clone, Default)]
pub struct Names {
    /// Nodes.
    pub nodes: BTreeSet<String>,
    /// Manager (`hello.main`) → its nodes.
    pub managers: BTreeMap<String, BTreeSet<String>>,
    /// Instances.
    pub instances: BTreeSet<String>,
    /// Type → nodes that need it.
    pub types: BTreeMap<String, BTreeSet<String>>,
}

/// Checks the names in what was read from `text`, and fills in nodes that were left out.
pub fn settle(text: &str, faults: Vec<Timed>, names: &Names) -> Result<Vec<Timed>, WordError> {
    let mut settled = Vec::new();
    for Timed { when, fault } in faults {
        let faults = one(text, fault, names)?.into_iter();
        settled.extend(faults.map(|fault| Timed { when, fault }));
    }
    Ok(settled)
}

fn one(text: &str, fault: Fault, names: &Names) -> Result<Vec<Fault>, WordError> {
    let check = |what, name: &str, known: &BTreeSet<String>| known_or(text, what, name, known);
    let host = |name: &str| match name {
        CONTROLLER => Ok(()),
        name => check(
            "`controller`, or a node of this cluster",
            name,
            &names.nodes,
        ),
    };
    let node = |name: &str| check("a node of this cluster", name, &names.nodes);
    match &fault {
        Fault::Cut { from, to, .. } => {
            host(from)?;
            host(to)?;
        }
        Fault::Crash { host: name, .. }
        | Fault::DiskFails { host: name, .. }
        | Fault::DiskSlow { host: name, .. }
        | Fault::ClockJumps { host: name, .. } => host(name)?,
        Fault::Reboot { node: name, .. } | Fault::ManagersFailToStart { node: name, .. } => {
            node(name)?;
        }
        Fault::Misbehaves { instance, .. } => {
            check("a component of this cluster", instance, &names.instances)?;
        }
        Fault::Weather { .. } | Fault::Usurper => {}
        Fault::ManagerDies {
            node: on, manager, ..
        }
        | Fault::ManagerHangs { node: on, manager } => {
            let nodes = match manager {
                Some(name) => placed(text, "a manager of this cluster", name, &names.managers)?,
                None => names.nodes.clone(),
            };
            let on = places(text, on, &nodes, manager.is_none())?;
            return Ok(on.into_iter().map(|node| moved(&fault, node)).collect());
        }
        Fault::ModuleFails {
            node: on,
            type_name,
            ..
        } => {
            let nodes = placed(text, "a type of this cluster", type_name, &names.types)?;
            let on = places(text, on, &nodes, false)?;
            return Ok(on.into_iter().map(|node| moved(&fault, node)).collect());
        }
    }
    Ok(vec![fault])
}

/// Where something of several nodes is meant: there, or wherever it is.
fn places(
    text: &str,
    on: &str,
    nodes: &BTreeSet<String>,
    one: bool,
) -> Result<Vec<String>, WordError> {
    match on {
        "" if one && nodes.len() > 1 => Err(WordError {
            text: text.to_owned(),
            at: text.chars().count(),
            word: None,
            expected: format!("on NODE ({})", list(nodes)),
            nearest: None,
        }),
        "" => Ok(nodes.iter().cloned().collect()),
        node => {
            known_or(text, "a node where it is", node, nodes)?;
            Ok(vec![node.to_owned()])
        }
    }
}

/// The same fault on this node.
fn moved(fault: &Fault, to: String) -> Fault {
    let mut fault = fault.clone();
    if let Fault::ManagerDies { node, .. }
    | Fault::ManagerHangs { node, .. }
    | Fault::ModuleFails { node, .. } = &mut fault
    {
        *node = to;
    }
    fault
}

fn placed(
    text: &str,
    what: &str,
    name: &str,
    known: &BTreeMap<String, BTreeSet<String>>,
) -> Result<BTreeSet<String>, WordError> {
    match known.get(name) {
        Some(nodes) => Ok(nodes.clone()),
        None => {
            let names = known.keys().cloned().collect();
            known_or(text, what, name, &names)?;
            Ok(BTreeSet::new())
        }
    }
}

fn known_or(text: &str, what: &str, name: &str, known: &BTreeSet<String>) -> Result<(), WordError> {
    if known.contains(name) {
        return Ok(());
    }
    Err(WordError {
        text: text.to_owned(),
        at: place(text, name),
        word: Some(name.to_owned()),
        expected: format!("{what} ({})", list(known)),
        nearest: nearest(name, known.iter().map(String::as_str)),
    })
}

fn list(names: &BTreeSet<String>) -> String {
    let shown: Vec<&str> = names.iter().take(LISTED).map(String::as_str).collect();
    match names.len() {
        0 => "there is none".to_owned(),
        n if n > LISTED => format!("{} and {} more", shown.join(", "), n - LISTED),
        _ => shown.join(", "),
    }
}

/// Characters before a word of a text.
fn place(text: &str, name: &str) -> usize {
    let Ok(mut words) = Words::of(text) else {
        return 0;
    };
    // The first word is never a name but of a host; what begins like one is found there, too.
    std::iter::from_fn(|| words.next())
        .find(|token| token.word == name)
        .map_or(0, |token| token.at)
}
