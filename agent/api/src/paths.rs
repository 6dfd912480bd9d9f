//! Paths of the agent API.

/// `GET`: [`crate::messages::NodeInfo`].
pub const NODE: &str = "/v1/node";
/// `GET`: the inventory.
pub const INVENTORY: &str = "/v1/inventory";
/// `GET`, `PUT`: [`crate::messages::NodeSpecEnvelope`].
pub const NODE_SPEC: &str = "/v1/node-spec";
/// `POST`: [`crate::messages::Batch`], JSON Lines of [`crate::messages::BatchEvent`] back.
pub const BATCHES: &str = "/v1/batches";
/// `POST`: [`crate::messages::GateReport`].
pub const BATCH_GATES: &str = "/v1/batches/{plan}/gates";
/// `POST`: [`crate::messages::ResolveRequest`].
pub const RESOLVE: &str = "/v1/modules/resolve";
/// `GET`, query [`crate::messages::LogQuery`]: a component's log as text.
pub const LOG: &str = "/v1/components/{instance}/log";
/// `GET`: what an out-port writes, as JSON Lines of [`crate::messages::PortEvent`]. `POST`, query
/// [`crate::messages::InjectQuery`]: JSON Lines of [`crate::messages::InjectLine`] are written to an in-port;
/// [`crate::messages::Injected`] back.
pub const SAMPLES: &str = "/v1/components/{instance}/ports/{port}/samples";
/// `POST`: [`crate::messages::ModuleRequest`] loads a module by hand; starts the manager when it is not there.
pub const MANAGER_MODULES: &str = "/v1/managers/{manager}/modules";
/// `DELETE`: unloads a module.
pub const MANAGER_MODULE: &str = "/v1/managers/{manager}/modules/{type}";
/// `GET`: [`crate::messages::Factory`] list.
pub const MANAGER_FACTORIES: &str = "/v1/managers/{manager}/factories";
/// `POST`: [`crate::messages::CreateByHand`] creates a component by hand.
pub const MANAGER_COMPONENTS: &str = "/v1/managers/{manager}/components";
/// `DELETE`: deletes a component that was created by hand.
pub const MANAGER_COMPONENT: &str = "/v1/managers/{manager}/components/{instance}";
/// `POST`: [`crate::messages::ActRequest`] changes what runs by hand; [`crate::messages::Acted`] back.
pub const ACTS: &str = "/v1/acts";
/// `GET`, query [`crate::messages::TimingsQuery`]: [`crate::messages::Timings`].
pub const TIMINGS: &str = "/v1/timings";
/// `POST`: [`crate::messages::BindRequest`] of another node's agent; [`crate::messages::Bound`] back.
pub const BINDINGS: &str = "/v1/bindings";
