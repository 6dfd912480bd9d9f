//! What managers say of themselves, asked over their own sockets: nothing in between can cover anything up.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use rts_manager_api::client::Client;
use rts_manager_api::control::{ComponentInfo, Hello, RequestBody, ResponseBody};
use rts_manager_api::files::CONTROL_SOCKET;

use crate::Stack;

const LIMIT: Duration = Duration::from_secs(5);

/// One component as its manager shows it.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Of its manager.
    pub pid: u32,
    /// Everything else.
    pub info: ComponentInfo,
}

/// All components of a stack at one moment, by instance name.
#[derive(Debug, Clone)]
pub struct Witness(BTreeMap<String, Seen>);

impl Stack {
    /// Control sockets of all managers.
    pub(crate) fn sockets(&self) -> Vec<PathBuf> {
        let folders = |path: PathBuf| {
            let entries = std::fs::read_dir(path).into_iter().flatten();
            entries.filter_map(|e| Some(e.ok()?.path()))
        };
        folders(self.home().join("run"))
            .flat_map(folders)
            .map(|folder| folder.join(CONTROL_SOCKET))
            .filter(|socket| socket.exists())
            .collect()
    }

    /// Asks every manager that answers.
    pub fn managers(&self) -> Vec<(Hello, Vec<ComponentInfo>)> {
        let ask = |socket: PathBuf| {
            let mut client = Client::connect(&socket, LIMIT).ok()?;
            let answer = client.call(RequestBody::Inventory, LIMIT).ok()?;
            let ResponseBody::Inventory(inventory) = answer else {
                return None;
            };
            Some((client.hello().clone(), inventory.components))
        };
        self.sockets().into_iter().filter_map(ask).collect()
    }

    /// All components now.
    ///
    /// # Panics
    /// When two live components have one name.
    #[track_caller]
    pub fn witness(&self) -> Witness {
        let mut all = BTreeMap::new();
        for (hello, components) in self.managers() {
            for info in components {
                let name = info.instance.clone();
                let seen = Seen {
                    pid: hello.pid,
                    info,
                };
                if let Some(twin) = all.insert(name.clone(), seen) {
                    panic!("there are two of {name}; one in pid {}", twin.pid);
                }
            }
        }
        Witness(all)
    }
}

impl Stack {
    /// Asks until `done` is content with what there is, at most 20 s.
    #[track_caller]
    pub fn until_seen(&self, what: &str, done: impl Fn(&Witness) -> bool) -> Witness {
        let deadline = Instant::now() + Duration::from_secs(20);
        loop {
            let now = self.witness();
            if done(&now) {
                return now;
            }
            assert!(
                Instant::now() < deadline,
                "after 20 s still not: {what}; there is {now:#?}"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Witness {
    /// True when there are this many components and all are Active.
    pub fn all_active(&self, count: usize) -> bool {
        self.0.len() == count && self.0.values().all(|seen| seen.info.state == "Active")
    }

    /// Instance names.
    pub fn names(&self) -> Vec<&str> {
        self.0.keys().map(String::as_str).collect()
    }

    /// One component.
    #[track_caller]
    pub fn of(&self, instance: &str) -> &Seen {
        let found = self.0.get(instance);
        found.unwrap_or_else(|| panic!("no {instance} among {:?}", self.names()))
    }

    /// The same without some.
    #[must_use]
    pub fn without(&self, instances: &[&str]) -> Self {
        let mut all = self.0.clone();
        all.retain(|name, _| !instances.contains(&name.as_str()));
        Self(all)
    }

    /// The same with those only whose name begins like this.
    #[must_use]
    pub fn only(&self, prefix: &str) -> Self {
        let mut all = self.0.clone();
        all.retain(|name, _| name.starts_with(prefix));
        Self(all)
    }

    /// These components live on in the same processes and incarnations, are Active, and have read more samples since,
    /// without a gap.
    #[track_caller]
    pub fn goes_on_undisturbed(&self, stack: &Stack) {
        let deadline = Instant::now() + LIMIT;
        loop {
            let now = stack.witness();
            for (name, before) in &self.0 {
                let after = now.of(name);
                assert_eq!(after.pid, before.pid, "{name} is in another process");
                assert_eq!(
                    after.info.incarnation, before.info.incarnation,
                    "{name} was made again"
                );
                assert_eq!(after.info.state, "Active", "{name}: {:?}", after.info);
                for binding in &after.info.bindings {
                    assert_eq!(binding.gaps, 0, "{name}: {binding:?}");
                    assert!(binding.connected, "{name}: {binding:?}");
                }
            }
            let stalls = |(name, before): &(&String, &Seen)| {
                let after = now.of(name);
                let more = |b: &rts_manager_api::control::BindingInfo| {
                    let then = before.info.bindings.iter();
                    then.filter(|t| t.connector == b.connector)
                        .all(|t| b.samples_received > t.samples_received)
                };
                !after.info.bindings.iter().all(more)
            };
            let stalled: Vec<&String> =
                self.0.iter().filter(stalls).map(|(name, _)| name).collect();
            if stalled.is_empty() {
                return;
            }
            assert!(
                Instant::now() < deadline,
                "no more samples come to {stalled:?}"
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}
