//! Users: they apply, delete and try again as rtsctl does, one thing after the other.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent_api::ClientError;
use rts_agent_api::messages::{Act, ActRequest};
use rts_controller::Core;
use rts_controller_api::Problem;
use rts_controller_api::requests::ApplyRequest;
use rts_schemas::system::SystemSpec;
use tokio::time::{Instant, sleep, timeout};

use super::stage::{Stage, module};
use super::wish::Wish;
use crate::fleet::SimUser;
use crate::schedule::{Deed, Schedule, What};
use crate::truth::Happened;

/// How long a controller may be silent, as for rtsctl.
const SILENCE: Duration = Duration::from_secs(5);
/// Time between two tries, as for rtsctl.
const PAUSE: Duration = Duration::from_millis(200);
/// Time between two calls of rtsctl by a user who was told to try again later.
const LATER: Duration = Duration::from_secs(1);
/// Calls of rtsctl for one thing while anything may go wrong.
const CALLS: u32 = 3;

/// All users together.
pub(super) struct Users {
    world: Arc<Stage>,
    user: SimUser,
    wishes: Mutex<BTreeMap<String, Wish>>,
    busy: AtomicBool,
    /// They try again whatever the controller says.
    patient: AtomicBool,
}

impl Users {
    /// Users who want nothing yet.
    pub fn new(world: &Arc<Stage>, schedule: &Schedule) -> Self {
        let wish = |spec: &SystemSpec| {
            let wish = Wish {
                spec: spec.clone(),
                wanted: false,
                acked: true,
                stale: false,
            };
            (spec.name.clone(), wish)
        };
        Self {
            world: Arc::clone(world),
            user: SimUser::new(&world.hosts),
            wishes: Mutex::new(schedule.systems.iter().map(wish).collect()),
            busy: AtomicBool::new(false),
            patient: AtomicBool::new(false),
        }
    }

    /// What is wanted.
    pub fn wishes(&self) -> BTreeMap<String, Wish> {
        self.lock().clone()
    }

    /// Somebody waits for an answer.
    pub fn are_busy(&self) -> bool {
        self.busy.load(Ordering::Relaxed)
    }

    /// From now on they try again whatever the controller says.
    pub fn insist(&self) {
        self.patient.store(true, Ordering::Relaxed);
    }

    /// Does all that a schedule says.
    pub async fn follow(&self, deeds: &[Deed]) {
        for deed in deeds {
            sleep(deed.at.saturating_sub(self.world.truth.now())).await;
            self.world.note(deed.to_string());
            self.busy.store(true, Ordering::Relaxed);
            self.act(&deed.what).await;
            self.busy.store(false, Ordering::Relaxed);
        }
    }

    async fn act(&self, what: &What) {
        let world = &self.world;
        match what {
            What::Apply { system, change } => {
                if let Some(wish) = self.lock().get_mut(system) {
                    wish.spec = change.make(&wish.spec);
                }
                world.coverage.count("deed apply");
                self.apply(system, CALLS).await;
            }
            What::Delete { system } => {
                world.coverage.count("deed delete");
                self.delete(system, CALLS).await;
            }
            What::Module { type_name, version } => {
                world.coverage.count("deed module");
                world.desired.module_changed(type_name);
                for wish in self.lock().values_mut() {
                    wish.stale = true;
                }
                let digest = module(type_name, *version).digest;
                for node in world.nodes.values() {
                    node.machine.replace_module(type_name, &digest);
                }
            }
            What::Act(act) => self.by_hand(act).await,
        }
    }

