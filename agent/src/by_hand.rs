//! What people do by hand: load modules, create and delete components without a system, and change what runs.

mod act;
pub(crate) mod answers;
mod stale;
mod turns;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::messages::{CreateByHand, CreatedByHand, Factory};
use rts_http::problem::Problem;
use rts_manager_api::control::{CreateRequest, ModuleInfo, RequestBody, ResponseBody};
use rts_plan::desired::ManagerKey;
use rts_schemas::names;

use crate::agent::Agent;
use crate::managers::{Manager, Patience};
use answers::{factory, link, module};

pub use turns::Turns;

/// For requests that call into a component or open a module.
const LIMIT: Duration = Duration::from_secs(10);
/// Name of the configuration set that parameters go to.
const DEFAULT_SET: &str = "default";
/// Highest number that is tried for an instance name.
const MAX_NUMBER: u32 = 10_000;

impl Agent {
    /// Opens the module of a type in a manager, which is started when it is not there.
    pub async fn load_by_hand(
        self: &Arc<Self>,
        manager: &str,
        type_name: &str,
    ) -> Result<Factory, Problem> {
        let module = self.modules.find(type_name, None).await.map_err(module)?;
        let (manager, _) = self.find_or_start(manager).await?;
        self.dirty.notify_one();
        load(&manager, type_name, module.path).await.map(factory)
    }

    /// Forgets a module.
    pub async fn unload_by_hand(&self, manager: &str, type_name: String) -> Result<(), Problem> {
        let manager = self.find_manager(manager)?;
        let request = RequestBody::UnloadModule { type_name };
        self.dirty.notify_one();
        manager.link.done(request, LIMIT).await.map_err(link)
    }

    /// Modules that a manager has opened.
    pub async fn factories(&self, manager: &str) -> Result<Vec<Factory>, Problem> {
        let manager = self.find_manager(manager)?;
        let answer = manager.link.call(RequestBody::Factories, LIMIT).await;
        match answer.map_err(link)? {
            ResponseBody::Modules(modules) => Ok(modules.into_iter().map(factory).collect()),
            _ => Err(link(manager.link.unexpected())),
        }
    }

    /// Creates a component that belongs to no system.
    pub async fn create_by_hand(
        self: &Arc<Self>,
        manager: &str,
        wish: CreateByHand,
    ) -> Result<CreatedByHand, Problem> {
        let found = self.modules.find(&wish.type_name, None).await;
        let module_file = found.map_err(module)?;
        let _one_at_a_time = self.naming.lock().await;
        let instance = self.choose_name(&wish).await?;
        let log_path = self.folders.component_log(&instance);
        let (manager, fresh) = self.find_or_start(manager).await?;
        let sets = (!wish.parameters.is_empty())
            .then(|| (DEFAULT_SET.to_owned(), wish.parameters))
            .into_iter()
            .collect();
        let request = CreateRequest {
            instance: instance.clone(),
            type_name: wish.type_name,
            system: None,
            recreate_hash: String::new(),
            restarts: 0,
            sets,
            active: None,
            // As its module wants it.
            execution_kind: String::new(),
            rate: wish.rate,
            log_path: log_path.display().to_string(),
            on_disconnect: None,
            stand_in: None,
            realtime: None,
            execution_context: None,
        };
        let created = self.create_in(&manager, request, module_file.path).await;
        if created.is_err() && fresh {
            stop_if_empty(&manager).await;
        }
        self.dirty.notify_one();
        created?;
        // The next choice of a name must see this one.
        self.observe().await;
        Ok(CreatedByHand {
            node: self.config.node.clone(),
            manager: manager.key.display_name(),
            instance,
        })
    }

    async fn create_in(
        &self,
        manager: &Manager,
        request: CreateRequest,
        module: String,
    ) -> Result<(), Problem> {
        load(manager, &request.type_name, module).await?;
        self.mark_log(manager, &request).await;
        crate::events::lock(&manager.seen).made += 1;
        let created = manager.link.call(RequestBody::Create(request), LIMIT).await;
        created.map(drop).map_err(link)
    }

