//! What a control connection can ask of a manager.

use rts_manager_api::control::{
    CreateRequest, Failure, FailureCode, ModuleInfo, RequestBody, ResponseBody,
};
use tokio::sync::oneshot;
use tokio::time::{Instant, timeout_at};

use super::component::{self, Action};
use super::connection::refuse;
use super::handle::Handle;
use super::state::{At, Process};
use super::{connectors, create, shutdown};

/// Carries out a request. Comes back by the deadline.
pub(super) async fn handle(
    handle: &Handle,
    body: RequestBody,
    deadline: Instant,
) -> Result<ResponseBody, Failure> {
    handle.work(50, 2_000).await;
    let done = |done: Result<(), Failure>| done.map(|()| ResponseBody::Done);
    match body {
        RequestBody::LoadModule {
            type_name, digest, ..
        } => load(handle, &type_name, digest).await,
        RequestBody::UnloadModule { type_name } => {
            done(now(handle, |process| process.unload(&type_name)))
        }
        RequestBody::Factories => now(handle, |process| {
            let infos = process.modules.values().map(|module| module.info());
            Ok(ResponseBody::Modules(infos.collect()))
        }),
        RequestBody::Create(request) => create(handle, request, deadline).await,
        RequestBody::Configure {
            instance,
            sets,
            active,
            rate,
            on_disconnect,
            by_hand,
            order,
        } => {
            let action = Action::Configure {
                sets,
                active,
                rate,
                on_disconnect,
                order,
                by_hand,
            };
            done(act(handle, &instance, action, deadline).await)
        }
        RequestBody::Bind(binding) => connectors::bind(handle, binding),
        RequestBody::Unbind { connector } => {
            connectors::unbind(handle, &connector);
            Ok(ResponseBody::Done)
        }
        RequestBody::Connect(request) => done(connectors::connect(handle, request, deadline).await),
        RequestBody::Disconnect {
            instance,
            connector,
            by_hand,
        } => {
            connectors::disconnect(handle, &instance, &connector, by_hand);
            Ok(ResponseBody::Done)
        }
        RequestBody::Activate { instance } => {
            done(act(handle, &instance, Action::Activate, deadline).await)
        }
        RequestBody::Deactivate { instance, by_hand } => {
            done(act(handle, &instance, Action::Deactivate { by_hand }, deadline).await)
        }
        RequestBody::Reset { instance } => {
            done(act(handle, &instance, Action::Reset, deadline).await)
        }
        // Simulated components have no cycles.
        RequestBody::Tick { instance, .. } => find(handle, &instance).map(|_| ResponseBody::Done),
        RequestBody::Delete { instance } => match find(handle, &instance) {
            Ok(_) => done(act(handle, &instance, Action::Delete, deadline).await),
            Err(_) => Ok(ResponseBody::Done),
        },
        RequestBody::Forget {
            instance,
            by_hand,
            connectors,
        } => now(handle, |process| {
            process.forget(&instance, &by_hand, &connectors);
            Ok(ResponseBody::Done)
        }),
        RequestBody::Inventory => now(handle, |process| {
            Ok(ResponseBody::Inventory(process.inventory()))
        }),
        RequestBody::Shutdown => {
            shutdown::shutdown(handle, deadline).await;
            Ok(ResponseBody::Done)
        }
    }
}

/// Does something that takes no time.
fn now<T>(
    handle: &Handle,
    work: impl FnOnce(&mut Process) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let gone = || Err(refuse(FailureCode::Internal, "the process has ended"));
    handle.with(work).unwrap_or_else(gone)
}

/// The component with this name.
pub(super) fn find(handle: &Handle, instance: &str) -> Result<At, Failure> {
    let number = handle.number;
    now(handle, |process| {
        Ok(process.component(instance)?.at(number))
    })
}