    /// Applies a system as it is wanted. True when that was acknowledged.
    pub async fn apply(&self, system: &str, calls: u32) -> bool {
        let Some(spec) = self.want(system, true) else {
            return false;
        };
        let mut replace = false;
        for call in 0..calls {
            if call > 0 {
                sleep(LATER).await;
            }
            self.world.desired.asked(&spec);
            let restores = self.world.restores();
            let mut request = ApplyRequest::of(spec.clone());
            request.replace = replace;
            let name = system.to_owned();
            let work = move |core| -> BoxFuture<'static, _> {
                let (name, request) = (name.clone(), request.clone());
                Box::pin(async move { rts_controller::apply(&core, &name, request, None).await })
            };
            match self.send(work).await {
                Ok(result) => {
                    self.acked(system, Some(result.system.metadata.generation), restores);
                    return true;
                }
                Err(e) => {
                    replace = matches!(&e.0, ClientError::Problem(p) if p.code == "other-system");
                    if !self.failed(system, &e) {
                        return false;
                    }
                }
            }
        }
        false
    }

    /// Asks for a system's end. True when that was acknowledged.
    pub async fn delete(&self, system: &str, calls: u32) -> bool {
        if self.want(system, false).is_none() {
            return false;
        }
        for call in 0..calls {
            if call > 0 {
                sleep(LATER).await;
            }
            self.world.desired.deletion_asked(system);
            let restores = self.world.restores();
            let name = system.to_owned();
            let work = move |core| -> BoxFuture<'static, _> {
                let name = name.clone();
                Box::pin(async move { rts_controller::delete(&core, &name, None).await })
            };
            match self.send(work).await {
                Ok(_) => {
                    self.acked(system, None, restores);
                    return true;
                }
                // There is none: all the better.
                Err((ClientError::Problem(problem), _)) if problem.status == 404 => {
                    self.acked(system, None, restores);
                    return true;
                }
                Err(e) => {
                    if !self.failed(system, &e) {
                        return false;
                    }
                }
            }
        }
        false
    }

    /// Sends it again while nobody answers, as rtsctl does. False beside the error where an earlier try may have been
    /// heard.
    async fn send<T: Send + 'static>(
        &self,
        work: impl Fn(Arc<Core>) -> BoxFuture<'static, Result<T, Problem>> + Clone + Send + 'static,
    ) -> Result<T, (ClientError, bool)> {
        let end = Instant::now() + SILENCE;
        let mut certain = true;
        loop {
            match self.user.ask(work.clone()).await {
                Err(ClientError::Unreachable { .. }) if Instant::now() < end => {
                    certain = false;
                    sleep(PAUSE).await;
                }
                answer => return answer.map_err(|e| (e, certain)),
            }
        }
    }

    fn want(&self, system: &str, wanted: bool) -> Option<SystemSpec> {
        let mut wishes = self.lock();
        let wish = wishes.get_mut(system)?;
        wish.wanted = wanted;
        wish.acked = false;
        Some(wish.spec.clone())
    }

    /// `restores` is how often a store had been restored when it was asked for.
    fn acked(&self, system: &str, generation: Option<u64>, restores: u64) {
        if let Some(wish) = self.lock().get_mut(system) {
            wish.acked = true;
            wish.stale &= generation.is_none();
        }
        self.world.coverage.count("wishes acknowledged");
        self.world.truth.tell(&Happened::DesiredAcked {
            system: system.to_owned(),
            generation,
        });
        if self.world.restores() != restores || !self.world.is_served() {
            // The store that it was said of is no longer the one that counts.
            self.world.desired.restored();
        }
    }

    /// True when a user would try again.
    fn failed(&self, system: &str, (error, certain): &(ClientError, bool)) -> bool {
        self.world.note(format!("user: {system}: {error}"));
        match error {
            ClientError::Problem(problem) => {
                // A try before that was not answered may have been stored.
                if *certain {
                    self.world.desired.refused(system);
                }
                self.world
                    .coverage
                    .count(&format!("refused {}", problem.code));
                problem.retryable || problem.status == 409 || self.patient.load(Ordering::Relaxed)
            }
            // It may have been done.
            _ => true,
        }
    }

    async fn by_hand(&self, act: &Act) {
        let world = &self.world;
        world.coverage.count("deed by hand");
        let nodes = world.nodes.keys();
        let alive = world.ground.alive();
        let mut here = alive
            .iter()
            .filter(|a| a.subject.instance == act.instance());
        let node = here.next().map(|a| a.subject.node.clone());
        let Some(node) = node.or_else(|| nodes.into_iter().next().cloned()) else {
            return;
        };
        world.desired.by_hand(act.instance());
        if let Act::Connect { target, .. } = act {
            world.desired.by_hand(&target.instance);
        }
        // It goes through the controller, which hands it on.
        let Some(agent) = world.hosts.agent(&node) else {
            world.note(format!("user: no agent on {node}"));
            return;
        };
        let request = ActRequest {
            act: act.clone(),
            dry_run: false,
        };
        match timeout(Duration::from_secs(30), agent.act(&request)).await {
            Ok(Ok(done)) => {
                world.coverage.count("acts by hand done");
                world.note(format!("user: {} changed: {}", done.target, done.changed));
            }
            Ok(Err(e)) => world.note(format!("user: {e}")),
            Err(_) => world.note("user: no answer"),
        }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Wish>> {
        self.wishes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
