//! Loading, forgetting and listing modules.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::Instant;

use rts_manager_api::control::{Failure, FailureCode, ResponseBody};

use crate::failure::{conflict, failure, internal, invalid};
use crate::manager::Manager;
use crate::module::Module;
use crate::sync::lock;

/// Opens a module, on another thread: initialisers of a library may hang.
pub fn load(
    manager: &Arc<Manager>,
    type_name: &str,
    path: &str,
    deadline: Instant,
) -> Result<ResponseBody, Failure> {
    if let Some(module) = loaded(manager, type_name, path)? {
        return Ok(ResponseBody::Module(module.info()));
    }
    if !Path::new(path).is_absolute() {
        return Err(invalid(format!("the module path `{path}` is not absolute")));
    }
    let (reply, answer) = sync_channel(1);
    let job = {
        let (manager, type_name, path) =
            (Arc::clone(manager), type_name.to_owned(), path.to_owned());
        // Nobody may wait any more; the module then stays loaded.
        move || drop(reply.send(open(&manager, &type_name, &path)))
    };
    manager.pool.run(job).map_err(internal)?;
    let left = deadline.saturating_duration_since(Instant::now());
    let module = answer.recv_timeout(left).map_err(|_| {
        failure(
            FailureCode::Deadline,
            format!(
                "dlopen of {path} has not returned in time: an initialiser of the library hangs"
            ),
        )
    })??;
    Ok(ResponseBody::Module(module.info()))
}

fn open(manager: &Manager, type_name: &str, path: &str) -> Result<Arc<Module>, Failure> {
    let _one_at_a_time = lock(&manager.loading);
    if let Some(module) = loaded(manager, type_name, path)? {
        return Ok(module);
    }
    let module = Module::load(Path::new(path), type_name)
        .map_err(|e| failure(FailureCode::LoadFailed, format!("type {type_name}: {e}")))?;
    let module = Arc::new(module);
    lock(&manager.modules).insert(type_name.to_owned(), Arc::clone(&module));
    Ok(module)
}

/// The module of a type when it is loaded from this path; another path is a conflict.
fn loaded(manager: &Manager, type_name: &str, path: &str) -> Result<Option<Arc<Module>>, Failure> {
    match lock(&manager.modules).get(type_name) {
        None => Ok(None),
        Some(module) if module.path == path => Ok(Some(Arc::clone(module))),
        Some(module) => Err(conflict(format!(
            "the type {type_name} is loaded from {} already; unload it first",
            module.path
        ))),
    }
}

/// Forgets a module that no component uses.
pub fn unload(manager: &Manager, type_name: &str) -> Result<ResponseBody, Failure> {
    let mut modules = lock(&manager.modules);
    let users: Vec<_> = manager
        .components()
        .into_iter()
        .filter(|component| component.module.type_name == type_name)
        .map(|component| component.identity.instance.clone())
        .collect();
    if !users.is_empty() {
        return Err(conflict(format!(
            "the type {type_name} is used by {}; delete them first",
            users.join(", ")
        )));
    }
    modules.remove(type_name);
    Ok(ResponseBody::Done)
}

/// What is loaded.
pub fn factories(manager: &Manager) -> ResponseBody {
    let modules = lock(&manager.modules);
    ResponseBody::Modules(modules.values().map(|module| module.info()).collect())
}
