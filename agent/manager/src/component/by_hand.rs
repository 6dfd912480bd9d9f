//! What a person changed in a component: marks that whoever asked gave, kept until a plan does the same thing again.
//! What they mean is not known here.

use std::collections::BTreeMap;

use rts_manager_api::control::{ByHandInfo, Failure};

use super::{Component, State};
use crate::failure::conflict;
use crate::sync::lock;

/// Connectors of one component that may be marked as disconnected by hand.
const MAX_DISCONNECTED: usize = 1024;

impl Component {
    /// Values or the active set were set: by a person, or by a plan, which ends the mark.
    pub(super) fn configured_by(&self, mark: Option<String>) {
        lock(&self.status).by_hand.configured = mark;
    }

    /// It was deactivated by a person, unless it went to Error on the way.
    pub(super) fn deactivated_by(&self, mark: String) {
        let mut status = lock(&self.status);
        if status.state == State::Inactive {
            status.by_hand.deactivated = Some(mark);
        }
    }

    /// It was activated, well or not, by whomever.
    pub(super) fn activated(&self) {
        let mut status = lock(&self.status);
        if status.state != State::Inactive {
            status.by_hand.deactivated = None;
        }
    }

    /// A connector is about to be removed: by a person, or by a plan, which ends the mark. The caller holds `wiring`.
    pub fn disconnected_by(&self, connector: &str, mark: Option<String>) -> Result<(), Failure> {
        let marks = &mut lock(&self.status).by_hand.disconnected;
        let Some(mark) = mark else {
            marks.remove(connector);
            return Ok(());
        };
        if marks.len() >= MAX_DISCONNECTED && !marks.contains_key(connector) {
            return Err(conflict(format!(
                "{MAX_DISCONNECTED} connectors of {} were disconnected by hand already; connect one of them again first",
                self.identity.instance
            )));
        }
        marks.insert(connector.to_owned(), mark);
        Ok(())
    }

    /// A connector was made. The caller holds `wiring`.
    pub fn connected(&self, connector: &str) {
        lock(&self.status).by_hand.disconnected.remove(connector);
    }

    /// Forgets marks, where they are still these: a person may have made new ones meanwhile.
    pub fn forget_marks(&self, marks: &ByHandInfo, connectors: &BTreeMap<String, String>) {
        let _wiring = lock(&self.wiring);
        for (name, mark) in connectors {
            if let Some(connector) = self.connector(name) {
                connector.forget_mark(mark);
            }
        }
        let known = &mut lock(&self.status).by_hand;
        forget(&mut known.configured, marks.configured.as_ref());
        forget(&mut known.deactivated, marks.deactivated.as_ref());
        let disconnected = &mut known.disconnected;
        disconnected.retain(|name, mark| marks.disconnected.get(name) != Some(mark));
    }
}

fn forget(known: &mut Option<String>, mark: Option<&String>) {
    if mark.is_some() && known.as_ref() == mark {
        *known = None;
    }
}