    /// Deletes a component that belongs to no system.
    pub async fn delete_by_hand(
        self: &Arc<Self>,
        manager: &str,
        instance: &str,
    ) -> Result<(), Problem> {
        let manager = self.find_manager(manager)?;
        let inventory = self.observe().await;
        let observed = inventory.managers.iter().find(|m| m.key == manager.key);
        let component = observed
            .into_iter()
            .flat_map(|m| &m.components)
            .find(|c| c.instance == instance)
            .ok_or_else(|| {
                let manager = manager.key.display_name();
                Problem::not_found(format!("manager {manager} has no component {instance}"))
            })?;
        if let Some(system) = &component.system {
            return Err(Problem::conflict(
                "owned-by-system",
                format!(
                    "{instance} belongs to system {}, which would make it again; remove it from the system's file and apply that, or tear the system down: rtsctl teardown {}",
                    system.name, system.name
                ),
            ));
        }
        let request = RequestBody::Delete {
            instance: instance.to_owned(),
        };
        let deleted = manager.link.done(request, LIMIT).await.map_err(link);
        self.dirty.notify_one();
        deleted
    }

    /// The instance name that was wished, or the type name and the first free number.
    async fn choose_name(self: &Arc<Self>, wish: &CreateByHand) -> Result<String, Problem> {
        let taken = self.taken_names().await;
        if let Some(name) = &wish.instance {
            if let Some(fault) = names::instance_name_problem(name) {
                return Err(Problem::invalid(
                    "invalid-name",
                    format!("{name:?} is no instance name: {fault}"),
                ));
            }
            return match taken.iter().find(|(taken, _)| taken == name) {
                Some((_, place)) => Err(Problem::conflict(
                    "name-taken",
                    format!(
                        "{name} exists already on node {}, in {place}; choose another name",
                        self.config.node
                    ),
                )),
                None => Ok(name.clone()),
            };
        }
        let taken: BTreeSet<&str> = taken.iter().map(|(name, _)| name.as_str()).collect();
        (0..MAX_NUMBER)
            .map(|n| format!("{}{n}", wish.type_name))
            .find(|name| !taken.contains(name.as_str()))
            .ok_or_else(|| {
                Problem::conflict("name-taken", "too many components of this type; name yours")
            })
    }

    /// Instance names of the node, and where each one is or is wanted.
    async fn taken_names(self: &Arc<Self>) -> Vec<(String, String)> {
        let (inventory, wanted) = (self.observe().await, self.wanted_instances().await);
        let mut taken = Vec::new();
        for manager in &inventory.managers {
            let place = format!("manager {}", manager.key.display_name());
            for component in &manager.components {
                taken.push((component.instance.clone(), place.clone()));
            }
        }
        for (name, system) in wanted {
            taken.push((name, format!("system {system}")));
        }
        taken
    }

    /// The manager that a person means: by its display name alone, so that a short name never lands in a system's process.
    fn find_manager(&self, name: &str) -> Result<Arc<Manager>, Problem> {
        let node = &self.config.node;
        self.named(name).ok_or_else(|| {
            Problem::not_found(format!(
                "no manager {name} runs on node {node}; see `rtsctl get managers`"
            ))
        })
    }

    fn named(&self, name: &str) -> Option<Arc<Manager>> {
        let mut all = self.managers.all().into_iter();
        all.find(|manager| manager.key.display_name() == name)
    }

    /// The manager that a person means, and whether it was started just now.
    async fn find_or_start(self: &Arc<Self>, name: &str) -> Result<(Arc<Manager>, bool), Problem> {
        if let Some(manager) = self.named(name) {
            return Ok((manager, false));
        }
        if name.contains('.') {
            return Err(Problem::not_found(format!(
                "no manager {name} runs on node {}; the managers of a system are started by `rtsctl apply`",
                self.config.node
            )));
        }
        if !names::is_manager_name(name) {
            return Err(Problem::invalid(
                "invalid-name",
                format!("{name:?} cannot be the name of a manager"),
            ));
        }
        let key = ManagerKey {
            system: None,
            name: name.to_owned(),
        };
        let started = self.ensure_manager(&key).await;
        started
            .map(|manager| (manager, true))
            .map_err(|e| Problem::unavailable("manager-failed", e.to_string()))
    }
}

/// Stops a manager that was started for a component that could not be made, unless it got another one meanwhile.
async fn stop_if_empty(manager: &Arc<Manager>) {
    let held = manager.link.call(RequestBody::Inventory, LIMIT).await;
    if matches!(held, Ok(ResponseBody::Inventory(i)) if !i.components.is_empty()) {
        return;
    }
    if let Err(e) = manager.stop(Patience::Usual).await {
        tracing::warn!("{e}");
    }
}

async fn load(manager: &Manager, type_name: &str, path: String) -> Result<ModuleInfo, Problem> {
    let request = RequestBody::LoadModule {
        type_name: type_name.to_owned(),
        path,
        digest: None,
    };
    match manager.link.call(request, LIMIT).await.map_err(link)? {
        ResponseBody::Module(module) => Ok(*module),
        _ => Err(link(manager.link.unexpected())),
    }
}
