//! After each round: the stack heals by itself within a bound, nothing acknowledged is lost, and what the user wishes
//! is what there is.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use rts_manager_api::control::ComponentInfo;
use serde_json::Value;

use super::faults::Later;
use super::known::A_NEW_AGENT_REPLACES_WHAT_HANGS;
use super::script::{Act, Round};
use super::stage::{Stage, Stop};
use super::table::Manager;
use super::wish::Wish;

/// Longest healing. The last of four deaths of a process is followed by 4 s of patience.
pub const BOUND: Duration = Duration::from_secs(45);
/// How long something may be lost before it is said to be.
const LOST: Duration = Duration::from_secs(3);
/// How long samples may take to flow.
const FLOW: Duration = Duration::from_secs(8);

impl Stage {
    /// Waits until all is well, and looks at everything.
    pub fn quiet(&mut self, round: &Round) -> Result<(), Stop> {
        let begin = Instant::now();
        self.journal.note("quiet");
        self.faulty = false;
        let hung = std::mem::take(&mut self.hung);
        let agent_ended = std::mem::take(&mut self.agent_ended);
        if agent_ended && !hung.is_empty() && !A_NEW_AGENT_REPLACES_WHAT_HANGS {
            self.later(&Later::Continue(hung));
        }
        self.heal()?;
        self.journal.count_healing(begin.elapsed());
        let healed = begin.elapsed();
        self.journal.note(&format!("healed after {healed:.1?}"));
        self.fulfil(&round.wished)?;
        self.flows()?;
        if let Some(wish) = round.wished.values().next() {
            self.is_as_written(wish)?;
        }
        Ok(())
    }

    /// Until controller and agent run, every system is healthy, and what lives is what is stored.
    fn heal(&mut self) -> Result<(), Stop> {
        let begin = Instant::now();
        let mut lost = None;
        loop {
            let problem = match self.problem()? {
                Ok(()) => return Ok(()),
                Err(problem) => problem,
            };
            let since: &mut Instant = match problem.starts_with("lost") {
                true => lost.get_or_insert_with(Instant::now),
                false => &mut Instant::now(),
            };
            if begin.elapsed() > BOUND || since.elapsed() > LOST {
                let took = begin.elapsed();
                let text = format!("not healed after {took:.1?}: {problem}");
                return Err(Stop::Violated(vec![text]));
            }
            if !problem.starts_with("lost") {
                lost = None;
            }
            self.sleep(Duration::from_millis(150))?;
        }
    }

    /// What is not well yet.
    fn problem(&mut self) -> Result<Result<(), String>, Stop> {
        let up = self.rtsctl(&["up"])?;
        if up.code != 0 {
            return Ok(Err(format!(
                "`rtsctl up` ends with {}: {}",
                up.code, up.err
            )));
        }
        let said = self.rtsctl(&["get", "systems", "-o", "json"])?;
        let Some(systems) = items(&said.out).filter(|_| said.code == 0) else {
            return Ok(Err(format!(
                "`rtsctl get systems` ends with {}: {}",
                said.code, said.err
            )));
        };
        let names: Vec<_> = self.stored.keys().cloned().collect();
        let mut now = BTreeMap::new();
        for name in names {
            let system = systems
                .iter()
                .find(|s| s["metadata"]["name"] == name.as_str());
            match self.stored_as(&name, system) {
                Ok(wish) => now.insert(name, wish),
                Err(problem) => return Ok(Err(problem)),
            };
        }
        if let Some(problem) = systems.iter().find_map(unwell) {
            return Ok(Err(problem));
        }
        let known =
            |s: &Value| now.contains_key(s["metadata"]["name"].as_str().unwrap_or_default());
        if let Some(stranger) = systems.iter().find(|s| !known(s)) {
            let name = &stranger["metadata"]["name"];
            return Ok(Err(format!(
                "system {name} is there, and nobody applied it"
            )));
        }
        self.watcher.look_anew();
        let wishes: Vec<&Wish> = now.values().flatten().collect();
        if let Err(problem) = is_alive(&self.watcher.last(), &wishes) {
            return Ok(Err(problem));
        }
        for (program, count) in [("rts-controller", 1), ("rts-agent", 1)] {
            let pids = self.stack.daemons(program);
            if pids.len() != count {
                return Ok(Err(format!("{count} {program} should run: {pids:?}")));
            }
        }
        self.stored = now
            .into_iter()
            .map(|(name, wish)| (name, vec![wish]))
            .collect();
        Ok(Ok(()))
    }