/// Lets a component do something, and waits for that until the deadline.
pub(super) async fn act(
    handle: &Handle,
    instance: &str,
    action: Action,
    deadline: Instant,
) -> Result<(), Failure> {
    let at = find(handle, instance)?;
    let (reply, answer) = oneshot::channel();
    let work = component::obey(handle.clone(), at.clone(), action, deadline, reply);
    handle.spawn(work);
    match timeout_at(deadline, answer).await {
        Ok(Ok(done)) => done,
        Ok(Err(_)) => Err(component::gone(instance)),
        Err(_) => Err(component::late(handle, &at, "did not answer in time")),
    }
}

async fn load(
    handle: &Handle,
    type_name: &str,
    digest: Option<String>,
) -> Result<ResponseBody, Failure> {
    handle.work(500, 8_000).await;
    let number = handle.number;
    let loaded = handle.change(|state| {
        let module = state.modules.0.get(type_name).cloned();
        let process = state.living(number)?;
        Some(process.load(type_name, module, digest))
    });
    let gone = || Err(refuse(FailureCode::Internal, "the process has ended"));
    loaded
        .unwrap_or_else(gone)
        .map(|module| ResponseBody::Module(Box::new(module)))
}

async fn create(
    handle: &Handle,
    request: CreateRequest,
    deadline: Instant,
) -> Result<ResponseBody, Failure> {
    let instance = request.instance.clone();
    let at = create::add(handle, request)?;
    let (reply, answer) = oneshot::channel();
    handle.spawn(create::initialise(handle.clone(), at.clone(), reply));
    match timeout_at(deadline, answer).await {
        Ok(Ok(done)) => done.map(|()| ResponseBody::Created {
            incarnation: at.incarnation,
        }),
        Ok(Err(_)) => Err(component::gone(&instance)),
        Err(_) => Err(component::late(handle, &at, "did not answer in time")),
    }
}

impl Process {
    /// Opens a module, which lies on the machine as `module` says.
    fn load(
        &mut self,
        type_name: &str,
        module: Option<crate::modules::SimModule>,
        digest: Option<String>,
    ) -> Result<ModuleInfo, Failure> {
        let failed = |why: String| {
            let message = format!("type {type_name}: {why}");
            Err(refuse(FailureCode::LoadFailed, message))
        };
        let Some(module) = module else {
            return failed("cannot be opened: no such file".to_owned());
        };
        let path = module.path();
        let stamp = self.stamps.get(&path);
        if stamp.is_some_and(|stamp| *stamp != module.digest) {
            return failed(format!(
                "{path} has changed since this manager opened it, and code that is loaded cannot be exchanged; restart \
                 this manager"
            ));
        }
        if let Some(loaded) = self.modules.get(type_name) {
            return Ok(loaded.info());
        }
        if module.fails {
            return failed(format!("{path} cannot be opened (simulated)"));
        }
        self.stamps.insert(path, module.digest.clone());
        if let Some(digest) = digest {
            self.opened.entry(type_name.to_owned()).or_insert(digest);
        }
        let info = module.info();
        self.modules.insert(type_name.to_owned(), module);
        Ok(info)
    }

    /// Forgets a module that no component uses.
    fn unload(&mut self, type_name: &str) -> Result<(), Failure> {
        let mut components = self.components.values();
        if let Some(user) = components.find(|c| !c.stand_in && c.type_name == type_name) {
            let user = &user.subject.instance;
            let message = format!("the type {type_name} is used by {user}; delete it first");
            return Err(refuse(FailureCode::Conflict, message));
        }
        self.modules.remove(type_name);
        Ok(())
    }

    /// The component with this name.
    pub fn component(&mut self, instance: &str) -> Result<&mut super::state::Component, Failure> {
        let name = &self.hello.name;
        let missing = || {
            let message = format!("there is no component `{instance}` in the manager {name}");
            refuse(FailureCode::NotFound, message)
        };
        self.components.get_mut(instance).ok_or_else(missing)
    }
}
