//! Verbs on components: Create, Configure, Activate, Deactivate, Reset, Delete.

use rts_manager_api::control::{
    CreateRequest, ExecutionContextRequest, FailureCode, RequestBody, ResponseBody,
};
use rts_plan::desired::{ManagerKey, SystemRef};
use rts_plan::mark::Mark;
use rts_plan::observed::Inventory;
use rts_plan::plan::Work;
use rts_schemas::names::instance_name_problem;
use rts_schemas::system::{Configuration, ExecutionKind, OnDisconnect, SharedExecutionContext};

use super::verb::{StepError, Verb, system_id, unless};
use crate::events::lock;
use crate::inventory::system_ref;
use crate::manager_link::LinkError;
use crate::managers::Manager;
use crate::restarts::Leaving;

/// Carries out a step on one component.
pub(super) async fn carry_out(verb: &Verb, work: Work) -> Result<(), StepError> {
    match work {
        Work::Create {
            manager,
            instance,
            type_name,
            recreate_hash,
            configuration,
            execution_kind,
            rate,
            execution_context,
            on_disconnect,
            stand_in,
            realtime,
        } => {
            let mut request = create_request(
                verb,
                instance,
                type_name,
                recreate_hash,
                configuration,
                execution_kind,
                rate,
            );
            request.on_disconnect = Some(on_disconnect_name(on_disconnect).to_owned());
            if let Some(shared) = execution_context {
                let manager = verb.manager(&manager)?;
                share(&manager, &mut request, shared)?;
            }
            if let Some(shape) = stand_in {
                super::stand_in::put_in(&*verb.manager(&manager)?, &mut request, shape)?;
            }
            if let Some(asked) = realtime {
                super::realtime::put_in(&*verb.manager(&manager)?, &mut request, asked)?;
            }
            create(verb, &manager, request).await
        }
        Work::Configure {
            manager,
            instance,
            configuration,
            rate,
            on_disconnect,
            order,
        } => {
            let Configuration { active, sets } = configuration;
            let nothing_else = sets.is_empty() && active.is_none() && rate.is_none();
            if let (true, Some(wanted)) = (nothing_else, on_disconnect) {
                refuse_old(&*verb.manager(&manager)?, &instance, wanted)?;
            }
            let set = Configuration { active, sets };
            let _turn = verb.agent.turns.at(&instance).await;
            let by_hand = mark_left(verb, &manager, &instance, &set).await?;
            let request = RequestBody::Configure {
                instance,
                sets: set.sets,
                active: set.active,
                rate,
                on_disconnect: on_disconnect.map(|wanted| on_disconnect_name(wanted).to_owned()),
                order,
                by_hand,
            };
            done(verb, &manager, request).await
        }
        Work::Activate { manager, instance } => {
            super::activate::activate(verb, &manager, instance).await
        }
        Work::Reset { manager, instance } => {
            done(verb, &manager, RequestBody::Reset { instance }).await
        }
        Work::Deactivate { manager, instance } => {
            done_if_there(
                verb,
                &manager,
                RequestBody::Deactivate {
                    instance,
                    by_hand: None,
                },
            )
            .await
        }
        Work::Delete { manager, instance } => delete(verb, &manager, instance).await,
        other => Err(StepError::Refused(format!(
            "{} is no step on a component",
            other.kind()
        ))),
    }
}

/// What is left of the mark of what a person changed, which ends for what is set: the manager would end it all. None
/// where nothing is left, or nothing of it ends.
async fn mark_left(
    verb: &Verb,
    key: &ManagerKey,
    instance: &str,
    set: &Configuration,
) -> Result<Option<String>, StepError> {
    if *set == Configuration::default() {
        return Ok(None);
    }
    let manager = verb.manager(key)?;
    let asked = manager.link.call(RequestBody::Inventory, verb.limit);
    let ResponseBody::Inventory(inventory) = asked.await? else {
        return Err(manager.link.unexpected().into());
    };
    let mut components = inventory.components.into_iter();
    let found = components.find(|c| c.instance == instance);
    let marks = found.and_then(|component| component.by_hand);
    let text = marks.and_then(|marks| marks.configured);
    let mut mark = text.map(|text| Mark::parse(&text)).unwrap_or_default();
    mark.set(set);
    Ok((!mark.is_empty()).then(|| mark.encode()))
}

