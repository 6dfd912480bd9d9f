//! The story: everything comes up, the change is applied, the faults come, until all is well again or the time is over.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use futures_util::future::join_all;
use rts_controller::simulator::Scenario;
use rts_controller_api::Problem;
use rts_controller_api::objects::{Event, Node};
use rts_controller_api::simulate::Simulated;
use tokio::time::{Instant, sleep};

use super::apply::apply;
use super::end::{Wanted, converged, end};
use super::record::Record;
use super::strike::{strike, there};
use super::world::{update_modules, world};
use crate::faults::{Fault, Timed, When};
use crate::words;
use crate::world::trouble::{Lasts, lasts};
use crate::world::{World, programs};

/// Time for all that is stored to come up.
const COME_UP: Duration = Duration::from_secs(120);
/// How long it must stay well: what was lost is noticed in this time.
const SETTLED: Duration = Duration::from_secs(15);
/// How often it is looked at everything.
const LOOK: Duration = Duration::from_millis(20);

/// What no result leaves unsaid.
pub(super) const HONESTLY: &str = "machines and managers are simulated: no component's own code runs, its callbacks end well and at once unless a \
                        fault says otherwise, deaths that were counted before are not known, and times are rough";

/// Said when it is cut short.
const LATE: &str =
    "it took too long to play through: it ends here, and what would have come after is not known";

/// Plays a scenario through.
pub async fn play(scenario: &Scenario, faults: Vec<Timed>) -> Result<Simulated, Problem> {
    let failed = |e: &dyn std::error::Error| Problem::internal(e.to_string());
    let world = world(scenario).await.map_err(|e| failed(&e))?;
    let record = Record::new();
    world.truth.show(record.clone());
    programs::start_all(&world);
    let mut story = Story {
        wanted: Wanted {
            systems: scenario.before.systems.keys().cloned().collect(),
            applied: Some(Default::default()),
        },
        notes: [HONESTLY.to_owned()]
            .into_iter()
            .chain(scenario.notes.iter().cloned())
            .collect(),
        seen: Seen::default(),
        world,
        record,
    };
    story.come_up(scenario).await?;
    update_modules(&story.world, scenario);
    let waits = Arc::new(AtomicUsize::new(0));
    // What was said of the begin is not told.
    story.drain();
    story.record.begin(story.world.truth.now());
    let begin = Instant::now();
    for (text, faults) in words::groups(&faults) {
        story.arm(begin, text, faults, &waits);
    }
    // What strikes at once does so before the apply.
    tokio::task::yield_now().await;
    story.run(scenario, &faults, begin, &waits).await
}

/// Everything of one run.
struct Story {
    world: Arc<World>,
    record: Record,
    wanted: Wanted,
    notes: Vec<String>,
    seen: Seen,
}

/// Events of the controller that were taken over.
#[derive(Default)]
struct Seen {
    /// Of which controller.
    life: Option<usize>,
    revision: u64,
}

impl Story {
    /// Waits until what is stored runs, and every node is there.
    async fn come_up(&mut self, scenario: &Scenario) -> Result<(), Problem> {
        let end = Instant::now() + COME_UP;
        while Instant::now() < end {
            going_on(scenario)?;
            if let Some(core) = self.world.hosts.controller() {
                let nodes = core.view.list::<Node>().items;
                let ready = nodes
                    .iter()
                    .filter(|node| node.status.state == "Ready")
                    .count();
                if ready == self.world.nodes.len() && converged(&core, &self.wanted) {
                    return Ok(());
                }
            }
            sleep(LOOK).await;
        }
        let seconds = COME_UP.as_secs();
        self.notes.push(format!(
            "what is stored did not come up within {seconds} s of simulated time; the simulation begins with that"
        ));
        Ok(())
    }

    /// Lets faults strike when their time comes. Those whose end must be waited for are counted.
    fn arm(&self, begin: Instant, text: String, faults: &[Timed], waits: &Arc<AtomicUsize>) {
        let Some(when) = faults.first().map(|timed| timed.when) else {
            return;
        };
        let faults: Vec<Fault> = faults.iter().map(|timed| timed.fault.clone()).collect();
        let (world, record) = (Arc::clone(&self.world), self.record.clone());
        let waits = Arc::clone(waits);
        if matches!(when, When::At(_)) {
            waits.fetch_add(1, Ordering::Relaxed);
        }
        tokio::spawn(async move {
            match when {
                When::At(at) => tokio::time::sleep_until(begin + at).await,
                When::Step(step) => {
                    record.step(step).await;
                    waits.fetch_add(1, Ordering::Relaxed);
                }
            }
            for fault in &faults {
                there(&world, fault).await;
            }
            record.struck(world.truth.now(), &text);
            // What never ends is not waited for.
            let for_ever = faults.iter().any(|fault| lasts(fault) == Lasts::ForEver);
            if for_ever {
                waits.fetch_sub(1, Ordering::Relaxed);
            }
            let strikes = faults.into_iter().map(|fault| strike(&world, fault));
            if join_all(strikes).await.contains(&true) {
                record.tell(world.truth.now(), "fault", "FaultOver", text);
            }
            if !for_ever {
                waits.fetch_sub(1, Ordering::Relaxed);
            }
        });
    }

