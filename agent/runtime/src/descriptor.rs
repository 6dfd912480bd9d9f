//! From a component's declaration to the static descriptor of its module.

use std::collections::BTreeSet;
use std::ptr;

use crate::abi::{self, Module};
use crate::component::Component;
use crate::configuration::{Assign, Config, ParameterError, ParameterValue};
use crate::export;
use crate::ports::{InPort, OutPort};
use crate::text::lend;
use crate::types::DataType;

/// Takes down what a component declares. Names are those that profiles use, without the instance's name.
#[derive(Default)]
pub struct Declaration {
    ports: Vec<PortDeclaration>,
    parameters: Vec<ParameterDeclaration>,
}

struct PortDeclaration {
    name: &'static str,
    type_id: &'static str,
    direction: u32,
}

struct ParameterDeclaration {
    name: &'static str,
    default: String,
    target: Box<dyn Assign>,
}

impl Declaration {
    /// Declares an in-port.
    pub fn in_port<T: DataType>(&mut self, name: &'static str) -> InPort<T> {
        InPort::new(self.port::<T>(name, abi::PORT_IN), name)
    }

    /// Declares an out-port.
    pub fn out_port<T: DataType>(&mut self, name: &'static str) -> OutPort<T> {
        OutPort::new(self.port::<T>(name, abi::PORT_OUT), name)
    }

    /// Declares a configuration parameter with its default value.
    pub fn parameter<T: ParameterValue>(&mut self, name: &'static str, default: T) -> Config<T> {
        let text = default.text();
        let config = Config::new(name, default);
        self.parameters.push(ParameterDeclaration {
            name,
            default: text,
            target: Box::new(config.handle()),
        });
        config
    }

    fn port<T: DataType>(&mut self, name: &'static str, direction: u32) -> u32 {
        self.ports.push(PortDeclaration {
            name,
            type_id: T::TYPE_ID,
            direction,
        });
        (self.ports.len() - 1) as u32
    }

    /// Sets a parameter from text.
    pub(crate) fn assign(&self, name: &str, text: &str) -> Result<(), ParameterError> {
        match self.parameters.iter().find(|p| p.name == name) {
            Some(parameter) => parameter.target.assign(text),
            None => Err(ParameterError::Unknown {
                known: self.parameter_names(),
            }),
        }
    }

    fn parameter_names(&self) -> String {
        if self.parameters.is_empty() {
            return "none".into();
        }
        let names: Vec<_> = self.parameters.iter().map(|p| p.name).collect();
        names.join(", ")
    }

    /// What is wrong with it, for the author of the component.
    pub(crate) fn problem(&self) -> Option<String> {
        let ports = self.ports.iter().map(|p| p.name);
        let parameters = self.parameters.iter().map(|p| p.name);
        twice("port", ports).or_else(|| twice("parameter", parameters))
    }
}

fn twice(what: &str, names: impl Iterator<Item = &'static str>) -> Option<String> {
    let mut seen = BTreeSet::new();
    for name in names {
        if name.is_empty() {
            return Some(format!("a {what} is declared without a name"));
        }
        if !seen.insert(name) {
            return Some(format!("the {what} `{name}` is declared twice"));
        }
    }
    None
}

/// Describes a component type. The memory is never freed: a module lives as long as its process.
pub(crate) fn describe<C: Component>() -> &'static Module {
    // A panic here comes again in `create`, which can say so: the descriptor is merely empty.
    let declaration = export::catch(|| {
        let mut declaration = Declaration::default();
        C::declare(&mut declaration);
        declaration
    })
    .unwrap_or_default();
    let ports: &'static [abi::Port] = list(&declaration.ports, port);
    let parameters: &'static [abi::Parameter] = list(&declaration.parameters, parameter);
    Box::leak(Box::new(Module {
        abi_version: abi::ABI_VERSION,
        size: size_of::<Module>() as u32,
        type_name: lend(C::TYPE.name),
        vendor: lend(C::TYPE.vendor),
        category: lend(C::TYPE.category),
        version: lend(C::TYPE.version),
        description: lend(C::TYPE.description),
        idl: lend(""),
        default_rate: C::TYPE.rate,
        execution_kind: C::EXECUTION.number(),
        activity_type: C::EXECUTION.activity(),
        max_instances: C::MAX_INSTANCES,
        // Those that are left to their default say so when they are called for the first time.
        actions: abi::ALL_ACTIONS,
        ports: ports.as_ptr(),
        ports_len: ports.len(),
        parameters: parameters.as_ptr(),
        parameters_len: parameters.len(),
        services: ptr::null(),
        services_len: 0,
        create: export::create::<C>,
        destroy: export::destroy::<C>,
        callback: export::callback::<C>,
        configure: export::configure::<C>,
    }))
}

fn list<T, U>(items: &[T], item: impl Fn(&T) -> U) -> &'static [U] {
    items.iter().map(item).collect::<Vec<_>>().leak()
}

fn port(port: &PortDeclaration) -> abi::Port {
    abi::Port {
        abi_version: abi::ABI_VERSION,
        size: size_of::<abi::Port>() as u32,
        name: lend(port.name),
        type_id: lend(port.type_id),
        direction: port.direction,
        reserved: 0,
    }
}

fn parameter(parameter: &ParameterDeclaration) -> abi::Parameter {
    let facts = parameter.target.facts();
    abi::Parameter {
        abi_version: abi::ABI_VERSION,
        size: size_of::<abi::Parameter>() as u32,
        name: lend(parameter.name),
        default: lend(parameter.default.clone().leak()),
        value_type: lend(facts.value_type.leak()),
        unit: lend(facts.unit),
        constraint: lend(facts.constraint),
        description: lend(facts.description),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::TimedLong;

    #[test]
    fn a_name_that_is_declared_twice_is_a_problem() {
        let mut d = Declaration::default();
        let _: InPort<TimedLong> = d.in_port("in");
        let _ = d.parameter("gain", 1.0);
        assert_eq!(d.problem(), None);
        let _: OutPort<TimedLong> = d.out_port("in");
        assert_eq!(
            d.problem().as_deref(),
            Some("the port `in` is declared twice")
        );
    }

    #[test]
    fn an_unknown_parameter_names_those_that_exist() {
        let mut d = Declaration::default();
        let _ = (d.parameter("alpha", 1.0), d.parameter("gain", 1.0));
        assert_eq!(
            d.assign("aplha", "2").unwrap_err().to_string(),
            "there is no such parameter; the type has alpha, gain"
        );
    }
}
