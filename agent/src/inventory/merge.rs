//! Turning the answers of managers into one inventory. Strings are read leniently: a manager may be of another version.

use std::collections::HashMap;
use std::time::Duration;

use rts_manager_api::control::{
    self, BindingInfo, Busy, ByHandInfo, ComponentInfo, ConnectorInfo, DurationInfo,
    ExecutionContextInfo, ManagerInventory, PortInfo, RealtimeInfo, SystemId, TapInfo, TimingInfo,
};
use rts_plan::desired::{ManagerKey, SystemRef};
use rts_plan::observed::{
    Activity, BindingObserved, ByHand, ComponentObserved, ConnectorObserved, ConnectorState,
    DurationsObserved, Inventory, Latency, LifeCycleState, ManagerObserved, PortObserved,
    RealtimeObserved, TapObserved, TimingObserved, Usage,
};
use rts_schemas::system::{
    Configuration, Direction, ExecutionKind, OnDisconnect, PortKind, PortRef, Realtime,
    SharedExecutionContext,
};

use super::hang;
use crate::policies::Policies;

/// What is known of one manager.
#[derive(Debug, Clone)]
pub(crate) struct View {
    pub key: ManagerKey,
    pub incarnation: String,
    pub pid: u32,
    pub started: String,
    pub responsive: bool,
    /// Since when it has not answered.
    pub silent: Option<Duration>,
    /// It does not say what it holds, and may hold more than was seen last.
    pub unseen: bool,
    pub inventory: ManagerInventory,
    /// What its process uses.
    pub usage: Option<Usage>,
}

/// Counts of in-port ends, by (connector, incarnation with the in-port, in-port).
type Arrivals = HashMap<(String, String, String), Arrived>;

/// What became of the samples that came to an in-port end.
#[derive(Debug, Clone, Copy, Default)]
struct Arrived {
    received: u64,
    drops: u64,
    gaps: u64,
    latency: Option<Latency>,
}

impl Arrived {
    /// Within what this end has sent. The in-port's manager was asked a moment earlier or later, and a new connection
    /// counts from 0 at this end only.
    fn within(self, sent: u64, dropped_here: u64) -> Self {
        let received = self.received.min(sent);
        let left = sent.saturating_sub(received).saturating_sub(dropped_here);
        Self {
            received,
            drops: self.drops.min(left),
            ..self
        }
    }
}

/// Merges the answers; the revision is 0.
pub(crate) fn merge(node: &str, mut views: Vec<View>, policies: &Policies) -> Inventory {
    views.sort_by(|a, b| a.key.cmp(&b.key));
    let arrivals = arrivals(&views);
    Inventory {
        node: node.to_owned(),
        revision: 0,
        held: Vec::new(),
        managers: views
            .into_iter()
            .map(|v| manager(v, &arrivals, policies))
            .collect(),
    }
}

fn arrivals(views: &[View]) -> Arrivals {
    let mut arrivals = Arrivals::new();
    for view in views {
        for component in &view.inventory.components {
            // One without a source counts what came over a connection that is no more.
            for binding in component.bindings.iter().filter(|b| b.connected) {
                let (end, port) = (component.incarnation.clone(), binding.port.clone());
                let key = (binding.connector.clone(), end, port);
                let arrived = Arrived {
                    received: binding.samples_received,
                    drops: binding.drops,
                    gaps: binding.gaps,
                    latency: binding.latency.map(latency),
                };
                arrivals.insert(key, arrived);
            }
        }
    }
    arrivals
}

fn manager(view: View, arrivals: &Arrivals, policies: &Policies) -> ManagerObserved {
    let expired = hang::expired(policies, &view);
    let mut components: Vec<_> = view
        .inventory
        .components
        .into_iter()
        .map(|c| component(c, arrivals, policies))
        .collect();
    components.sort_by(|a, b| a.instance.cmp(&b.instance));
    ManagerObserved {
        key: view.key,
        incarnation: view.incarnation,
        pid: view.pid,
        started: view.started,
        responsive: view.responsive,
        unseen: view.unseen,
        expired,
        modules: view.inventory.modules,
        opened: view.inventory.opened,
        components,
        activity: Activity {
            taps: view.inventory.taps.into_iter().map(tap).collect(),
            usage: view.usage,
        },
    }
}

fn tap(info: TapInfo) -> TapObserved {
    TapObserved {
        port: info.port,
        way: info.way,
    }
}