    async fn run(
        mut self,
        scenario: &Scenario,
        faults: &[Timed],
        begin: Instant,
        waits: &AtomicUsize,
    ) -> Result<Simulated, Problem> {
        let name = scenario.request.spec.name.clone();
        self.wanted.systems.insert(name);
        self.wanted.applied = None;
        let mut applying = Box::pin(apply(
            Arc::clone(&self.world),
            self.record.clone(),
            scenario,
        ));
        let mut plan = rts_plan::plan::Plan::default();
        let mut well: Option<Instant> = None;
        loop {
            going_on(scenario)?;
            if self.wanted.applied.is_none() {
                let answer = tokio::select! {
                    biased;
                    answer = &mut applying => Some(answer),
                    () = sleep(LOOK) => None,
                };
                match answer {
                    Some(Ok(result)) => {
                        steps_are_there(faults, result.plan.steps.len())?;
                        plan = result.plan.clone();
                        self.record.plan(result.plan);
                        let meta = &result.system.metadata;
                        self.wanted.applied = Some((meta.name.clone(), meta.generation));
                    }
                    Some(Err(problem)) => {
                        let text = problem.detail.clone();
                        let object = format!("system/{}", scenario.request.spec.name);
                        let now = self.world.truth.now();
                        self.record.tell(now, &object, "Refused", text);
                        break;
                    }
                    None => {}
                }
            } else {
                sleep(LOOK).await;
            }
            self.drain();
            let core = self.world.hosts.controller();
            let good = core.is_some_and(|core| converged(&core, &self.wanted));
            well = well.filter(|_| good).or(good.then(Instant::now));
            let settled = well.is_some_and(|since| since.elapsed() >= SETTLED);
            if settled && waits.load(Ordering::Relaxed) == 0 || begin.elapsed() >= scenario.limit {
                break;
            }
            if scenario.stop.is_late() {
                self.notes.push(LATE.to_owned());
                break;
            }
        }
        self.drain();
        let never_came = self.never_came(faults);
        let core = self.world.hosts.controller();
        let mut end = end(core.as_deref(), &self.wanted, &self.record);
        end.converged = well.is_some();
        end.converged_ms = well.map(|at| millis(at.duration_since(begin)));
        end.simulated_ms = millis(begin.elapsed());
        let (events, omitted) = self.record.events();
        self.world.hosts.close();
        Ok(Simulated {
            seed: scenario.seed,
            faults: words::print_all(faults),
            notes: self.notes,
            plan,
            events,
            omitted,
            never_came,
            end,
        })
    }

    /// Takes over what the controller has recorded since the last time.
    fn drain(&mut self) {
        let Some(core) = self.world.hosts.controller() else {
            return;
        };
        let life = Arc::as_ptr(&core) as usize;
        if self.seen.life != Some(life) {
            self.seen = Seen {
                life: Some(life),
                revision: 0,
            };
        }
        if core.view.revision() <= self.seen.revision {
            return;
        }
        let now = self.world.truth.now();
        for event in core.view.events().items {
            let revision = event.metadata.resource_version.parse().unwrap_or(0);
            if revision > self.seen.revision && tells(&event) {
                self.record.event(now, &event);
            }
        }
        self.seen.revision = core.view.revision();
    }

    fn never_came(&self, faults: &[Timed]) -> Vec<String> {
        let came = self.record.came();
        let mut all = words::print_all(faults);
        all.retain(|text| !came.contains(text));
        all
    }
}

/// Of what the truth tells itself, the controller's word is not needed.
fn tells(event: &Event) -> bool {
    event.spec.reason != "ManagerStarted"
}

fn going_on(scenario: &Scenario) -> Result<(), Problem> {
    match scenario.stop.is_stopped() {
        true => Err(Problem::unavailable(
            "stopped",
            "nobody waits for it any more",
        )),
        false => Ok(()),
    }
}

fn steps_are_there(faults: &[Timed], steps: usize) -> Result<(), Problem> {
    for fault in faults {
        let When::Step(step) = fault.when else {
            continue;
        };
        if usize::try_from(step).is_ok_and(|step| step > steps) && steps > 0 {
            let text = words::print(fault);
            let detail = format!("fault `{text}`: the plan has only {steps} steps, 1 to {steps}");
            return Err(Problem::invalid("bad-fault", detail));
        }
    }
    Ok(())
}

fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}
