//! Counters, which rise while time passes. What comes from another machine is not counted where it arrives.

use std::collections::BTreeMap;

use tokio::time::Instant;

use super::state::{Component, EXECUTE, LifeCycle, Link, Process, State};

impl State {
    /// Brings counters up to now.
    pub fn count(&mut self) {
        let now = Instant::now();
        let seconds = (now - self.counted).as_secs_f64();
        if seconds == 0.0 {
            return;
        }
        self.counted = now;
        let mut sent: BTreeMap<u64, f64> = BTreeMap::new();
        let running = |p: &&mut Process| p.runs();
        for process in self.processes.values_mut().filter(running) {
            for component in process.components.values_mut() {
                if !component.executes() {
                    continue;
                }
                let ticks = seconds * component.rate;
                component.executions += ticks;
                for connector in component.connectors.values_mut() {
                    if matches!(connector.link, Link::Open(_)) {
                        connector.sent += ticks;
                        sent.insert(connector.number, ticks);
                    }
                }
            }
        }
        for process in self.processes.values_mut().filter(running) {
            let components = &process.components;
            let reads = |instance: &str| components.get(instance).is_some_and(Component::executes);
            for end in process.ends.values_mut() {
                let reads = reads(&end.binding.instance);
                if let (true, Some(source)) = (reads, &mut end.source)
                    && source.closed.is_none()
                {
                    source.received += sent.get(&source.number).copied().unwrap_or(0.0);
                }
            }
        }
    }
}

impl Component {
    fn executes(&self) -> bool {
        self.state == LifeCycle::Active && self.busy.is_none_or(|(call, _)| call != EXECUTE)
    }
}
