//! Client of the controller.

use std::time::Duration;

use futures_util::stream;
use reqwest::{Body, Method, RequestBuilder};
use rts_agent_api::messages::{
    ActRequest, Acted, CreateByHand, CreatedByHand, Factory, InjectLine, InjectQuery, Injected,
    LogQuery, ModuleRequest, Timings, TimingsQuery, micros,
};
use rts_http::client::{Client, segment};
use rts_http::lines::Lines;
use serde::de::DeserializeOwned;
use tokio::sync::mpsc::Receiver;

use crate::objects::{Component, Kind, List, Node, System, SystemState};
use crate::requests::{ApplyRequest, ApplyResult, Exported, NodeClaimed, PlanResult, TakeOver};
use crate::simulate::{SimulateRequest, Simulated};
use crate::watch::Watch;
use crate::{ClientError, paths};

/// A controller behind a Unix socket.
#[derive(Debug, Clone)]
pub struct Controller {
    http: Client,
    /// Lists and watches give objects without their spec.
    states: bool,
}

/// Query for objects without their spec.
const NO_SPEC: [(&str, &str); 1] = [("spec", "false")];

impl Controller {
    /// A controller that listens on the client's socket.
    pub fn new(http: Client) -> Self {
        Self {
            http,
            states: false,
        }
    }

    /// The same controller; its lists and watches give objects without their spec
    /// ([`ObjectState`](crate::objects::ObjectState)).
    #[must_use]
    pub fn states(&self) -> Self {
        Self {
            states: true,
            ..self.clone()
        }
    }

    fn of_kind(&self, kind: Kind) -> RequestBuilder {
        let request = self.http.request(Method::GET, &paths::objects(kind));
        match self.states {
            true => request.query(&NO_SPEC),
            false => request,
        }
    }

    /// True when it answers `/readyz` with success: it can store what it is told.
    pub async fn ready(&self) -> bool {
        self.http
            .text(self.http.request(Method::GET, "/readyz"))
            .await
            .is_ok()
    }

    /// True when it answers `/livez`. One that cannot write its store is alive: it can be asked, and says so itself.
    pub async fn alive(&self) -> bool {
        self.http
            .text(self.http.request(Method::GET, "/livez"))
            .await
            .is_ok()
    }

    /// The error for a controller that does not say what it should.
    pub fn silent(&self, reason: &str) -> ClientError {
        ClientError::Unreachable {
            socket: self.http.socket().to_owned(),
            reason: reason.to_owned(),
        }
    }

    /// All objects of a kind, with counters as of now.
    pub async fn list<T: DeserializeOwned>(&self, kind: Kind) -> Result<List<T>, ClientError> {
        self.http.json(self.of_kind(kind)).await
    }

    /// Watches a kind from a version on.
    pub async fn watch<T: DeserializeOwned>(
        &self,
        kind: Kind,
        from: &str,
    ) -> Result<Watch<T>, ClientError> {
        let from = [("watch", "true"), ("resourceVersion", from)];
        let request = self.of_kind(kind).query(&from);
        let response = self.http.accept(request).await?;
        Ok(Watch::new(response, self.http.socket().to_owned()))
    }

    /// One system.
    pub async fn system(&self, name: &str) -> Result<System, ClientError> {
        self.http.get(&of_system(paths::SYSTEM, name)).await
    }

