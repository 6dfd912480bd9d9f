//! Where in the file each part of the one model stands, so that a fault that is found later can show the line.

use std::collections::{BTreeMap, BTreeSet};

use super::{composite, order};
use crate::composite::Composites;
use crate::diagnostic::Place;
use crate::placement::{self, PREFIX};
use crate::rts_profile::ReadProfile;
use crate::rts_profile::model::{Component, OrderKind};
use crate::span::Span;
use crate::system::SystemSpec;

/// JSON pointer into a `SystemSpec` (`/components/0`) → place in the profile, or in the overlay that said it last.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Places {
    all: BTreeMap<String, Place>,
    /// Pointers to what overlays said.
    laid: BTreeSet<String>,
}

impl Places {
    /// The place of a part that an overlay says, from now on.
    pub fn put(&mut self, pointer: String, place: Place) {
        self.laid.insert(pointer.clone());
        self.all.insert(pointer, place);
    }

    /// Pointers to what overlays said, with the last place of each, in the order of the pointers.
    pub fn laid(&self) -> impl Iterator<Item = (&str, &Place)> {
        let laid = self.laid.iter();
        laid.filter_map(|pointer| Some((pointer.as_str(), self.all.get(pointer)?)))
    }

    /// The place of a pointer, else of the nearest part around it that has one.
    pub fn find(&self, pointer: &str) -> Option<&Place> {
        let mut pointer = pointer;
        loop {
            if let Some(place) = self.all.get(pointer) {
                return Some(place);
            }
            pointer = pointer.rsplit_once('/')?.0;
        }
    }
}

/// The places of what was lowered from this file.
pub(crate) fn places(read: &ReadProfile, spec: &SystemSpec) -> Places {
    let mut collect = Collect {
        read,
        places: BTreeMap::new(),
    };
    let id = read.profile.id.as_ref();
    collect.add(
        "/name".to_owned(),
        id.map_or(read.profile.span, |id| id.span),
    );
    for (index, lowered) in spec.components.iter().enumerate() {
        if let Some(component) = read.component(&lowered.instance) {
            collect.component(&format!("/components/{index}"), component);
        }
    }
    let lowered = read.profile.connectors.iter().filter(|connector| {
        let ends = [&connector.source, &connector.target];
        ends.iter().all(|end| {
            end.as_ref()
                .is_some_and(|end| end.instance_name.is_some() && end.port_name.is_some())
        })
    });
    for (index, connector) in lowered.enumerate() {
        let at = format!("/connectors/{index}");
        let end = |target: &Option<_>| -> Option<Span> {
            let target: &crate::rts_profile::model::Target = target.as_ref()?;
            Some(target.port_name.as_ref()?.span)
        };
        let reversed = super::is_reversed(read, connector);
        let (source, target) = match reversed {
            false => (&connector.source, &connector.target),
            true => (&connector.target, &connector.source),
        };
        collect.add(format!("{at}/source"), end(source).unwrap_or_default());
        collect.add(format!("{at}/target"), end(target).unwrap_or_default());
        collect.add(at, connector.span);
    }
    collect.orders();
    Places {
        all: collect.places,
        laid: BTreeSet::new(),
    }
}

struct Collect<'a> {
    read: &'a ReadProfile,
    places: BTreeMap<String, Place>,
}

impl Collect<'_> {
    fn add(&mut self, pointer: String, span: Span) {
        if let Some(place) = self.read.place(span) {
            self.places.entry(pointer).or_insert(place);
        }
    }

    fn component(&mut self, at: &str, component: &Component) {
        let name = component.instance_name.as_ref();
        self.add(at.to_owned(), name.map_or(component.span, |name| name.span));
        if let Some(id) = &component.id {
            self.add(format!("{at}/type"), id.span);
        }
        let context = component.execution_contexts.first();
        if let Some(rate) = context.and_then(|context| context.rate.as_ref()) {
            self.add(format!("{at}/executionContext/rate"), rate.span);
        }
        for (index, (_, port)) in component.ports().enumerate() {
            let span = port.name.as_ref().map_or(port.span, |name| name.span);
            self.add(format!("{at}/ports/{index}"), span);
        }
        if let Some(active) = &component.active_configuration_set {
            self.add(format!("{at}/configuration/active"), active.span);
        }
        for property in &component.properties {
            if let (Some(name), Some(value)) = (&property.name, &property.value)
                && let Some(key) = name.trimmed().strip_prefix(PREFIX)
            {
                let path: Vec<&str> = key.split('.').collect();
                self.add(format!("{at}/{}", placement::pointer(&path)), value.span);
            }
        }
        for set in &component.configuration_sets {
            let Some(id) = &set.id else { continue };
            let at = format!("{at}/configuration/sets/{}", escaped(id.trimmed()));
            // Of several with one name the last one counts.
            for parameter in set.data.iter().rev() {
                if let Some(name) = &parameter.name {
                    self.add(format!("{at}/{}", escaped(name.trimmed())), name.span);
                }
            }
            self.add(at, id.span);
        }
    }

    fn orders(&mut self) {
        let read = self.read;
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        let composites = composite::composites(read);
        let composites = Composites::of(&composites);
        for order in &read.profile.orders {
            let key = key(order.kind);
            // Of several nobody can tell which one a pointer to them all means.
            if read.profile.orders.len() == 1 {
                self.add("/orders".to_owned(), order.span);
            }
            self.add(format!("/orders/{key}"), order.span);
            for condition in &order.conditions {
                let target = condition.target.as_ref();
                let name = target.and_then(|target| target.instance_name.as_ref());
                let span = name.map_or(condition.span, |name| name.span);
                let count = counts.entry(key).or_default();
                for _ in order::conditions(condition, &composites) {
                    let at = format!("/orders/{key}/{count}");
                    *count += 1;
                    self.places
                        .extend(read.place(span).map(|place| (at, place)));
                }
            }
        }
    }
}

/// Name of an order in the one model.
fn key(kind: OrderKind) -> &'static str {
    match kind {
        OrderKind::StartUp => "startUp",
        OrderKind::ShutDown => "shutDown",
        OrderKind::Activation => "activation",
        OrderKind::Deactivation => "deactivation",
        OrderKind::Resetting => "resetting",
        OrderKind::Initializing => "initializing",
        OrderKind::Finalizing => "finalizing",
    }
}

/// The text of a part of a JSON pointer: the other way round than [`escaped`].
pub(crate) fn unescaped(part: &str) -> String {
    part.replace("~1", "/").replace("~0", "~")
}

/// One part of a JSON pointer (RFC 6901).
pub(crate) fn escaped(part: &str) -> String {
    part.replace('~', "~0").replace('/', "~1")
}