/// Asks the manager, which must be there.
pub(super) async fn done(
    verb: &Verb,
    key: &ManagerKey,
    request: RequestBody,
) -> Result<(), StepError> {
    let manager = verb.manager(key)?;
    Ok(manager.link.done(request, verb.limit).await?)
}

/// Asks the manager; what is gone already is fine.
async fn done_if_there(
    verb: &Verb,
    key: &ManagerKey,
    request: RequestBody,
) -> Result<(), StepError> {
    match verb.manager_if_any(key) {
        Some(manager) => unless(
            FailureCode::NotFound,
            manager.link.done(request, verb.limit).await,
        ),
        None => Ok(()),
    }
}

fn create_request(
    verb: &Verb,
    instance: String,
    type_name: String,
    recreate_hash: String,
    configuration: Configuration,
    execution_kind: ExecutionKind,
    rate: Option<f64>,
) -> CreateRequest {
    let log_path = verb.agent.folders.component_log(&instance);
    let restarts = verb
        .system
        .as_ref()
        .map_or(0, |system| verb.agent.restarts.of(system, &instance));
    CreateRequest {
        system: verb.system.as_ref().map(system_id),
        log_path: log_path.display().to_string(),
        execution_kind: kind_name(execution_kind).to_owned(),
        sets: configuration.sets,
        active: configuration.active,
        instance,
        type_name,
        recreate_hash,
        restarts,
        rate,
        on_disconnect: None,
        stand_in: None,
        realtime: None,
        execution_context: None,
    }
}

/// Makes a request one for a component of a shared execution context.
fn share(
    manager: &Manager,
    request: &mut CreateRequest,
    shared: SharedExecutionContext,
) -> Result<(), StepError> {
    if manager.link.version().is_some_and(|version| version < 2) {
        return Err(StepError::Refused(format!(
            "manager {} speaks protocol version 1, which does not know shared execution contexts: stop it, so that a new process \
             takes its place, then {} can be made",
            manager.key.display_name(),
            request.instance
        )));
    }
    request.execution_context = Some(Box::new(ExecutionContextRequest {
        name: shared.name,
        order: shared.order,
        shared_state: shared.shared_state,
    }));
    Ok(())
}

async fn create(verb: &Verb, key: &ManagerKey, request: CreateRequest) -> Result<(), StepError> {
    let manager = verb.manager(key)?;
    let system = verb.system.as_ref();
    if let Some(reason) = system.and_then(|s| verb.agent.restarts.why_held(s, &request.instance)) {
        return Err(StepError::Refused(reason));
    }
    if let Some(problem) = instance_name_problem(&request.instance) {
        return Err(StepError::Refused(format!(
            "{:?} is no instance name: {problem}; rename the component",
            request.instance
        )));
    }
    refuse_clash(verb, key, &request.instance).await?;
    verb.agent.mark_log(&manager, &request).await;
    if let Some(system) = &verb.system {
        // Before it is asked: the component may bring the process down while it is made.
        let agent = &verb.agent;
        agent.component_made(system, &request.instance, &manager.incarnation);
    }
    lock(&manager.seen).made += 1;
    let call = manager
        .link
        .call(RequestBody::Create(request.clone()), verb.limit);
    match call.await {
        Ok(answer) => {
            if let ResponseBody::Created { incarnation } = answer {
                let mut seen = lock(&manager.seen);
                seen.incarnations.insert(request.instance, incarnation);
            }
            Ok(())
        }
        Err(e) => {
            let e = StepError::from(e);
            if e.is(FailureCode::Conflict) && is_there(verb, &manager, &request).await? {
                return Ok(());
            }
            if let (true, Some(system)) = (is_absent(&e), &verb.system) {
                verb.agent.component_gone(system, &request.instance);
            }
            Err(e)
        }
    }
}

/// True for a refusal after which there is no component: one that is late may come all the same, and one that is in
/// the way is there.
fn is_absent(e: &StepError) -> bool {
    e.failure()
        .is_some_and(|f| !matches!(f.code, FailureCode::Deadline | FailureCode::Conflict))
}

