//! Client of the controller.

use reqwest::Method;
use rts_agent_api::messages::{CreateByHand, CreatedByHand, Factory, ModuleRequest};
use rts_http::client::{Client, segment};
use serde::de::DeserializeOwned;

use crate::objects::{Component, Kind, List, System};
use crate::requests::{ApplyRequest, ApplyResult, PlanResult};
use crate::watch::Watch;
use crate::{ClientError, paths};

/// A controller behind a Unix socket.
#[derive(Debug, Clone)]
pub struct Controller {
    http: Client,
}

impl Controller {
    /// A controller that listens on the client's socket.
    pub fn new(http: Client) -> Self {
        Self { http }
    }

    /// True when it answers `/readyz` with success.
    pub async fn ready(&self) -> bool {
        self.http
            .text(self.http.request(Method::GET, "/readyz"))
            .await
            .is_ok()
    }

    /// All objects of a kind, with counters as of now.
    pub async fn list<T: DeserializeOwned>(&self, kind: Kind) -> Result<List<T>, ClientError> {
        self.http.get(&paths::objects(kind)).await
    }

    /// Watches a kind from a version on.
    pub async fn watch<T: DeserializeOwned>(
        &self,
        kind: Kind,
        from: &str,
    ) -> Result<Watch<T>, ClientError> {
        let request = self
            .http
            .request(Method::GET, &paths::objects(kind))
            .query(&[("watch", "true"), ("resourceVersion", from)]);
        let response = self.http.accept(request).await?;
        Ok(Watch::new(response, self.http.socket().to_owned()))
    }

    /// One system.
    pub async fn system(&self, name: &str) -> Result<System, ClientError> {
        self.http.get(&of_system(paths::SYSTEM, name)).await
    }

    /// Applies a system.
    pub async fn apply(&self, request: &ApplyRequest) -> Result<ApplyResult, ClientError> {
        self.http
            .send(
                Method::PUT,
                &of_system(paths::SYSTEM, &request.spec.name),
                request,
            )
            .await
    }

    /// What an apply would do.
    pub async fn plan(&self, request: &ApplyRequest) -> Result<PlanResult, ClientError> {
        self.http
            .send(
                Method::POST,
                &of_system(paths::SYSTEM_PLAN, &request.spec.name),
                request,
            )
            .await
    }

    /// Asks for a system's end. It is gone when [`Controller::system`] answers 404.
    pub async fn delete(&self, name: &str) -> Result<System, ClientError> {
        self.http
            .json(
                self.http
                    .request(Method::DELETE, &of_system(paths::SYSTEM, name)),
            )
            .await
    }

    /// One component at its stable address.
    pub async fn component(&self, node: &str, instance: &str) -> Result<Component, ClientError> {
        self.http
            .get(&of_component(paths::COMPONENT, node, instance))
            .await
    }

    /// The last `tail` lines of a component's log.
    pub async fn log(
        &self,
        node: &str,
        instance: &str,
        tail: usize,
    ) -> Result<String, ClientError> {
        let path = of_component(paths::COMPONENT_LOG, node, instance);
        self.http
            .text(
                self.http
                    .request(Method::GET, &path)
                    .query(&[("tail", tail)]),
            )
            .await
    }

    /// Loads a module by hand.
    pub async fn load_module(
        &self,
        node: &str,
        manager: &str,
        request: &ModuleRequest,
    ) -> Result<Factory, ClientError> {
        self.http
            .send(
                Method::POST,
                &of_manager(paths::MANAGER_MODULES, node, manager),
                request,
            )
            .await
    }

    /// Unloads a module.
    pub async fn unload_module(
        &self,
        node: &str,
        manager: &str,
        type_name: &str,
    ) -> Result<(), ClientError> {
        let path =
            of_manager(paths::MANAGER_MODULE, node, manager).replace("{type}", &segment(type_name));
        self.http
            .text(self.http.request(Method::DELETE, &path))
            .await
            .map(drop)
    }

    /// Modules that a manager has opened.
    pub async fn factories(&self, node: &str, manager: &str) -> Result<Vec<Factory>, ClientError> {
        self.http
            .get(&of_manager(paths::MANAGER_FACTORIES, node, manager))
            .await
    }

    /// Creates a component by hand.
    pub async fn create(
        &self,
        node: &str,
        manager: &str,
        request: &CreateByHand,
    ) -> Result<CreatedByHand, ClientError> {
        self.http
            .send(
                Method::POST,
                &of_manager(paths::MANAGER_COMPONENTS, node, manager),
                request,
            )
            .await
    }

    /// Deletes a component that was created by hand.
    pub async fn delete_component(
        &self,
        node: &str,
        manager: &str,
        instance: &str,
    ) -> Result<(), ClientError> {
        let path = of_manager(paths::MANAGER_COMPONENT, node, manager)
            .replace("{instance}", &segment(instance));
        self.http
            .text(self.http.request(Method::DELETE, &path))
            .await
            .map(drop)
    }
}

fn of_system(path: &str, name: &str) -> String {
    path.replace("{name}", &segment(name))
}

fn of_component(path: &str, node: &str, instance: &str) -> String {
    path.replace("{node}", &segment(node))
        .replace("{instance}", &segment(instance))
}

fn of_manager(path: &str, node: &str, manager: &str) -> String {
    path.replace("{node}", &segment(node))
        .replace("{name}", &segment(manager))
}
