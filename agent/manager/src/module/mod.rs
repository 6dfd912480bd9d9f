//! Modules: opening a shared library, or what stands in for one.
//!
//! A library is never closed: its threads, destructors and static data may still be in use.

#![allow(unsafe_code)]

mod descriptor;
mod list;
pub mod loading;
mod parameters;
mod stand_in;

use std::collections::BTreeMap;
use std::mem::ManuallyDrop;
use std::path::Path;

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use rts_host::error::chain;
use rts_manager_api::control::{ModuleInfo, ParameterFacts, PortInfo, StandInShape};
use rts_runtime::abi::ABI_VERSION;
use rts_runtime::abi::{self, ENTRY, Entry};
use rts_schemas::check::Limits;

use self::descriptor::{DescriptorError, describe};

/// Direction of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Reads.
    In,
    /// Writes.
    Out,
}

/// A port of a type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Bare name.
    pub name: String,
    /// IDL repository id.
    pub data_type: String,
    /// Direction.
    pub direction: Direction,
}

/// A module that was opened, its descriptor checked and copied; or what a stand-in is made of.
#[derive(Debug)]
pub struct Module {
    /// Type name.
    pub type_name: String,
    /// Path that was opened.
    pub path: String,
    /// Ports, by their index in the ABI.
    pub ports: Vec<Port>,
    /// Ports that nothing can be connected to.
    listed: Vec<PortInfo>,
    /// Parameters with their defaults.
    pub parameters: BTreeMap<String, String>,
    /// What more it says of its parameters.
    facts: BTreeMap<String, ParameterFacts>,
    /// Which values it allows.
    pub limits: BTreeMap<String, Limits>,
    /// Execution context when nothing else is said.
    pub execution: Execution,
    /// Activity type, as a profile has it.
    activity_type: &'static str,
    /// Most instances in this process; 0 for any number.
    pub max_instances: u32,
    /// Callbacks that it implements, a bit each.
    pub actions: u32,
    /// IDL source of its own types.
    idl: String,
    /// Rate in Hz when nothing else is said.
    pub default_rate: f64,
    /// What its components run.
    pub code: Code,
    texts: [String; 4],
}

/// When an execution context runs a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Execution {
    /// At a fixed rate.
    Periodic,
    /// When a sample arrives, or when the component asks for one.
    EventDriven,
    /// When somebody asks for one.
    External,
}

impl Execution {
    /// Name in the protocol.
    pub fn name(self) -> &'static str {
        match self {
            Self::Periodic => "periodic",
            Self::EventDriven => "eventDriven",
            Self::External => "other",
        }
    }

    /// The kind of this name.
    pub fn of(name: &str) -> Option<Self> {
        let all = [Self::Periodic, Self::EventDriven, Self::External];
        all.into_iter().find(|kind| kind.name() == name)
    }
}

/// What components run.
#[derive(Debug)]
pub enum Code {
    /// The four functions of a library.
    Library(Functions),
    /// Nothing: they stand in for components whose library is not there.
    StandIn(StandInShape),
}

/// What a module offers for its instances; valid for the life of the process.
#[derive(Debug, Clone, Copy)]
pub struct Functions {
    /// See [`abi::Module::create`].
    pub create: unsafe extern "C" fn(*const abi::Host, *mut *mut std::ffi::c_void) -> i32,
    /// See [`abi::Module::destroy`].
    pub destroy: unsafe extern "C" fn(*mut std::ffi::c_void),
    /// See [`abi::Module::callback`].
    pub callback: unsafe extern "C" fn(*mut std::ffi::c_void, u32) -> i32,
    /// See [`abi::Module::configure`].
    pub configure: unsafe extern "C" fn(*mut std::ffi::c_void, abi::Text, abi::Text) -> i32,
}

/// A module that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// dlopen failed.
    #[error(
        "the module cannot be opened: {reason}; check that the file is a shared library for this machine and that \
         `ldd {path}` finds all it needs"
    )]
    Open {
        /// Text of dlerror.
        reason: String,
        /// Path that was tried.
        path: String,
    },
    /// It does not export the entry function.
    #[error(
        "{path} exports no function {ENTRY}: {reason}; is it a module, built with its export macro?"
    )]
    Entry {
        /// Text of dlerror.
        reason: String,
        /// Path that was opened.
        path: String,
    },
    /// It speaks another version of the module interface.
    #[error(
        "{path} was built for version {version} of the module interface, and this manager speaks version {ABI_VERSION}; \
         {}", mend(*.version)
    )]
    Version {
        /// Of the module.
        version: u32,
        /// Path that was opened.
        path: String,
    },
    /// Its descriptor is not acceptable.
    #[error("{path} is not a usable module: {reason}; rebuild it with the SDK of this manager")]
    Descriptor {
        /// What is wrong.
        reason: DescriptorError,
        /// Path that was opened.
        path: String,
    },
}

