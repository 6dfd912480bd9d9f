//! Making a component: first it is known by its name, then it is initialised.

use std::collections::BTreeMap;

use rts_host::clock::Chance;
use rts_manager_api::control::{ByHandInfo, CreateRequest, Failure, FailureCode, RealtimeInfo};
use rts_plan::desired::SystemRef;
use rts_schemas::names::instance_name_problem;
use rts_schemas::system::rate_problem;
use tokio::sync::oneshot;

use super::configuration::Configuration;
use super::connection::refuse;
use super::handle::Handle;
use super::loss::policy;
use super::state::{At, Component, LifeCycle, Parting, Process};
use crate::modules::{DEFAULT_RATE, SimModule};
use crate::truth::{Cause, Happened, Subject};

/// Makes a component known.
pub(super) fn add(handle: &Handle, request: CreateRequest) -> Result<At, Failure> {
    let incarnation = handle.shared.streams.ids.uuid();
    let created = handle.shared.now();
    let number = handle.number;
    let gone = || Err(refuse(FailureCode::Internal, "the process has ended"));
    handle
        .change(|state| {
            let node = state.node.clone();
            let process = state.living(number)?;
            Some(process.add(node, request, incarnation, created))
        })
        .unwrap_or_else(gone)
}

impl Process {
    fn add(
        &mut self,
        node: String,
        request: CreateRequest,
        incarnation: String,
        created: String,
    ) -> Result<At, Failure> {
        let instance = request.instance.clone();
        let stand_in = request.stand_in.clone().map(|shape| SimModule {
            ports: shape.ports,
            parameters: shape.parameters,
            ..SimModule::new(&request.type_name)
        });
        let module = stand_in.or_else(|| self.modules.get(&request.type_name).cloned());
        let module = module.ok_or_else(|| {
            let message = format!("the type `{}` is not loaded", request.type_name);
            refuse(FailureCode::NotFound, message)
        })?;
        check(&request)?;
        if self.stopping {
            let message = "the manager is shutting down";
            return Err(refuse(FailureCode::Conflict, message));
        }
        if let Some(other) = self.components.get(&instance) {
            let other = &other.subject.incarnation;
            let message = format!(
                "there is a component `{instance}` already (incarnation {other}); delete it first"
            );
            return Err(refuse(FailureCode::Conflict, message));
        }
        let subject = Subject {
            node,
            manager: self.key.clone(),
            process: self.hello.incarnation.clone(),
            system: request.system.as_ref().map(|system| SystemRef {
                name: system.name.clone(),
                uid: system.uid.clone(),
            }),
            instance: instance.clone(),
            incarnation,
            recreate_hash: request.recreate_hash.clone(),
        };
        let component = component(subject, module, request, created)?;
        let at = component.at(self.number);
        self.components.insert(instance, component);
        Ok(at)
    }
}

fn check(request: &CreateRequest) -> Result<(), Failure> {
    let name = &request.instance;
    let invalid = |why: String| Err(refuse(FailureCode::Invalid, format!("{name}: {why}")));
    if let Some(problem) = instance_name_problem(name) {
        return invalid(problem);
    }
    if request.execution_kind != "periodic" {
        let kind = &request.execution_kind;
        return invalid(format!("the execution context kind `{kind}` is not known"));
    }
    match request.rate.and_then(rate_problem) {
        Some(problem) => invalid(problem),
        None => Ok(()),
    }
}

fn component(
    subject: Subject,
    module: SimModule,
    request: CreateRequest,
    created: String,
) -> Result<Component, Failure> {
    let configuration = Configuration::new(&module.parameters)
        .updated(&request.sets, request.active.as_deref())
        .map_err(|e| refuse(FailureCode::Invalid, format!("{}: {e}", request.instance)))?;
    Ok(Component {
        subject,
        type_name: module.type_name,
        ports: module.ports,
        stand_in: request.stand_in.is_some(),
        system: request.system,
        restarts: request.restarts,
        created,
        state: LifeCycle::Created,
        message: None,
        configuration,
        rate: request.rate.unwrap_or(DEFAULT_RATE),
        on_disconnect: policy(request.on_disconnect.as_deref())?
            .unwrap_or("keep")
            .to_owned(),
        realtime: request.realtime.map(|asked| RealtimeInfo {
            asked,
            ..RealtimeInfo::default()
        }),
        by_hand: ByHandInfo::default(),
        leaving: false,
        busy: None,
        turn: Default::default(),
        lost: false,
        shared: request.execution_context,
        executions: 0.0,
        connectors: BTreeMap::new(),
    })
}

/// Initialises a component that was added.
pub(super) async fn initialise(
    handle: Handle,
    at: At,
    created: oneshot::Sender<Result<(), Failure>>,
) {
    let Some(_turn) = handle.turn(&at).await else {
        return;
    };
    handle.work(500, 15_000).await;
    if let Err(why) = handle.callback(&at, "on_initialize").await {
        handle.change(|state| state.remove(&at, Parting::GoodBye, Cause::Fault));
        let message = format!("{}: {why}", at.instance);
        let failure = refuse(FailureCode::ComponentFailed, message);
        let told = format!("was not created: {}", failure.message);
        if created.send(Err(failure)).is_err() {
            handle.told(&at, told);
        }
        return;
    }
    handle.change(|state| {
        if let Some(component) = state.component(&at) {
            component.state = LifeCycle::Inactive;
            let subject = component.subject.clone();
            state.news.push(Happened::Created(subject));
        }
    });
    if created.send(Ok(())).is_err() {
        handle.told(&at, "was initialised after its deadline".to_owned());
    }
}
