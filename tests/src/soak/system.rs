//! The system of a soak: sources, filters and printers in ten processes, and two connectors for each component.

use std::collections::BTreeSet;

use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::Profile;

/// Processes. Those of the first half are never killed, and so are what is measured.
pub const MANAGERS: usize = 10;
/// Calls per second of every component.
const RATE: &str = "10.0";

/// A system.
#[derive(Debug, Clone)]
pub struct System {
    components: usize,
    /// Pairs of (source, target).
    links: BTreeSet<(usize, usize)>,
    /// Gain of each component, where it is a filter.
    gains: Vec<u32>,
}

/// What a component is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Source,
    Filter,
    Printer,
}

impl System {
    /// One in which each component that has an in-port is fed.
    pub fn draw(components: usize, draw: &mut ChaCha8Rng) -> Self {
        let mut system = Self {
            components,
            links: BTreeSet::new(),
            gains: vec![1; components],
        };
        for target in 0..components {
            if system.kind(target) != Kind::Source {
                let source = system.any_source(target, draw);
                system.links.insert((source, target));
            }
        }
        while system.links.len() < 2 * components {
            system.add_link(draw);
        }
        system
    }

    /// A fifth are sources and three tenths filters. Filters are fed by sources alone, so that samples stay few.
    pub fn kind(&self, component: usize) -> Kind {
        match component * 10 / self.components {
            0 | 1 => Kind::Source,
            2..=4 => Kind::Filter,
            _ => Kind::Printer,
        }
    }

    fn any_source(&self, target: usize, draw: &mut ChaCha8Rng) -> usize {
        let end = match self.kind(target) {
            Kind::Printer => self.first(Kind::Printer),
            _ => self.first(Kind::Filter),
        };
        draw.random_range(0..end)
    }

    /// The first component of a kind.
    fn first(&self, kind: Kind) -> usize {
        let found = (0..self.components).find(|c| self.kind(*c) == kind);
        found.unwrap_or(self.components)
    }

    fn add_link(&mut self, draw: &mut ChaCha8Rng) {
        let target = draw.random_range(self.first(Kind::Filter)..self.components);
        let source = self.any_source(target, draw);
        self.links.insert((source, target));
    }

    /// Another connector in the place of one; each target keeps at least one.
    pub fn rewire(&mut self, draw: &mut ChaCha8Rng) {
        let count = self.links.len();
        let link = self.links.iter().nth(draw.random_range(0..count)).copied();
        let Some(link) = link else { return };
        let others = self.links.iter().filter(|other| other.1 == link.1).count();
        if others > 1 {
            self.links.remove(&link);
        }
        while self.links.len() < count {
            self.add_link(draw);
        }
    }

    /// Another value for some component.
    pub fn configure(&mut self, draw: &mut ChaCha8Rng) {
        let component = draw.random_range(0..self.components);
        self.gains[component] = draw.random_range(1..100);
    }

    /// A connector, as `(source port, target port)`.
    pub fn any_link(&self, draw: &mut ChaCha8Rng) -> (String, String) {
        let place = draw.random_range(0..self.links.len());
        let (source, target) = self.links.iter().nth(place).copied().unwrap_or_default();
        (port(source, "out"), port(target, "in"))
    }

    /// A filter.
    pub fn any_filter(&self, draw: &mut ChaCha8Rng) -> String {
        instance(draw.random_range(self.first(Kind::Filter)..self.first(Kind::Printer)))
    }

    /// Any component.
    pub fn any(&self, draw: &mut ChaCha8Rng) -> String {
        instance(draw.random_range(0..self.components))
    }

    /// Number of its connectors.
    pub fn connectors(&self) -> usize {
        self.links.len()
    }

    /// The profile.
    pub fn xml(&self) -> String {
        let mut profile = Profile::new("soak");
        for component in 0..self.components {
            let type_name = match self.kind(component) {
                Kind::Source => "SineSource",
                Kind::Filter => "LowPassFilter",
                Kind::Printer => "Printer",
            };
            profile = profile
                .component(&instance(component), type_name)
                .with("manager", &manager(component % MANAGERS))
                .rate(RATE);
            if self.kind(component) == Kind::Filter {
                profile = profile.parameter("gain", &format!("{}.0", self.gains[component]));
            }
        }
        for (source, target) in &self.links {
            profile = profile.connect(&port(*source, "out"), &port(*target, "in"));
        }
        profile.xml()
    }
}

/// Name of a manager.
pub fn manager(number: usize) -> String {
    format!("m{number}")
}

fn instance(component: usize) -> String {
    format!("C{component}")
}

fn port(component: usize, name: &str) -> String {
    format!("C{component}.{name}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn every_target_stays_fed_and_the_number_of_connectors_the_same() {
        let mut draw = ChaCha8Rng::seed_from_u64(1);
        let mut system = System::draw(100, &mut draw);
        for _ in 0..500 {
            system.rewire(&mut draw);
            assert_eq!(system.connectors(), 200);
            for target in system.first(Kind::Filter)..100 {
                assert!(system.links.iter().any(|link| link.1 == target), "{target}");
            }
        }
    }
}