    /// Which of the candidates is stored.
    fn stored_as(&self, name: &str, system: Option<&Value>) -> Result<Option<Wish>, String> {
        let candidates = self.candidates(name);
        let known: Vec<_> = candidates
            .iter()
            .map(|c| c.as_ref().map(|w| w.serial))
            .collect();
        let Some(system) = system else {
            return match candidates.contains(&None) {
                true => Ok(None),
                false => Err(format!(
                    "lost: there is no system {name}; it should be one of {known:?}"
                )),
            };
        };
        if system["status"]["phase"] == "Terminating" {
            return Err(format!("system {name} is still Terminating"));
        }
        let serial = serial_of(name, system);
        let found = candidates
            .iter()
            .flatten()
            .find(|wish| Some(wish.serial) == serial);
        match found {
            Some(wish) => Ok(Some(wish.clone())),
            None => Err(format!(
                "lost: system {name} is {serial:?}, and should be one of {known:?}"
            )),
        }
    }

    /// What failed in the round is done again, now without faults: it must succeed.
    fn fulfil(&mut self, wished: &BTreeMap<String, Wish>) -> Result<(), Stop> {
        let stored = self.stored.clone();
        let mut again = false;
        for (name, candidates) in &stored {
            let now = candidates.first().and_then(Option::as_ref);
            let act = match (now, wished.get(name)) {
                (now, wish) if now == wish => continue,
                (_, Some(wish)) => Act::Apply(wish.clone(), "again"),
                (_, None) => Act::Teardown(name.clone()),
            };
            again = true;
            self.begin(&act);
            while !self.running.is_empty() {
                self.reap()?;
                self.sleep(Duration::from_millis(5))?;
            }
        }
        if again { self.heal() } else { Ok(()) }
    }

    /// Every in-port gets more samples.
    fn flows(&mut self) -> Result<(), Stop> {
        let begin = Instant::now();
        self.watcher.look_anew();
        let before = received(&self.watcher.last());
        loop {
            self.sleep(Duration::from_millis(100))?;
            let now = received(&self.watcher.last());
            let rises = |(end, count): (&(String, String), &u64)| {
                now.get(end).is_some_and(|now| *now > *count)
            };
            let stuck: Vec<_> = before.iter().filter(|flow| !rises(*flow)).collect();
            if stuck.is_empty() {
                return Ok(());
            }
            if begin.elapsed() > FLOW {
                let text = format!("no samples flow after {FLOW:?}: {stuck:?}");
                return Err(Stop::Violated(vec![text]));
            }
        }
    }

    fn is_as_written(&mut self, wish: &Wish) -> Result<(), Stop> {
        let name = format!("{}.{}.xml", wish.name, wish.serial);
        let file = self.stack.write(&name, wish.xml());
        let said = self.rtsctl(&["diff", &file.to_string_lossy()])?;
        match said.code {
            0 => Ok(()),
            code => {
                let text = format!(
                    "`rtsctl diff {name}` ends with {code}: {}{}",
                    said.out, said.err
                );
                Err(Stop::Violated(vec![text]))
            }
        }
    }
}

fn items(json: &str) -> Option<Vec<Value>> {
    let list: Value = serde_json::from_str(json).ok()?;
    list["items"].as_array().cloned()
}

