//! The end of a process: with it end its components and its ends of connectors, and what it started when somebody sees
//! to that.

use rts_agent::launch::Exit;

use super::state::{At, Link, Parting, Process, Run, State};
use crate::truth::{Cause, Happened};

impl State {
    /// Ends a process, and nothing that it started.
    pub fn end(&mut self, number: u64, exit: Exit, cause: Cause) {
        let Some(process) = self.living(number) else {
            return;
        };
        process.ended = Some(cause);
        process.listeners.clear();
        let components: Vec<At> = process.components.values().map(|c| c.at(number)).collect();
        // Before anything else: what has ended does nothing about the rest.
        process.run.send_replace(Run::Ended(exit));
        self.lose_peers(number);
        if let Some(process) = self.processes.get_mut(&number) {
            let gone = std::mem::take(&mut process.components);
            process.ends.clear();
            for at in &components {
                let Some(component) = gone.get(&at.instance) else {
                    continue;
                };
                if component.is_told() {
                    let subject = component.subject.clone();
                    self.news.push(Happened::Deleted(subject, Cause::Died));
                }
            }
        }
        self.settle(number);
    }

    /// What the other processes see of its end, and that its own connectors are gone.
    fn lose_peers(&mut self, number: u64) {
        let Some(process) = self.processes.get(&number) else {
            return;
        };
        let connectors = process.components.values().flat_map(|component| {
            let at = component.at(number);
            let open = |link: Link| matches!(link, Link::Open(_));
            let open = component.connectors.values().filter(move |c| open(c.link));
            open.map(move |c| (at.clone(), c.request.connector.clone()))
        });
        let connectors: Vec<_> = connectors.collect();
        let ends = process.ends.values();
        let ends = ends.filter(|end| end.source.as_ref().is_some_and(|s| s.closed.is_none()));
        let ends: Vec<_> = ends.map(|end| end.binding.connector.clone()).collect();
        for (at, connector) in connectors {
            self.close_connector(&at, &connector, Parting::Loss, Cause::Died);
        }
        for connector in ends {
            self.close_end(number, &connector, Parting::Loss, Cause::Died);
        }
    }

    /// Kills what a process started.
    pub fn kill_grandchildren(&mut self, number: u64) {
        if let Some(process) = self.processes.get_mut(&number) {
            process.grandchildren = 0;
        }
        self.settle(number);
    }

    /// Forgets a process of which nothing is left.
    fn settle(&mut self, number: u64) {
        let left = |process: &Process| process.lives() || process.grandchildren > 0;
        if self.processes.get(&number).is_none_or(left) {
            return;
        }
        if let Some(process) = self.processes.remove(&number) {
            self.news.push(Happened::ProcessEnded {
                node: self.node.clone(),
                manager: process.key,
                process: process.hello.incarnation,
                cause: process.ended.unwrap_or(Cause::Fault),
            });
        }
    }
}
