//! Processes that do not answer, and for how long: on a busy machine one misses a question and answers the next.

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::observed::{ManagerObserved, NodeObserved, Observed};
use tokio::time::Instant;

use crate::fault::PATIENCE;

/// Incarnation → since when a process of a system has not answered, and the name by which people know it.
#[derive(Debug, Default)]
pub struct Silence(BTreeMap<String, (Instant, String)>);

impl Silence {
    /// Takes in what was seen.
    pub fn seen(&mut self, observed: &Observed) {
        let before = std::mem::take(&mut self.0);
        let now = silent(observed).map(|manager| {
            let incarnation = manager.incarnation.clone();
            let told = before.get(&incarnation).cloned();
            let new = || (Instant::now(), manager.key.display_name());
            (incarnation, told.unwrap_or_else(new))
        });
        self.0 = now.collect();
    }

    /// Names of processes that may answer again soon. Processes on several nodes may have one name: then none of them has
    /// been silent for long.
    pub fn of_a_moment(&self) -> BTreeSet<&str> {
        let (short, long): (Vec<_>, Vec<_>) = self
            .0
            .values()
            .partition(|(since, _)| since.elapsed() < PATIENCE);
        let long: BTreeSet<&str> = long.iter().map(|(_, name)| name.as_str()).collect();
        let short = short.iter().map(|(_, name)| name.as_str());
        short.filter(|name| !long.contains(name)).collect()
    }
}

fn silent(observed: &Observed) -> impl Iterator<Item = &ManagerObserved> {
    let managers = observed.nodes.values().flat_map(|node| match node {
        NodeObserved::Known(inventory) => inventory.managers.as_slice(),
        NodeObserved::Unknown { .. } => &[],
    });
    managers.filter(|manager| !manager.responsive && manager.key.system.is_some())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rts_plan::observed::Inventory;
    use serde_json::json;

    use super::*;

    /// What is seen of processes by incarnation, and whether each answers.
    fn observed(managers: &[(&str, bool)]) -> Observed {
        let managers = managers.iter().map(|(incarnation, responsive)| {
            json!({
                "key": {"system": {"name": "hello", "uid": "u"}, "name": "main"},
                "incarnation": incarnation, "pid": 1, "started": "", "responsive": responsive, "modules": [], "components": [],
            })
        });
        let managers = managers
            .map(|m| serde_json::from_value(m).unwrap())
            .collect();
        let inventory = Inventory {
            managers,
            ..Inventory::default()
        };
        let node = NodeObserved::Known(Arc::new(inventory));
        Observed {
            nodes: BTreeMap::from([("local".to_owned(), node)]),
        }
    }

    #[tokio::test(start_paused = true)]
    async fn it_is_of_a_moment_until_it_has_lasted() {
        let mut silence = Silence::default();
        silence.seen(&observed(&[("a", true)]));
        assert_eq!(silence.of_a_moment(), BTreeSet::new());
        silence.seen(&observed(&[("a", false)]));
        tokio::time::advance(PATIENCE / 2).await;
        silence.seen(&observed(&[("a", false), ("b", false)]));
        assert_eq!(silence.of_a_moment(), BTreeSet::from(["hello.main"]));
        tokio::time::advance(PATIENCE / 2).await;
        silence.seen(&observed(&[("a", false), ("b", false)]));
        assert_eq!(
            silence.of_a_moment(),
            BTreeSet::new(),
            "one of two has lasted"
        );
        silence.seen(&observed(&[("a", true), ("b", false)]));
        assert_eq!(silence.of_a_moment(), BTreeSet::from(["hello.main"]));
        silence.seen(&observed(&[("a", false)]));
        assert_eq!(
            silence.of_a_moment(),
            BTreeSet::from(["hello.main"]),
            "it has answered in between"
        );
    }
}