fn unwell(system: &Value) -> Option<String> {
    let status = &system["status"];
    let well = status["synced"] == true && status["healthy"] == true;
    (!well).then(|| {
        let name = &system["metadata"]["name"];
        let (phase, waits) = (&status["phase"], &status["waitingOn"]);
        let conditions = status["conditions"].as_array().into_iter().flatten();
        let said: Vec<_> = conditions.map(|c| c["message"].to_string()).collect();
        let said = said.join(", ");
        format!("system {name} is {phase}, waiting on {waits}: {said}")
    })
}

/// The serial that the printer of a stored system bears.
fn serial_of(name: &str, system: &Value) -> Option<u64> {
    let printer = format!("{name}p1");
    let mut components = system["spec"]["components"].as_array()?.iter();
    let component = components.find(|c| c["instance"] == printer.as_str())?;
    let prefix = component["configuration"]["sets"]["default"]["prefix"].as_str()?;
    prefix
        .trim_start_matches('v')
        .trim_end_matches('=')
        .parse()
        .ok()
}

type Seen = [(Manager, Option<Vec<ComponentInfo>>)];

/// What lives is what is wished, no more and no less, as it is wished.
fn is_alive(seen: &Seen, wishes: &[&Wish]) -> Result<(), String> {
    let mut expected = BTreeSet::new();
    for wish in wishes {
        for part in &wish.parts {
            expected.insert(part.instance.as_str());
        }
    }
    for (manager, components) in seen {
        let text = manager.text();
        let Some(components) = components else {
            return Err(format!("{text} does not answer"));
        };
        let known = |wish: &&&Wish| wish.name == manager.system;
        let Some(wish) = wishes.iter().find(known) else {
            return Err(format!("{text} lives, and nobody wishes it"));
        };
        for info in components {
            is_as_wished(wish, manager, info)?;
            expected.remove(info.instance.as_str());
        }
        if components.is_empty() {
            return Err(format!("{text} lives with nothing in it"));
        }
    }
    match expected.first() {
        Some(instance) => Err(format!("{instance} is wished and lives nowhere")),
        None => Ok(()),
    }
}

fn is_as_wished(wish: &Wish, manager: &Manager, info: &ComponentInfo) -> Result<(), String> {
    let instance = &info.instance;
    let Some(part) = wish.part(instance) else {
        return Err(format!("{instance} lives, and nobody wishes it"));
    };
    if part.manager != manager.name {
        let text = manager.text();
        return Err(format!(
            "{instance} lives in {text}, and not in {}",
            part.manager
        ));
    }
    if info.state != "Active" {
        return Err(format!("{instance} is {}: {:?}", info.state, info.message));
    }
    if let Some((name, value)) = part.parameter() {
        let now = info.sets.get("default").and_then(|set| set.get(name));
        if now != Some(&value) {
            return Err(format!("{instance}: {name} is {now:?}, and not {value}"));
        }
    }
    let wished = wish.connectors();
    let to_it = wished
        .iter()
        .filter(|(.., target)| target.split('.').next() == Some(instance.as_str()));
    let wished: BTreeSet<_> = to_it.map(|(name, ..)| name.as_str()).collect();
    let there = info.bindings.iter();
    let there: BTreeSet<_> = there.map(|binding| binding.connector.as_str()).collect();
    match there == wished {
        true => Ok(()),
        false => Err(format!(
            "{instance} gets samples of {there:?}, and not of {wished:?}"
        )),
    }
}

fn received(seen: &Seen) -> BTreeMap<(String, String), u64> {
    let all = seen
        .iter()
        .flat_map(|(_, components)| components.iter().flatten());
    let ends = all.flat_map(|info| {
        let bindings = info.bindings.iter();
        let bindings = bindings.filter(|binding| binding.connected);
        bindings.map(|b| {
            (
                (info.instance.clone(), b.connector.clone()),
                b.samples_received,
            )
        })
    });
    ends.collect()
}