fn component(info: ComponentInfo, arrivals: &Arrivals, policies: &Policies) -> ComponentObserved {
    let hangs = hang::hangs(policies, &info);
    let hangs =
        hangs.map(|busy| self::hangs(busy, &info.instance, info.execution_context.as_ref()));
    let mut connectors: Vec<_> = info
        .connectors
        .into_iter()
        .map(|c| connector(&info.instance, c, arrivals))
        .collect();
    connectors.sort_by(|a, b| a.name.cmp(&b.name));
    let mut bindings: Vec<_> = info.bindings.into_iter().map(binding).collect();
    bindings.sort_by(|a, b| a.connector.cmp(&b.connector));
    ComponentObserved {
        type_name: info.type_name,
        system: info.system.as_ref().map(system_ref),
        incarnation: info.incarnation,
        recreate_hash: info.recreate_hash,
        stand_in: info.stand_in,
        state: state(&info.state),
        message: info.message,
        restarts: info.restarts,
        created: info.created,
        configuration: Configuration {
            active: Some(info.active).filter(|a| !a.is_empty()),
            sets: info.sets,
        },
        defaults: info.defaults,
        hangs,
        on_disconnect: on_disconnect(info.on_disconnect.as_deref()),
        execution_kind: execution_kind(&info.execution_kind),
        runs_with: runs_with(info.execution_context.as_ref()),
        execution_context: info.execution_context.map(shared),
        rate: info.rate,
        executions: info.executions,
        timing: info.timing.map(timing),
        realtime: info.realtime.map(realtime),
        ports: info.ports.into_iter().map(port).collect(),
        connectors,
        bindings,
        by_hand: info.by_hand.map(by_hand).unwrap_or_default(),
        instance: info.instance,
    }
}

fn timing(info: TimingInfo) -> TimingObserved {
    TimingObserved {
        overruns: info.overruns,
        reached: info.reached,
        execution: durations(info.execution),
        jitter: info.jitter.map(durations),
    }
}

fn durations(info: DurationInfo) -> DurationsObserved {
    DurationsObserved {
        count: info.count,
        median: info.median,
        p99: info.p99,
        p999: info.p999,
        max: info.max,
        buckets: info.buckets,
    }
}

fn realtime(info: RealtimeInfo) -> RealtimeObserved {
    let asked = info.asked;
    RealtimeObserved {
        asked: Realtime {
            cpus: asked.cpus,
            priority: asked.priority,
            lock_memory: asked.lock_memory,
            required: asked.required,
        },
        scheduler: info.scheduler,
        priority: info.priority,
        cpus: info.cpus,
        memory_locked: info.memory_locked,
        denied: info.denied,
    }
}

fn by_hand(info: ByHandInfo) -> ByHand {
    ByHand {
        configured: info.configured,
        deactivated: info.deactivated,
        disconnected: info.disconnected,
    }
}

/// Says since when a callback has not returned.
fn hangs(busy: &Busy, instance: &str, shared: Option<&ExecutionContextInfo>) -> String {
    let held_up = shared.map_or(String::new(), |shared| {
        let others = shared.members.iter().map(String::as_str);
        let others: Vec<&str> = others.filter(|other| *other != instance).collect();
        let with = match others.is_empty() {
            true => String::new(),
            false => format!(" with {}", others.join(", ")),
        };
        format!(" and holds up execution context {}{with}", shared.name)
    });
    let (callback, seconds) = (&busy.callback, busy.milliseconds / 1000);
    format!("has been in {callback}{held_up} for {seconds} s")
}

fn connector(instance: &str, info: ConnectorInfo, arrivals: &Arrivals) -> ConnectorObserved {
    let target = PortRef {
        instance: info.target_instance,
        port: info.target_port,
    };
    let end = info.target_incarnation.clone();
    let key = (info.name.clone(), end, target.port.clone());
    // An end that is not known, elsewhere or gone, adds nothing.
    let arrived = arrivals.get(&key).copied().unwrap_or_default();
    // What was refused was not sent.
    let gone = info.drops.saturating_sub(info.refused);
    let arrived = arrived.within(info.samples_sent, gone);
    ConnectorObserved {
        name: info.name,
        source: PortRef {
            instance: instance.to_owned(),
            port: info.port,
        },
        target,
        target_incarnation: info.target_incarnation,
        properties: info.properties,
        by_hand: info.by_hand,
        state: connector_state(&info.state),
        transport: info.transport,
        samples_sent: info.samples_sent,
        samples_received: arrived.received,
        bytes: info.bytes,
        drops: info.drops + arrived.drops,
        gaps: arrived.gaps,
        rate: info.rate,
        latency: arrived.latency,
    }
}

fn latency(info: control::Latency) -> Latency {
    Latency {
        count: info.count,
        min_ns: info.min_ns,
        median_ns: info.median_ns,
        p99_ns: info.p99_ns,
        max_ns: info.max_ns,
    }
}

