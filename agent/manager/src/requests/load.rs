//! Loading, forgetting and listing modules.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Instant;

use rts_manager_api::control::{Failure, FailureCode, ResponseBody};

use crate::failure::{conflict, failure, internal, invalid};
use crate::manager::Manager;
use crate::module::loading::Stamp;
use crate::module::{LoadError, Module};
use crate::sync::lock;

/// Opens a module. Initialisers of a library may hang, and then hold a lock that every dlopen needs, so only one thread
/// at a time is risked for that.
pub fn load(
    manager: &Arc<Manager>,
    type_name: &str,
    path: &str,
    digest: Option<String>,
    deadline: Instant,
) -> Result<ResponseBody, Failure> {
    if let Some(module) = loaded(manager, type_name, path)? {
        return Ok(ResponseBody::Module(Box::new(module.info())));
    }
    if !Path::new(path).is_absolute() {
        return Err(invalid(format!("the module path `{path}` is not absolute")));
    }
    let hangs = |hangs: String| {
        let message = format!("{hangs}; mend or remove it and restart this manager");
        failure(FailureCode::Deadline, message)
    };
    let turn = manager.loading.turn(path, deadline).map_err(hangs)?;
    manager.settle_threads();
    let (reply, answer) = sync_channel(1);
    let opening = thread::Builder::new().name("dlopen".to_owned()).spawn({
        let (manager, type_name, path) =
            (Arc::clone(manager), type_name.to_owned(), path.to_owned());
        move || {
            let module = open(&manager, &type_name, &path);
            if let (Ok(_), Some(digest)) = (&module, digest) {
                lock(&manager.opened).entry(type_name).or_insert(digest);
            }
            drop(turn);
            // Nobody may wait any more; the module then stays loaded.
            let _ = reply.send(module);
        }
    });
    opening.map_err(|e| internal(format!("no thread for dlopen: {e}")))?;
    let left = deadline.saturating_duration_since(Instant::now());
    match answer.recv_timeout(left) {
        Ok(module) => Ok(ResponseBody::Module(Box::new(module?.info()))),
        Err(RecvTimeoutError::Timeout) => {
            let late = || format!("{path} was opened too late");
            Err(hangs(manager.loading.hangs().unwrap_or_else(late)))
        }
        Err(RecvTimeoutError::Disconnected) => Err(internal(format!(
            "the manager failed while it opened {path}; its log says where"
        ))),
    }
}

/// Opens a module, with the turn.
fn open(manager: &Manager, type_name: &str, path: &str) -> Result<Arc<Module>, Failure> {
    if let Some(module) = loaded(manager, type_name, path)? {
        return Ok(module);
    }
    check_fresh(manager, type_name, path)?;
    // Taken before: a file that is replaced meanwhile is then another one at the next load.
    let stamp = Stamp::of(path);
    let opened = Module::load(Path::new(path), type_name);
    if let (Some(stamp), Ok(_) | Err(LoadError::Entry { .. } | LoadError::Descriptor { .. })) =
        (stamp, &opened)
    {
        manager.loading.opened(path, stamp);
    }
    let module =
        opened.map_err(|e| failure(FailureCode::LoadFailed, format!("type {type_name}: {e}")))?;
    let module = Arc::new(module);
    lock(&manager.modules).insert(type_name.to_owned(), Arc::clone(&module));
    Ok(module)
}

/// Refuses a file that is not the one that was opened under its name.
fn check_fresh(manager: &Manager, type_name: &str, path: &str) -> Result<(), Failure> {
    match Stamp::of(path) {
        Some(now) if manager.loading.is_stale(path, now) => Err(failure(
            FailureCode::LoadFailed,
            format!(
                "type {type_name}: {path} has changed since this manager opened it, and code that is loaded cannot be \
                 exchanged; restart this manager"
            ),
        )),
        _ => Ok(()),
    }
}

/// The module of a type when it is loaded from this path; another path is a conflict.
fn loaded(manager: &Manager, type_name: &str, path: &str) -> Result<Option<Arc<Module>>, Failure> {
    let known = lock(&manager.modules).get(type_name).cloned();
    match known {
        None => Ok(None),
        Some(module) if module.path == path => {
            check_fresh(manager, type_name, path)?;
            Ok(Some(module))
        }
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
        .filter(|component| !component.module.is_stand_in())
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