/// Deletes a component; what is gone already is fine.
async fn delete(verb: &Verb, key: &ManagerKey, instance: String) -> Result<(), StepError> {
    let Some(manager) = verb.manager_if_any(key) else {
        return Ok(());
    };
    let system = verb.system.as_ref();
    // Before it is asked: should it bring the process down, it does not die by itself.
    let agent = &verb.agent;
    let leaving = system.map(|s| agent.component_leaves(s, &instance, &manager.incarnation));
    let name = instance.clone();
    let request = RequestBody::Delete { instance };
    let deleted = manager.link.done(request, verb.limit).await;
    if matches!(deleted, Err(LinkError::Lost { .. })) {
        // Most likely it did bring the process down.
        gone(leaving);
        return Ok(deleted?);
    }
    unless(FailureCode::NotFound, deleted)?;
    gone(leaving);
    lock(&manager.seen).forget(&name);
    Ok(())
}

fn gone(leaving: Option<Leaving>) {
    if let Some(leaving) = leaving {
        leaving.gone();
    }
}

/// True when the very component exists already.
async fn is_there(
    verb: &Verb,
    manager: &Manager,
    request: &CreateRequest,
) -> Result<bool, StepError> {
    let answer = manager
        .link
        .call(RequestBody::Inventory, verb.limit)
        .await?;
    let ResponseBody::Inventory(inventory) = answer else {
        return Err(manager.link.unexpected().into());
    };
    Ok(inventory.components.iter().any(|c| {
        c.instance == request.instance
            && c.type_name == request.type_name
            && c.recreate_hash == request.recreate_hash
            && c.system.as_ref().map(system_ref) == verb.system
    }))
}

/// Instance names are unique on a node: refuses one that another manager holds.
async fn refuse_clash(verb: &Verb, key: &ManagerKey, instance: &str) -> Result<(), StepError> {
    let agent = &verb.agent;
    let seen = |inventory: &Inventory| holder(inventory, key, instance);
    if agent.inventory.look(seen).is_none() {
        return Ok(());
    }
    // What was seen last may be old.
    match holder(agent.observe().await.as_ref(), key, instance) {
        None => Ok(()),
        Some((manager, system)) => Err(StepError::Refused(match system {
            Some(system) => format!(
                "instance {instance} exists already on node {} in manager {manager}, for system {}; rename one of them or remove that system",
                agent.config.node, system.name
            ),
            None => format!(
                "instance {instance} exists already on node {} in manager {manager}, made by hand; delete it there or rename yours",
                agent.config.node
            ),
        })),
    }
}

fn holder(
    inventory: &Inventory,
    key: &ManagerKey,
    instance: &str,
) -> Option<(String, Option<SystemRef>)> {
    let others = inventory.managers.iter().filter(|m| m.key != *key);
    others
        .flat_map(|m| m.components.iter().map(move |c| (m, c)))
        .find(|(_, c)| c.instance == instance)
        .map(|(m, c)| (m.key.display_name(), c.system.clone()))
}

/// What a manager of version 1 cannot be told: it would do nothing and say that all is well.
fn refuse_old(manager: &Manager, instance: &str, wanted: OnDisconnect) -> Result<(), StepError> {
    if manager.link.version().is_none_or(|version| version >= 2) {
        return Ok(());
    }
    let (name, wanted) = (manager.key.display_name(), on_disconnect_name(wanted));
    Err(StepError::Refused(format!(
        "manager {name} speaks protocol version 1, which does not know rtsctl.onDisconnect: {instance} keeps on when a peer is lost, instead of {wanted}, until its process is replaced when the system is torn down or restarted"
    )))
}

/// Name of what is done when a peer is lost in the control protocol.
fn on_disconnect_name(wanted: OnDisconnect) -> &'static str {
    match wanted {
        OnDisconnect::Keep => "keep",
        OnDisconnect::Deactivate => "deactivate",
        OnDisconnect::Stop => "stop",
    }
}

/// Name of an execution kind in the control protocol.
pub(super) fn kind_name(kind: ExecutionKind) -> &'static str {
    kind.as_str()
}