    /// How one system is: all of it but its spec, which may be large.
    pub async fn system_state(&self, name: &str) -> Result<SystemState, ClientError> {
        let path = of_system(paths::SYSTEM, name);
        let request = self.http.request(Method::GET, &path);
        self.http.json(request.query(&NO_SPEC)).await
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

    /// What would happen to a system under faults. It may take as long as `patience`.
    pub async fn simulate(
        &self,
        request: &SimulateRequest,
        patience: Duration,
    ) -> Result<Simulated, ClientError> {
        let path = of_system(paths::SYSTEM_SIMULATE, &request.spec.name);
        let sent = self.http.request(Method::POST, &path).timeout(patience);
        self.http.json(sent.json(request)).await
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

    /// The same; the end does not need the word of these nodes, which must be Unknown.
    pub async fn delete_but(&self, name: &str, forget: &[String]) -> Result<System, ClientError> {
        let query: Vec<_> = forget.iter().map(|node| ("forgetNode", node)).collect();
        let path = of_system(paths::SYSTEM, name);
        let request = self.http.request(Method::DELETE, &path).query(&query);
        self.http.json(request).await
    }

    /// Makes what runs on a node of another controller this controller's.
    pub async fn adopt(&self, node: &str) -> Result<NodeClaimed, ClientError> {
        let path = of_node(paths::NODE_ADOPT, node);
        self.http.json(self.http.request(Method::POST, &path)).await
    }

    /// Replaces what a node runs for another controller by this controller's set.
    pub async fn take_over(
        &self,
        node: &str,
        request: &TakeOver,
    ) -> Result<NodeClaimed, ClientError> {
        let path = of_node(paths::NODE_TAKE_OVER, node);
        self.http.send(Method::POST, &path, request).await
    }

    /// One node.
    pub async fn node(&self, name: &str) -> Result<Node, ClientError> {
        let path = paths::NODE.replace("{name}", &segment(name));
        self.http.get(&path).await
    }

    /// Forgets a node that is away, or reached by SSH, and on which no system is.
    pub async fn forget_node(&self, name: &str) -> Result<(), ClientError> {
        let path = paths::NODE.replace("{name}", &segment(name));
        let request = self.http.request(Method::DELETE, &path);
        self.http.text(request).await.map(drop)
    }

    /// Where the time went within the last `age`.
    pub async fn timings(&self, age: Duration) -> Result<Timings, ClientError> {
        let query = TimingsQuery {
            micros: micros(age),
        };
        let request = self.http.request(Method::GET, paths::TIMINGS);
        self.http.json(request.query(&query)).await
    }

    /// The whole store as one document, byte by byte as it is to be kept.
    pub async fn backup(&self) -> Result<String, ClientError> {
        self.http
            .text(self.http.request(Method::GET, paths::BACKUP))
            .await
    }

    /// One component at its stable address.
    pub async fn component(&self, node: &str, instance: &str) -> Result<Component, ClientError> {
        self.http
            .get(&of_component(paths::COMPONENT, node, instance))
            .await
    }

    /// The lines of a component's log as they come. A stream that is followed ends only with an error.
    pub async fn log(
        &self,
        node: &str,
        instance: &str,
        query: &LogQuery,
    ) -> Result<Lines, ClientError> {
        let path = of_component(paths::COMPONENT_LOG, node, instance);
        let request = self.http.request(Method::GET, &path).query(query);
        Ok(Lines::of(self.http.accept(request).await?))
    }

    /// What an out-port writes, as it comes: lines of [`PortEvent`](rts_agent_api::messages::PortEvent).
    pub async fn samples(
        &self,
        node: &str,
        instance: &str,
        port: &str,
    ) -> Result<Lines, ClientError> {
        let path = of_port(node, instance, port);
        let request = self.http.request(Method::GET, &path);
        let response = self.http.accept(request).await;
        let response = response.map_err(|e| e.or_upgrade("controller", &path))?;
        Ok(Lines::of(response))
    }

    /// Writes samples to an in-port as they come. Answers when they were read.
    pub async fn inject(
        &self,
        node: &str,
        instance: &str,
        port: &str,
        query: &InjectQuery,
        samples: Receiver<InjectLine>,
    ) -> Result<Injected, ClientError> {
        let path = of_port(node, instance, port);
        let request = self.http.request(Method::POST, &path).query(query);
        let lines = stream::unfold(samples, |mut samples| async {
            let line = line(&samples.recv().await?);
            Some((line, samples))
        });
        let request = request.body(Body::wrap_stream(lines));
        let injected = self.http.unhurried(request).await;
        injected.map_err(|e| e.or_upgrade("controller", &path))
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

    /// Changes by hand what runs on a node.
    pub async fn act(&self, node: &str, request: &ActRequest) -> Result<Acted, ClientError> {
        let path = of_node(paths::NODE_ACTS, node);
        self.http.send(Method::POST, &path, request).await
    }

    /// What an apply of a system as it runs would take.
    pub async fn export(&self, name: &str) -> Result<Exported, ClientError> {
        self.http.get(&of_system(paths::SYSTEM_EXPORT, name)).await
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

fn line(sample: &InjectLine) -> Result<Vec<u8>, serde_json::Error> {
    let mut line = serde_json::to_vec(sample)?;
    line.push(b'\n');
    Ok(line)
}

fn of_system(path: &str, name: &str) -> String {
    path.replace("{name}", &segment(name))
}

fn of_node(path: &str, node: &str) -> String {
    path.replace("{node}", &segment(node))
}

fn of_component(path: &str, node: &str, instance: &str) -> String {
    path.replace("{node}", &segment(node))
        .replace("{instance}", &segment(instance))
}

fn of_port(node: &str, instance: &str, port: &str) -> String {
    of_component(paths::PORT_SAMPLES, node, instance).replace("{port}", &segment(port))
}

fn of_manager(path: &str, node: &str, manager: &str) -> String {
    path.replace("{node}", &segment(node))
        .replace("{name}", &segment(manager))
}