fn binding(info: BindingInfo) -> BindingObserved {
    let source = info.source.as_deref().and_then(|s| s.rsplit_once('.'));
    BindingObserved {
        connector: info.connector,
        port: info.port,
        source: source.map(|(instance, port)| PortRef {
            instance: instance.to_owned(),
            port: port.to_owned(),
        }),
        connected: info.connected,
        samples_received: info.samples_received,
        drops: info.drops,
        gaps: info.gaps,
    }
}

/// A port in the words of the plan.
pub(crate) fn port(info: PortInfo) -> PortObserved {
    PortObserved {
        name: info.name,
        kind: match info.direction.as_str() {
            "service" => PortKind::Service,
            _ => PortKind::Data,
        },
        direction: match info.direction.as_str() {
            "in" => Some(Direction::In),
            "out" => Some(Direction::Out),
            _ => None,
        },
        data_type: info.data_type,
    }
}

fn state(text: &str) -> LifeCycleState {
    match text {
        "Inactive" => LifeCycleState::Inactive,
        "Active" => LifeCycleState::Active,
        "Error" => LifeCycleState::Error,
        _ => LifeCycleState::Created,
    }
}

fn connector_state(text: &str) -> ConnectorState {
    match text {
        "Connected" => ConnectorState::Connected,
        "Connecting" => ConnectorState::Connecting,
        _ => ConnectorState::Disconnected,
    }
}

/// What it does when a peer is lost; a manager of version 1 says nothing, and goes on.
fn on_disconnect(text: Option<&str>) -> OnDisconnect {
    match text {
        Some("deactivate") => OnDisconnect::Deactivate,
        Some("stop") => OnDisconnect::Stop,
        _ => OnDisconnect::Keep,
    }
}

/// Kind of an execution context by its name in the control protocol.
fn execution_kind(text: &str) -> ExecutionKind {
    match text {
        "periodic" => ExecutionKind::Periodic,
        "eventDriven" => ExecutionKind::EventDriven,
        _ => ExecutionKind::Other,
    }
}

fn runs_with(shared: Option<&ExecutionContextInfo>) -> Vec<String> {
    shared.map_or(Vec::new(), |shared| shared.members.clone())
}

fn shared(info: ExecutionContextInfo) -> SharedExecutionContext {
    SharedExecutionContext {
        name: info.name,
        order: info.order,
        shared_state: info.shared_state,
    }
}

/// A system in the words of the plan.
pub(crate) fn system_ref(id: &SystemId) -> SystemRef {
    SystemRef {
        name: id.name.clone(),
        uid: id.uid.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inventory::fixtures::{bare, view};

    /// What is shown of a connector between two processes: received and dropped. Its out-port end has sent so many
    /// samples and dropped `drops`; its in-port end has received and dropped so many.
    fn seen(sent: u64, drops: u64, came: (u64, u64), connected: bool) -> (u64, u64) {
        let (mut a, mut b) = (bare("A"), bare("B"));
        a.connectors.push(ConnectorInfo {
            name: "c".to_owned(),
            port: "out".to_owned(),
            target_instance: "B".to_owned(),
            target_port: "in".to_owned(),
            target_incarnation: "B".to_owned(),
            properties: Default::default(),
            by_hand: None,
            state: "Connected".to_owned(),
            transport: "uds".to_owned(),
            samples_sent: sent,
            bytes: 0,
            drops,
            refused: 0,
            rate: 0,
        });
        b.bindings.push(BindingInfo {
            connector: "c".to_owned(),
            port: "in".to_owned(),
            source: None,
            connected,
            samples_received: came.0,
            drops: came.1,
            gaps: 0,
            latency: None,
        });
        let views = [a, b].map(|component| view(vec![component])).to_vec();
        let inventory = merge("local", views, &Policies::default());
        let connector = &inventory.managers[0].components[0].connectors[0];
        (connector.samples_received, connector.drops)
    }

    #[test]
    fn never_more_is_received_than_sent_and_only_over_this_connection() {
        assert_eq!(seen(9, 0, (7, 0), true).0, 7);
        assert_eq!(seen(9, 0, (12, 0), true).0, 9);
        assert_eq!(seen(9, 0, (7, 0), false).0, 0);
    }

    #[test]
    fn drops_are_those_of_both_ends_and_account_for_no_more_than_was_sent() {
        assert_eq!(seen(238, 0, (21, 153), true), (21, 153));
        assert_eq!(seen(238, 10, (21, 153), true), (21, 163));
        assert_eq!(
            seen(30, 4, (21, 153), true),
            (21, 9),
            "asked a moment apart"
        );
        assert_eq!(
            seen(238, 10, (21, 153), false),
            (0, 10),
            "of another connection"
        );
    }
}
