//! What a control connection can ask for.

mod connect;
mod inventory;
mod load;
pub mod shutdown;

use std::sync::Arc;
use std::thread::Thread;
use std::time::Instant;

use rts_manager_api::control::{CreateRequest, Failure, RequestBody, ResponseBody};

use crate::component::{self, Action, Change, Component, Pending, policy};
use crate::failure::{invalid, list, not_found};
use crate::manager::Manager;
use crate::module::Module;
use crate::sync::lock;

/// How far a request is.
pub enum Begun {
    /// It is done.
    Done(ResponseBody),
    /// A component is at it.
    Waits(Waits),
}

/// A request that a component carries out on its own thread.
pub struct Waits {
    component: Arc<Component>,
    pending: Pending,
    good: ResponseBody,
}

impl Waits {
    /// Waits for its end, or for the deadline.
    fn end(self) -> Result<ResponseBody, Failure> {
        self.component.wait(&self.pending).map(|()| self.good)
    }

    /// The answer if there is one by now, or when it is too late for one.
    pub fn look(&self) -> Option<Result<ResponseBody, Failure>> {
        let answer = self.component.look(&self.pending)?;
        Some(answer.map(|()| self.good.clone()))
    }

    /// When it is too late for an answer.
    pub fn deadline(&self) -> Instant {
        self.pending.deadline
    }
}

/// Whether [`begin`] comes back at once: what the rest takes is another thread's time.
pub fn begins_at_once(body: &RequestBody) -> bool {
    match body {
        RequestBody::Create(_)
        | RequestBody::Configure { .. }
        | RequestBody::Activate { .. }
        | RequestBody::Deactivate { .. }
        | RequestBody::Reset { .. }
        | RequestBody::Delete { .. }
        | RequestBody::Bind(_) => true,
        RequestBody::Connect(request) => connect::is_direct(request),
        RequestBody::LoadModule { .. }
        | RequestBody::UnloadModule { .. }
        | RequestBody::Factories
        | RequestBody::Unbind { .. }
        | RequestBody::Disconnect { .. }
        | RequestBody::Tick { .. }
        | RequestBody::Forget { .. }
        | RequestBody::Inventory
        | RequestBody::Shutdown => false,
    }
}

/// Carries out a request. Comes back by the deadline.
pub fn handle(
    manager: &Arc<Manager>,
    body: RequestBody,
    deadline: Instant,
) -> Result<ResponseBody, Failure> {
    match begin(manager, body, deadline, None)? {
        Begun::Done(answer) => Ok(answer),
        Begun::Waits(waits) => waits.end(),
    }
}

/// Carries out a request, as far as that is not a component's business; what a component has to do is begun. Its thread
/// unparks the `waker` when it is done.
pub fn begin(
    manager: &Arc<Manager>,
    body: RequestBody,
    deadline: Instant,
    waker: Option<Thread>,
) -> Result<Begun, Failure> {
    let act = |instance: &str, action| {
        let component = manager.component(instance)?;
        let pending = component.ask(action, deadline, waker.clone())?;
        Ok(Begun::Waits(Waits {
            component,
            pending,
            good: ResponseBody::Done,
        }))
    };
    let answer = match body {
        RequestBody::LoadModule {
            type_name,
            path,
            digest,
        } => load::load(manager, &type_name, &path, digest, deadline)?,
        RequestBody::UnloadModule { type_name } => load::unload(manager, &type_name)?,
        RequestBody::Factories => load::factories(manager),
        RequestBody::Create(request) => return create(manager, &request, deadline, waker),
        RequestBody::Configure {
            instance,
            sets,
            active,
            rate,
            on_disconnect,
            order,
            by_hand,
        } => {
            let change = Box::new(Change {
                on_disconnect: on_disconnect.as_deref().map(policy).transpose()?,
                sets,
                active,
                rate,
                order,
            });
            return act(&instance, Action::Configure { change, by_hand });
        }
        RequestBody::Bind(binding) => connect::bind(manager, binding)?,
        RequestBody::Unbind { connector } => connect::unbind(manager, &connector),
        RequestBody::Connect(request) => connect::connect(manager, request, deadline)?,
        RequestBody::Disconnect {
            instance,
            connector,
            by_hand,
        } => connect::disconnect(manager, &instance, &connector, by_hand)?,
        RequestBody::Activate { instance } => return act(&instance, Action::Activate),
        RequestBody::Deactivate { instance, by_hand } => {
            return act(&instance, Action::Deactivate { by_hand });
        }
        RequestBody::Reset { instance } => return act(&instance, Action::Reset),
        RequestBody::Tick { instance, cycles } => return act(&instance, Action::Tick { cycles }),
        RequestBody::Delete { instance } => match manager.component(&instance) {
            Ok(_) => return act(&instance, Action::Delete),
            Err(_) => ResponseBody::Done,
        },
        RequestBody::Forget {
            instance,
            by_hand,
            connectors,
        } => {
            if let Ok(component) = manager.component(&instance) {
                component.forget_marks(&by_hand, &connectors);
            }
            ResponseBody::Done
        }
        RequestBody::Inventory => inventory::inventory(manager),
        RequestBody::Shutdown => {
            shutdown::shutdown(manager, deadline);
            ResponseBody::Done
        }
    };
    Ok(Begun::Done(answer))
}

fn create(
    manager: &Arc<Manager>,
    request: &CreateRequest,
    deadline: Instant,
    waker: Option<Thread>,
) -> Result<Begun, Failure> {
    let module = match &request.stand_in {
        Some(shape) => {
            let made = Module::stand_in(&request.type_name, shape);
            let name = &request.instance;
            Arc::new(made.map_err(|e| invalid(format!("the stand-in for {name}: {e}")))?)
        }
        None => loaded(manager, &request.type_name)?,
    };
    let (component, pending) = component::begin(manager, module, request, deadline, waker)?;
    let incarnation = component.identity.incarnation.clone();
    Ok(Begun::Waits(Waits {
        component,
        pending,
        good: ResponseBody::Created { incarnation },
    }))
}

fn loaded(manager: &Manager, type_name: &str) -> Result<Arc<Module>, Failure> {
    let modules = lock(&manager.modules);
    modules.get(type_name).cloned().ok_or_else(|| {
        not_found(format!(
            "the type `{type_name}` is not loaded; loaded are: {}",
            list(modules.keys().map(String::as_str))
        ))
    })
}
