//! What a control connection can ask for.

mod connect;
mod inventory;
mod load;
pub mod shutdown;

use std::sync::Arc;
use std::time::Instant;

use rts_manager_api::control::{CreateRequest, Failure, RequestBody, ResponseBody};

use crate::component::{self, Action, Change, policy};
use crate::failure::{invalid, list, not_found};
use crate::manager::Manager;
use crate::module::Module;
use crate::sync::lock;

/// Carries out a request. Comes back by the deadline.
pub fn handle(
    manager: &Arc<Manager>,
    body: RequestBody,
    deadline: Instant,
) -> Result<ResponseBody, Failure> {
    let act = |instance: &str, action| -> Result<ResponseBody, Failure> {
        manager.component(instance)?.call(action, deadline)?;
        Ok(ResponseBody::Done)
    };
    match body {
        RequestBody::LoadModule {
            type_name,
            path,
            digest,
        } => load::load(manager, &type_name, &path, digest, deadline),
        RequestBody::UnloadModule { type_name } => load::unload(manager, &type_name),
        RequestBody::Factories => Ok(load::factories(manager)),
        RequestBody::Create(request) => create(manager, &request, deadline),
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
            act(&instance, Action::Configure { change, by_hand })
        }
        RequestBody::Bind(binding) => connect::bind(manager, binding),
        RequestBody::Unbind { connector } => Ok(connect::unbind(manager, &connector)),
        RequestBody::Connect(request) => connect::connect(manager, request, deadline),
        RequestBody::Disconnect {
            instance,
            connector,
            by_hand,
        } => connect::disconnect(manager, &instance, &connector, by_hand),
        RequestBody::Activate { instance } => act(&instance, Action::Activate),
        RequestBody::Deactivate { instance, by_hand } => {
            act(&instance, Action::Deactivate { by_hand })
        }
        RequestBody::Reset { instance } => act(&instance, Action::Reset),
        RequestBody::Tick { instance, cycles } => act(&instance, Action::Tick { cycles }),
        RequestBody::Delete { instance } => match manager.component(&instance) {
            Ok(component) => {
                component.call(Action::Delete, deadline)?;
                Ok(ResponseBody::Done)
            }
            Err(_) => Ok(ResponseBody::Done),
        },
        RequestBody::Forget {
            instance,
            by_hand,
            connectors,
        } => {
            if let Ok(component) = manager.component(&instance) {
                component.forget_marks(&by_hand, &connectors);
            }
            Ok(ResponseBody::Done)
        }
        RequestBody::Inventory => Ok(inventory::inventory(manager)),
        RequestBody::Shutdown => {
            shutdown::shutdown(manager, deadline);
            Ok(ResponseBody::Done)
        }
    }
}

fn create(
    manager: &Arc<Manager>,
    request: &CreateRequest,
    deadline: Instant,
) -> Result<ResponseBody, Failure> {
    let module = match &request.stand_in {
        Some(shape) => {
            let made = Module::stand_in(&request.type_name, shape);
            let name = &request.instance;
            Arc::new(made.map_err(|e| invalid(format!("the stand-in for {name}: {e}")))?)
        }
        None => loaded(manager, &request.type_name)?,
    };
    let incarnation = component::spawn(manager, module, request, deadline)?;
    Ok(ResponseBody::Created { incarnation })
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
