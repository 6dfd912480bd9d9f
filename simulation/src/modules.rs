//! Modules that a simulated machine has: what their files would say, without files.

use std::collections::BTreeMap;

use rts_agent_api::messages::{ModuleDescription, ModuleFile, ModuleResolution};
use rts_manager_api::control::{ModuleInfo, PortInfo};
use rts_plan::observed::PortObserved;
use rts_schemas::names::module_file_names;
use rts_schemas::system::{Direction, PortKind};

/// Where all of them lie.
const FOLDER: &str = "/simulated/modules";
/// Rate of components that ask for none, in Hz.
pub const DEFAULT_RATE: f64 = 100.0;

/// A module.
#[derive(Debug, Clone, PartialEq)]
pub struct SimModule {
    /// Type name.
    pub type_name: String,
    /// SHA-256 of its file, hexadecimal.
    pub digest: String,
    /// Ports of its components.
    pub ports: Vec<PortInfo>,
    /// Parameters with their defaults.
    pub parameters: BTreeMap<String, String>,
    /// It cannot be loaded.
    pub fails: bool,
}

impl SimModule {
    /// A module without ports and parameters.
    pub fn new(type_name: &str) -> Self {
        let mut module = Self {
            type_name: type_name.to_owned(),
            digest: String::new(),
            ports: Vec::new(),
            parameters: BTreeMap::new(),
            fails: false,
        };
        module.digest = module.version(1);
        module
    }

    /// The digest of the `number`th version of it.
    pub fn version(&self, number: u32) -> String {
        let name = self.type_name.bytes();
        let hash = name.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        format!("{hash:016x}{number:048x}")
    }

    /// With a port; `direction` is `in` or `out`.
    #[must_use]
    pub fn port(mut self, name: &str, direction: &str, data_type: &str) -> Self {
        self.ports.push(PortInfo {
            name: name.to_owned(),
            direction: direction.to_owned(),
            data_type: data_type.to_owned(),
        });
        self
    }

    /// With a parameter.
    #[must_use]
    pub fn parameter(mut self, name: &str, default: &str) -> Self {
        self.parameters.insert(name.to_owned(), default.to_owned());
        self
    }

    /// Where its file lies.
    pub fn path(&self) -> String {
        let [file, _] = module_file_names(&self.type_name);
        format!("{FOLDER}/{file}")
    }

    /// What a manager tells of it.
    pub(crate) fn info(&self) -> ModuleInfo {
        ModuleInfo {
            type_name: self.type_name.clone(),
            vendor: "simulated".to_owned(),
            category: "simulated".to_owned(),
            version: "1.0.0".to_owned(),
            description: "a simulated module".to_owned(),
            path: self.path(),
            ports: self.ports.clone(),
            parameters: self.parameters.clone(),
            ..ModuleInfo::default()
        }
    }

    fn description(&self) -> ModuleDescription {
        let port = |port: &PortInfo| PortObserved {
            name: port.name.clone(),
            kind: PortKind::Data,
            direction: match port.direction.as_str() {
                "in" => Some(Direction::In),
                "out" => Some(Direction::Out),
                _ => None,
            },
            data_type: port.data_type.clone(),
        };
        ModuleDescription {
            ports: self.ports.iter().map(port).collect(),
            parameters: self.parameters.clone(),
            limits: BTreeMap::new(),
        }
    }
}

/// All modules of a machine, by type name.
#[derive(Debug, Clone, Default)]
pub(crate) struct Modules(pub BTreeMap<String, SimModule>);

impl Modules {
    /// Where the module of a type is, or where it was looked for.
    pub fn resolve(&self, type_name: &str) -> ModuleResolution {
        let found = self.0.get(type_name);
        let names = module_file_names(type_name).into_iter();
        let mut searched: Vec<_> = names.map(|name| format!("{FOLDER}/{name}")).collect();
        searched.truncate(if found.is_some() { 1 } else { 2 });
        ModuleResolution {
            type_name: type_name.to_owned(),
            module: found.map(|module| ModuleFile {
                path: module.path(),
                digest: module.digest.clone(),
                description: None,
            }),
            searched,
        }
    }

    /// What a module says of itself; none when it cannot be loaded.
    pub fn describe(&self, file: &ModuleFile, type_name: &str) -> Option<ModuleDescription> {
        let module = self.0.get(type_name)?;
        let it = module.path() == file.path && !module.fails;
        it.then(|| module.description())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_is_found_by_its_type_and_says_what_it_has_unless_it_fails() {
        let module = SimModule::new("LowPass").port("in", "in", "TimedDouble");
        let mut modules = Modules::default();
        let searched = modules.resolve("LowPass").searched;
        assert_eq!(
            searched,
            [
                "/simulated/modules/liblow_pass.so",
                "/simulated/modules/LowPass.so"
            ]
        );
        modules.0.insert("LowPass".to_owned(), module.clone());
        let file = modules.resolve("LowPass").module.unwrap();
        assert_eq!(file.path, searched[0]);
        assert_eq!(file.digest.len(), 64);
        assert_ne!(module.version(1), module.version(2));
        let ports = modules.describe(&file, "LowPass").unwrap().ports;
        assert_eq!(ports[0].direction, Some(Direction::In));
        modules.0.get_mut("LowPass").unwrap().fails = true;
        assert_eq!(modules.describe(&file, "LowPass"), None);
    }
}