/// What brings the two versions together.
fn mend(version: u32) -> &'static str {
    if version < ABI_VERSION {
        "rebuild the module with the SDK of this rtsctl"
    } else {
        "upgrade rtsctl on this node, or rebuild the module with the SDK of this rtsctl"
    }
}

/// Versions that are looked for to say which one a module was built for.
const VERSIONS: std::ops::Range<u32> = 0..16;

impl Module {
    /// Opens a module and checks that it holds the type.
    pub fn load(path: &Path, type_name: &str) -> Result<Self, LoadError> {
        let shown = path.display().to_string();
        // SAFETY: initialisers of the library run here. That is what loading a module is for; who may place files
        // in the module paths may run code in this process.
        let library =
            unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map_err(|error| {
                LoadError::Open {
                    reason: chain(&error),
                    path: shown.clone(),
                }
            })?;
        let library = ManuallyDrop::new(library);
        // SAFETY: the ABI fixes the type of the function with this name.
        let entry = unsafe { library.get::<Entry>(ENTRY.as_bytes()) };
        let entry = entry.map_err(|error| match other_version(&library) {
            Some(version) => LoadError::Version {
                version,
                path: shown.clone(),
            },
            None => LoadError::Entry {
                reason: chain(&error),
                path: shown.clone(),
            },
        })?;
        // SAFETY: the ABI lets it be called at any time, and its answer lives as long as the process.
        unsafe { describe(entry(), type_name, &shown) }.map_err(|reason| match reason {
            DescriptorError::Version(version) => LoadError::Version {
                version,
                path: shown,
            },
            reason => LoadError::Descriptor {
                reason,
                path: shown,
            },
        })
    }

    /// What it says of itself.
    pub fn info(&self) -> ModuleInfo {
        let [vendor, category, version, description] = self.texts.clone();
        ModuleInfo {
            type_name: self.type_name.clone(),
            vendor,
            category,
            version,
            description,
            path: self.path.clone(),
            ports: self.port_infos(),
            parameters: self.parameters.clone(),
            facts: self.facts.clone(),
            execution_kind: self.execution.name().to_owned(),
            activity_type: self.activity_type.to_owned(),
            idl: self.idl.clone(),
            max_instances: (self.max_instances > 0).then_some(self.max_instances),
        }
    }

    /// IDL source of the types that are its own.
    pub fn idl(&self) -> &str {
        &self.idl
    }

    /// Its ports as the protocol shows them.
    pub fn port_infos(&self) -> Vec<PortInfo> {
        let direction = |direction| match direction {
            Direction::In => "in",
            Direction::Out => "out",
        };
        self.ports
            .iter()
            .map(|port| PortInfo {
                name: port.name.clone(),
                direction: direction(port.direction).to_owned(),
                data_type: port.data_type.clone(),
            })
            .chain(self.listed.iter().cloned())
            .collect()
    }

    /// True for what stands in for a module.
    pub fn is_stand_in(&self) -> bool {
        matches!(self.code, Code::StandIn(_))
    }
}

/// The version of the interface that a library has an entry function for, when it has none for ours.
fn other_version(library: &Library) -> Option<u32> {
    let stem = ENTRY.trim_end_matches(|c: char| c.is_ascii_digit());
    VERSIONS
        .filter(|version| *version != ABI_VERSION)
        .find(|version| {
            // SAFETY: the address is looked for, and nothing is called.
            unsafe { library.get::<Entry>(format!("{stem}{version}").as_bytes()) }.is_ok()
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_no_library_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("libx.so");
        let missing = Module::load(&path, "X").unwrap_err().to_string();
        assert!(missing.contains("No such file"), "{missing}");
        std::fs::write(&path, "no library").unwrap();
        let error = Module::load(&path, "X").unwrap_err().to_string();
        assert!(
            error.contains("libx.so") && error.contains("ldd"),
            "{error}"
        );
    }
}
