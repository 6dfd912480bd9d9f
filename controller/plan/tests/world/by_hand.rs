//! What a person does by hand, with the marks that managers keep.

use std::collections::BTreeMap;

use rts_plan::desired::{Desired, PlacedComponent, PlacedConnector};
use rts_plan::mark::{self, Change, Mark};
use rts_plan::observed::{ComponentObserved, ConnectorObserved, ConnectorState, LifeCycleState};
use rts_schemas::system::{Configuration, PortRef};

use super::World;

/// Something that a person does to a component of a system; the first number says to which.
#[derive(Debug, Clone)]
pub enum Hand {
    /// Sets `gain` in the set `default`.
    Set(usize, &'static str),
    /// Activates another set.
    Switch(usize),
    Deactivate(usize),
    Activate(usize),
    /// Connects it to another component of its system, with this subscription type.
    Connect(usize, usize, &'static str),
    /// Takes this one of its connectors away.
    Disconnect(usize, usize),
    /// Makes this one of its connectors anew.
    Reconnect(usize, usize, &'static str),
}

impl World {
    pub fn by_hand(&mut self, hand: &Hand) {
        let (Hand::Set(nth, _)
        | Hand::Switch(nth)
        | Hand::Deactivate(nth)
        | Hand::Activate(nth)
        | Hand::Connect(nth, ..)
        | Hand::Disconnect(nth, _)
        | Hand::Reconnect(nth, ..)) = hand;
        let desired = self.desired();
        let reached = self.managers().filter(|(_, m)| m.responsive);
        let all = reached.flat_map(|(_, m)| &m.components);
        let own: Vec<ComponentObserved> = all.filter(|c| c.system.is_some()).cloned().collect();
        if own.is_empty() {
            return;
        }
        let found = &own[nth % own.len()];
        let connector = |nth: &usize| found.connectors.get(nth % found.connectors.len().max(1));
        match hand {
            Hand::Set(_, value) => self.set_by_hand(&desired, found, "default", value),
            Hand::Switch(_) => self.set_by_hand(&desired, found, "fast", ""),
            Hand::Deactivate(_) => self.deactivate_by_hand(&desired, found),
            Hand::Activate(_) => {
                let component = self.again(found);
                if component.state == LifeCycleState::Inactive {
                    component.state = LifeCycleState::Active;
                    component.by_hand.deactivated = None;
                }
            }
            Hand::Connect(_, other, how) => {
                let peers: Vec<_> = own.iter().filter(|c| c.system == found.system).collect();
                let peer = peers[other % peers.len()];
                self.connect_by_hand(&desired, found, peer, how);
            }
            Hand::Disconnect(_, at) => {
                if let Some(connector) = connector(at) {
                    self.disconnect_by_hand(&desired, found, &connector.name);
                }
            }
            Hand::Reconnect(_, at, how) => {
                let old = connector(at);
                let peer = old.and_then(|old| {
                    let there = |c: &&ComponentObserved| c.incarnation == old.target_incarnation;
                    own.iter().find(there)
                });
                if let Some(peer) = peer {
                    self.connect_by_hand(&desired, found, peer, how);
                }
            }
        }
    }

    /// Sets Filter0's gain.
    pub fn set_gain(&mut self, value: &str) {
        let (desired, filter) = (self.desired(), self.named("Filter0"));
        self.set_by_hand(&desired, &filter, "default", value);
    }

    /// Sets a value of the set `default`.
    pub fn set_value(&mut self, instance: &str, name: &str, value: &str) {
        let (desired, found) = (self.desired(), self.named(instance));
        self.set_value_by_hand(&desired, &found, ("default", name), value);
    }

    pub fn deactivate(&mut self, instance: &str) {
        let names = self.components().map(|(_, _, c)| c.instance.as_str());
        let nth = names.into_iter().position(|name| name == instance);
        self.by_hand(&Hand::Deactivate(nth.unwrap()));
    }

    pub fn disconnect(&mut self, source: &str, name: &str) {
        let (desired, source) = (self.desired(), self.named(source));
        self.disconnect_by_hand(&desired, &source, name);
    }

    /// With subscription type `new`.
    pub fn connect_new(&mut self, source: &str, target: &str) {
        let (desired, source, target) = (self.desired(), self.named(source), self.named(target));
        self.connect_by_hand(&desired, &source, &target, "new");
    }

    fn named(&self, instance: &str) -> ComponentObserved {
        self.component(instance).unwrap().clone()
    }

    fn again(&mut self, component: &ComponentObserved) -> &mut ComponentObserved {
        let mut all = self.components_mut();
        let found = all.find(|c| c.incarnation == component.incarnation);
        found.unwrap()
    }

    /// Sets `gain`, or activates a set when the value is empty.
    pub fn set_by_hand(
        &mut self,
        desired: &Desired,
        found: &ComponentObserved,
        set: &str,
        value: &str,
    ) {
        match value {
            "" => self.switch_by_hand(desired, found, set),
            _ => self.set_value_by_hand(desired, found, (set, "gain"), value),
        }
    }

    /// Sets one value, of a set and with a name.
    pub fn set_value_by_hand(
        &mut self,
        desired: &Desired,
        found: &ComponentObserved,
        (set, name): (&str, &str),
        value: &str,
    ) {
        let before = found.configuration.sets.get(set);
        let before = before.and_then(|set| set.get(name)).map(String::as_str);
        let placed = placed(desired, found);
        let wanted = placed.and_then(|placed| mark::desired(placed, found, set, name));
        let change = placed.zip(wanted).map(|(placed, desired)| Change {
            desired,
            before,
            value,
            policy: placed.spec.policy.drift,
        });
        let mark = marked(found, mark::path(set, name), change);
        let component = self.again(found);
        component.by_hand.configured = mark;
        let set = component.configuration.sets.entry(set.to_owned());
        set.or_default().insert(name.to_owned(), value.to_owned());
    }

    fn switch_by_hand(&mut self, desired: &Desired, found: &ComponentObserved, set: &str) {
        let change = placed(desired, found).map(|placed| Change {
            desired: active(&placed.spec.configuration),
            before: Some(active(&found.configuration)),
            value: set,
            policy: placed.spec.policy.drift,
        });
        let mark = marked(found, mark::ACTIVE.to_owned(), change);
        let component = self.again(found);
        component.by_hand.configured = mark;
        component.configuration.active = Some(set.to_owned());
    }

    pub fn deactivate_by_hand(&mut self, desired: &Desired, found: &ComponentObserved) {
        let mark = placed(desired, found).map(PlacedComponent::settings_digest);
        let component = self.again(found);
        if component.state != LifeCycleState::Error {
            component.state = LifeCycleState::Inactive;
            component.by_hand.deactivated = Some(mark.unwrap_or_default());
        }
    }

    pub fn connect_by_hand(
        &mut self,
        desired: &Desired,
        source: &ComponentObserved,
        target: &ComponentObserved,
        how: &str,
    ) {
        let end = |instance: &str, port: &str| PortRef {
            instance: instance.to_owned(),
            port: port.to_owned(),
        };
        let ends = [end(&source.instance, "out"), end(&target.instance, "in")];
        let [from, to] = ends;
        let name = format!("{from}-{to}");
        let mark = connector_mark(desired, source, &name);
        let how = ("dataport.subscription_type".to_owned(), how.to_owned());
        let component = self.again(source);
        component.by_hand.disconnected.remove(&name);
        component.connectors.retain(|c| c.name != name);
        let mut connector = connected(name, from, to, &target.incarnation);
        let end = connector.clone();
        connector.properties = BTreeMap::from([how]);
        connector.by_hand = Some(mark);
        component.connectors.push(connector);
        self.bind(
            &end.name,
            &end.source,
            &end.target.port,
            &target.incarnation,
        );
    }

    pub fn disconnect_by_hand(
        &mut self,
        desired: &Desired,
        source: &ComponentObserved,
        name: &str,
    ) {
        let mark = connector_mark(desired, source, name);
        let component = self.again(source);
        component.connectors.retain(|c| c.name != *name);
        component.by_hand.disconnected.insert(name.to_owned(), mark);
        let found = source.connectors.iter().find(|c| c.name == name);
        if let Some(found) = found {
            self.unbind_at(&found.target_incarnation, name);
        }
    }
}

impl World {
    /// Agents have managers forget the marks of what is desired no longer.
    pub fn forget_stale_marks(&mut self) {
        let desired = self.desired();
        for component in self.components_mut().filter(|c| c.system.is_some()) {
            let mut mark = Mark::of(component);
            if let Some(placed) = placed(&desired, component) {
                mark.settle(placed, component);
            }
            let stale = component.clone();
            let connector = |name: &str| connector_mark(&desired, &stale, name);
            let marks = &mut component.by_hand;
            marks.configured = (!mark.is_empty()).then(|| mark.encode());
            let is_inactive = component.state == LifeCycleState::Inactive;
            marks.deactivated.take_if(|_| !is_inactive);
            let disconnected = &mut marks.disconnected;
            disconnected.retain(|name, mark| *mark == connector(name));
            for made in &mut component.connectors {
                let now = connector(&made.name);
                made.by_hand.take_if(|mark| *mark != now);
            }
        }
    }
}

/// A connector that works.
pub fn connected(
    name: String,
    source: PortRef,
    target: PortRef,
    incarnation: &str,
) -> ConnectorObserved {
    ConnectorObserved {
        name,
        source,
        target,
        target_incarnation: incarnation.to_owned(),
        properties: BTreeMap::new(),
        by_hand: None,
        state: ConnectorState::Connected,
        transport: "uds".to_owned(),
        samples_sent: 0,
        samples_received: 0,
        bytes: 0,
        drops: 0,
        gaps: 0,
        rate: 0,
        latency: None,
    }
}

fn active(configuration: &Configuration) -> &str {
    configuration.active.as_deref().unwrap_or("default")
}

/// The mark of a component with one more change.
fn marked(found: &ComponentObserved, path: String, change: Option<Change<'_>>) -> Option<String> {
    let mut mark = Mark::of(found);
    if let Some(change) = change {
        mark.change(path, &change);
    }
    (!mark.is_empty()).then(|| mark.encode())
}

fn placed<'a>(desired: &'a Desired, found: &ComponentObserved) -> Option<&'a PlacedComponent> {
    let parts = desired.nodes.values().flat_map(|spec| &spec.systems);
    let mut own = parts
        .filter(|part| Some(&part.system) == found.system.as_ref())
        .flat_map(|part| &part.components);
    own.find(|placed| placed.spec.instance == found.instance)
}

fn connector_mark(desired: &Desired, source: &ComponentObserved, name: &str) -> String {
    let parts = desired.nodes.values().flat_map(|spec| &spec.systems);
    let mut own = parts
        .filter(|part| Some(&part.system) == source.system.as_ref())
        .flat_map(|part| &part.connectors);
    let placed = own.find(|placed| placed.spec.name == name);
    placed.map_or_else(String::new, PlacedConnector::digest)
}
