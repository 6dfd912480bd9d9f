//! Reading the descriptor of a module with distrust.

#![allow(unsafe_code)]

use std::collections::BTreeSet;
use std::mem::offset_of;

use rts_runtime::abi::{self, ABI_VERSION};
use rts_runtime::sized::{self, Misfit, Sized32};

use super::list::{MAX_ITEMS, list};
use super::parameters::parameters;
use super::{Code, Direction, Execution, Functions, Module, Port};
use crate::text::{self, TextError};
use rts_manager_api::control::PortInfo;
use rts_schemas::names::{is_hidden, name_fault};
use rts_schemas::system::rate_problem;

const MAX_NAME: usize = 256;
const MAX_VALUE: usize = 64 * 1024;
const MAX_IDL: usize = 1024 * 1024;

/// What is wrong with a descriptor.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum DescriptorError {
    /// The entry function returned no descriptor.
    #[error("its descriptor is a null pointer")]
    Null,
    /// Not an address that a descriptor can have.
    #[error("its descriptor is at the address {0:#x}, which is not aligned")]
    Unaligned(usize),
    /// Another version of the ABI.
    #[error(
        "it was built for version {0} of the module interface, this manager speaks version {ABI_VERSION}"
    )]
    Version(u32),
    /// Fewer fields than this version always had.
    #[error("its descriptor has {0} bytes, which is no size of this version: it has {least} at least",
        least = abi::Module::V1_SIZE)]
    Size(usize),
    /// An item of a list is shorter than this version has it, or its size is none.
    #[error("one of its {0} has {1} bytes, which is no size of this version")]
    ItemSize(&'static str, usize),
    /// A constraint cannot be read.
    #[error("the constraint `{1}` of its parameter `{0}` cannot be read: {2}")]
    Constraint(String, String, String),
    /// A default is not allowed by the module itself.
    #[error("its parameter `{0}` has the default `{1}`, which it refuses itself: {2}")]
    Default(String, String, String),
    /// A number that means nothing.
    #[error("its {0} is {1}, which this version does not know")]
    Number(&'static str, u32),
    /// A function is missing.
    #[error("its function `{0}` is a null pointer")]
    Function(&'static str),
    /// A text cannot be read.
    #[error("{0}: {1}")]
    Text(String, TextError),
    /// A name is empty.
    #[error("{0} is empty")]
    Empty(String),
    /// A name is there twice.
    #[error("{0} `{1}` is there twice")]
    Twice(&'static str, String),
    /// Too many items, or items without an address.
    #[error(
        "it has {1} {0}, of which at most {MAX_ITEMS} are allowed, or their list is a null pointer"
    )]
    List(&'static str, usize),
    /// Neither in nor out.
    #[error("its port `{0}` has the unknown direction {1}")]
    Direction(String, u32),
    /// Not a rate.
    #[error("its default rate {0:?} Hz is refused: {1}")]
    Rate(f64, String),
    /// Not a name, shown with what is hidden in it.
    #[error("{0} is \"{1}\", which is refused: {2}")]
    Name(String, String, &'static str),
    /// Callbacks that are none.
    #[error("its actions are {0:#x}, and this version knows no more than {known:#x}", known = abi::ALL_ACTIONS)]
    Actions(u32),
    /// Not the type that was asked for.
    #[error("it holds the type `{found}`, not `{expected}`")]
    Type {
        /// In its descriptor.
        found: String,
        /// In the request.
        expected: String,
    },
}

/// Copies a descriptor after checking each part of it.
///
/// # Safety
/// `module` is null or points to a descriptor whose lists have the lengths that they claim.
pub unsafe fn describe(
    module: *const abi::Module,
    type_name: &str,
    path: &str,
) -> Result<Module, DescriptorError> {
    // SAFETY: as the caller says; each step reads no more than the step before has proven.
    unsafe {
        let module = &head(module)?;
        let found = name("its type name", module.type_name)?;
        if found != type_name {
            return Err(DescriptorError::Type {
                found,
                expected: type_name.to_owned(),
            });
        }
        if let Some(problem) = rate_problem(module.default_rate) {
            return Err(DescriptorError::Rate(module.default_rate, problem));
        }
        if module.actions & !abi::ALL_ACTIONS != 0 {
            return Err(DescriptorError::Actions(module.actions));
        }
        let parameters = parameters(module)?;
        Ok(Module {
            type_name: found,
            path: path.to_owned(),
            ports: ports(module)?,
            listed: services(module)?,
            parameters: parameters.defaults,
            facts: parameters.facts,
            limits: parameters.limits,
            execution: execution(module.execution_kind)?,
            activity_type: activity(module.activity_type)?,
            max_instances: module.max_instances,
            actions: module.actions,
            idl: text::read(module.idl, MAX_IDL)
                .map_err(|e| DescriptorError::Text("its IDL".to_owned(), e))?,
            default_rate: module.default_rate,
            code: Code::Library(Functions {
                create: module.create,
                destroy: module.destroy,
                callback: module.callback,
                configure: module.configure,
            }),
            texts: [
                line("its vendor", module.vendor)?,
                line("its category", module.category)?,
                line("its version", module.version)?,
                line("its description", module.description)?,
            ],
        })
    }
}

fn execution(number: u32) -> Result<Execution, DescriptorError> {
    match number {
        abi::EXECUTION_PERIODIC => Ok(Execution::Periodic),
        abi::EXECUTION_EVENT_DRIVEN => Ok(Execution::EventDriven),
        abi::EXECUTION_EXTERNAL => Ok(Execution::External),
        other => Err(DescriptorError::Number("execution kind", other)),
    }
}

fn activity(number: u32) -> Result<&'static str, DescriptorError> {
    match number {
        abi::ACTIVITY_PERIODIC => Ok("PERIODIC"),
        abi::ACTIVITY_SPORADIC => Ok("SPORADIC"),
        abi::ACTIVITY_EVENT_DRIVEN => Ok("EVENT_DRIVEN"),
        other => Err(DescriptorError::Number("activity type", other)),
    }
}

/// Copies the descriptor itself, after checking all that must hold before it may be seen as a Rust value.
unsafe fn head(module: *const abi::Module) -> Result<abi::Module, DescriptorError> {
    let misfit = |misfit| match misfit {
        Misfit::Null => DescriptorError::Null,
        Misfit::Unaligned(address) => DescriptorError::Unaligned(address),
        Misfit::Version(version) => DescriptorError::Version(version),
        Misfit::Size(size) => DescriptorError::Size(size),
    };
    let base = module.cast::<u8>();
    // SAFETY: the caller vouches for the beginning.
    unsafe { sized::size(module) }.map_err(misfit)?;
    let functions = [
        ("create", offset_of!(abi::Module, create)),
        ("destroy", offset_of!(abi::Module, destroy)),
        ("callback", offset_of!(abi::Module, callback)),
        ("configure", offset_of!(abi::Module, configure)),
    ];
    for (name, offset) in functions {
        // SAFETY: inside the size that was just checked. A null function may not even be copied as a Rust value.
        if unsafe { base.add(offset).cast::<usize>().read_unaligned() } == 0 {
            return Err(DescriptorError::Function(name));
        }
    }
    // SAFETY: as long as it says, by the caller's word, and all that may not be zero is not.
    unsafe { sized::read(module) }.map_err(misfit)
}

unsafe fn ports(module: &abi::Module) -> Result<Vec<Port>, DescriptorError> {
    // SAFETY: the caller vouches for the list.
    let list = unsafe { list("ports", module.ports, module.ports_len)? };
    let mut names = BTreeSet::new();
    let mut ports = Vec::with_capacity(list.len());
    for (index, port) in list.iter().enumerate() {
        // SAFETY: texts of a descriptor live as long as the process.
        let (name, data_type) = unsafe {
            let name = port_name(&format!("the name of port {index}"), port.name)?;
            let data_type = self::name(&format!("the type of port `{name}`"), port.type_id)?;
            (name, data_type)
        };
        let direction = match port.direction {
            abi::PORT_IN => Direction::In,
            abi::PORT_OUT => Direction::Out,
            other => return Err(DescriptorError::Direction(name, other)),
        };
        if !names.insert(name.clone()) {
            return Err(DescriptorError::Twice("port", name));
        }
        ports.push(Port {
            name,
            data_type,
            direction,
        });
    }
    Ok(ports)
}

/// Service ports, which are shown and can be connected to nothing.
unsafe fn services(module: &abi::Module) -> Result<Vec<PortInfo>, DescriptorError> {
    // SAFETY: the caller vouches for the list.
    let list = unsafe { list("services", module.services, module.services_len)? };
    let mut ports: Vec<PortInfo> = Vec::new();
    for (index, service) in list.iter().enumerate() {
        // SAFETY: texts of a descriptor live as long as the process.
        let (port, interface) = unsafe {
            let port = port_name(&format!("the port of service {index}"), service.port)?;
            let interface = name(
                &format!("the interface of service port `{port}`"),
                service.interface_id,
            )?;
            text(&format!("the interface name of `{port}`"), service.name)?;
            (port, interface)
        };
        if !matches!(
            service.polarity,
            abi::SERVICE_PROVIDED | abi::SERVICE_REQUIRED
        ) {
            return Err(DescriptorError::Direction(port, service.polarity));
        }
        match ports.iter_mut().find(|known| known.name == port) {
            Some(known) => known.data_type = format!("{}, {interface}", known.data_type),
            None => ports.push(PortInfo {
                name: port,
                direction: "service".to_owned(),
                data_type: interface,
            }),
        }
    }
    Ok(ports)
}

/// Copies a name.
///
/// # Safety
/// As [`text::read`].
pub(super) unsafe fn name(what: &str, text: abi::Text) -> Result<String, DescriptorError> {
    // SAFETY: the caller vouches for the text.
    let name = unsafe { text::read(text, MAX_NAME) }
        .map_err(|e| DescriptorError::Text(what.to_owned(), e))?;
    if name.is_empty() {
        return Err(DescriptorError::Empty(what.to_owned()));
    }
    match name.chars().any(is_hidden) {
        true => Err(refused(what, &name, "it has a control character")),
        false => Ok(name),
    }
}

/// Copies the name of a port, which `Instance.port` must be able to name.
///
/// # Safety
/// As [`text::read`].
unsafe fn port_name(what: &str, text: abi::Text) -> Result<String, DescriptorError> {
    // SAFETY: the caller vouches for the text.
    let name = unsafe { name(what, text) }?;
    let fault = match name_fault(&name) {
        None if name.contains('.') => Some("it has a `.`"),
        None if name.trim() != name => Some("it has blanks at an end"),
        fault => fault,
    };
    fault.map_or(Ok(()), |fault| Err(refused(what, &name, fault)))?;
    Ok(name)
}

/// A name that is none. What it is made of must not come to a terminal as it is.
fn refused(what: &str, name: &str, fault: &'static str) -> DescriptorError {
    DescriptorError::Name(what.to_owned(), name.escape_debug().to_string(), fault)
}

/// Copies a text for people.
///
/// # Safety
/// As [`text::read`].
pub(super) unsafe fn line(what: &str, text: abi::Text) -> Result<String, DescriptorError> {
    // SAFETY: the caller vouches for the text.
    unsafe { self::text(what, text) }.map(|text| text::one_line(&text))
}

/// Copies a text.
///
/// # Safety
/// As [`text::read`].
pub(super) unsafe fn text(what: &str, text: abi::Text) -> Result<String, DescriptorError> {
    // SAFETY: the caller vouches for the text.
    unsafe { text::read(text, MAX_VALUE) }.map_err(|e| DescriptorError::Text(what.to_owned(), e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::lend;
    use std::ffi::c_void;

    unsafe extern "C" fn create(_: *const abi::Host, _: *mut *mut c_void) -> i32 {
        0
    }
    unsafe extern "C" fn destroy(_: *mut c_void) {}
    unsafe extern "C" fn callback(_: *mut c_void, _: u32) -> i32 {
        0
    }
    unsafe extern "C" fn configure(_: *mut c_void, _: abi::Text, _: abi::Text) -> i32 {
        0
    }

    const PORTS: [(&str, u32); 2] = [("in", abi::PORT_IN), ("out", abi::PORT_OUT)];

    fn port((name, direction): (&'static str, u32)) -> abi::Port {
        abi::Port {
            abi_version: ABI_VERSION,
            size: size_of::<abi::Port>() as u32,
            name: lend(name),
            type_id: lend("IDL:RTC/TimedLong:1.0"),
            direction,
            reserved: 0,
        }
    }

    fn parameter() -> abi::Parameter {
        abi::Parameter {
            abi_version: ABI_VERSION,
            size: size_of::<abi::Parameter>() as u32,
            name: lend("gain"),
            default: lend("1.0"),
            value_type: lend("double"),
            unit: lend("1"),
            constraint: lend("0<x<=10"),
            description: lend("factor"),
        }
    }

    fn service(interface_id: &'static str) -> abi::Service {
        abi::Service {
            abi_version: ABI_VERSION,
            size: size_of::<abi::Service>() as u32,
            port: lend("arm"),
            name: lend("a"),
            interface_id: lend(interface_id),
            polarity: abi::SERVICE_PROVIDED,
            reserved: 0,
        }
    }

    /// The lists of a descriptor.
    struct Lists {
        ports: Vec<abi::Port>,
        parameters: Vec<abi::Parameter>,
        services: Vec<abi::Service>,
    }

    /// A good descriptor, changed by `change`, and what comes of it.
    fn described(
        change: impl FnOnce(&mut abi::Module, &mut Lists),
    ) -> Result<Module, DescriptorError> {
        let mut lists = Lists {
            ports: PORTS.map(port).into(),
            parameters: vec![parameter()],
            services: vec![service("IDL:A:1.0"), service("IDL:B:1.0")],
        };
        let mut module = abi::Module {
            abi_version: ABI_VERSION,
            size: size_of::<abi::Module>() as u32,
            type_name: lend("Filter"),
            vendor: lend("v"),
            category: lend("c"),
            version: lend("1"),
            description: lend(""),
            idl: lend(""),
            default_rate: 100.0,
            execution_kind: abi::EXECUTION_EVENT_DRIVEN,
            activity_type: abi::ACTIVITY_SPORADIC,
            max_instances: 2,
            actions: abi::ALL_ACTIONS,
            ports: lists.ports.as_ptr(),
            ports_len: lists.ports.len(),
            parameters: lists.parameters.as_ptr(),
            parameters_len: lists.parameters.len(),
            services: lists.services.as_ptr(),
            services_len: lists.services.len(),
            create,
            destroy,
            callback,
            configure,
        };
        change(&mut module, &mut lists);
        // SAFETY: lists and texts live until the end of this function.
        unsafe { describe(&module, "Filter", "libfilter.so") }
    }

    fn refused(change: impl FnOnce(&mut abi::Module, &mut Lists)) -> String {
        described(change).unwrap_err().to_string()
    }

    #[test]
    fn a_good_descriptor_is_copied() {
        let module = described(|_, _| ()).unwrap();
        let info = module.info();
        assert_eq!(info.ports[1].name, "out");
        assert_eq!(info.ports[1].direction, "out");
        assert_eq!(info.parameters["gain"], "1.0");
        let gain = &info.facts["gain"];
        let said = [&gain.value_type, &gain.unit, &gain.constraint];
        assert_eq!(said, ["double", "1", "0<x<=10"]);
        assert_eq!(info.execution_kind, "eventDriven");
        assert_eq!(info.activity_type, "SPORADIC");
        assert_eq!(info.max_instances, Some(2));
        let arm = PortInfo {
            name: "arm".to_owned(),
            direction: "service".to_owned(),
            data_type: "IDL:A:1.0, IDL:B:1.0".to_owned(),
        };
        assert_eq!(info.ports[2..], [arm]);
    }

    /// A port of a later SDK, which has appended a field.
    #[repr(C)]
    struct Longer {
        port: abi::Port,
        appended: u64,
    }

    #[test]
    fn what_a_later_sdk_appended_is_passed_over() {
        let size = size_of::<Longer>() as u32;
        let longer = PORTS.map(|it| Longer {
            port: abi::Port { size, ..port(it) },
            appended: u64::MAX,
        });
        let module = described(|m, _| {
            m.size += 64;
            m.ports = longer.as_ptr().cast();
        });
        let names: Vec<_> = module.unwrap().ports.into_iter().map(|p| p.name).collect();
        assert_eq!(names, ["in", "out"]);
        assert!(refused(|_, l| l.ports[0].size -= 8).contains("one of its ports has 40 bytes"));
        assert!(refused(|_, l| l.ports[1].size += 8).contains("one of its ports has 56 bytes"));
        assert!(refused(|_, l| l.ports[0].size += 3).contains("51 bytes"));
        assert!(refused(|_, l| l.ports[1].abi_version = 2).contains("for version 2"));
    }

    #[test]
    fn each_fault_is_named() {
        assert_eq!(
            refused(|m, _| m.abi_version = 7),
            "it was built for version 7 of the module interface, this manager speaks version 1"
        );
        assert!(refused(|m, _| m.size = 16).contains("16 bytes, which is no size"));
        assert!(refused(|m, _| m.size = 4100).contains("4100 bytes"));
        assert!(refused(|m, _| m.default_rate = f64::NAN).contains("NaN"));
        assert_eq!(
            refused(|m, _| m.default_rate = 1e-200),
            "its default rate 1e-200 Hz is refused: a rate is a number of hertz from 0.001 to 1000000"
        );
        assert_eq!(
            refused(|m, _| m.actions = u32::MAX),
            "its actions are 0xffffffff, and this version knows no more than 0x1fff"
        );
        for (name, fault) in [
            ("in.x\n\u{1b}[31m", r"in.x\n\u{1b}[31m"),
            ("in\u{202e}", r"in\u{202e}"),
        ] {
            assert_eq!(
                refused(|_, l| l.ports[0].name = lend(name)),
                format!(
                    "the name of port 0 is \"{fault}\", which is refused: it has a control character"
                )
            );
        }
        for (name, fault) in [
            ("in/../out", "it has a `/`"),
            ("in.x", "it has a `.`"),
            (" in", "it has blanks at an end"),
            (" ", "it is empty"),
        ] {
            assert_eq!(
                refused(|_, l| l.services[0].port = lend(name)),
                format!("the port of service 0 is \"{name}\", which is refused: {fault}")
            );
        }
        assert!(
            refused(|_, l| l.parameters[0].name = lend("a\rb")).contains(r#""a\rb", which is"#)
        );
        assert!(
            refused(|_, l| l.ports[0].type_id = lend("IDL:\n")).contains("the type of port `in`")
        );
        assert!(refused(|m, _| m.ports_len = 1025).contains("1025 ports"));
        assert!(refused(|m, _| m.ports = std::ptr::null()).contains("null pointer"));
        assert!(refused(|m, _| m.parameters = std::ptr::null()).contains("1 parameters"));
        assert!(refused(|_, l| l.ports[1].direction = 9).contains("unknown direction 9"));
        assert_eq!(
            refused(|_, l| l.ports[1].name = lend("in")),
            "port `in` is there twice"
        );
        assert_eq!(
            refused(|_, l| l.ports[0].name = lend("")),
            "the name of port 0 is empty"
        );
        assert!(refused(|_, l| l.ports[0].name.len = 1 << 40).contains("longer than the limit"));
        assert!(refused(|m, _| m.type_name.data = std::ptr::null()).contains("null pointer"));
        assert!(refused(|m, _| m.execution_kind = 3).contains("execution kind is 3"));
        assert!(refused(|m, _| m.activity_type = 9).contains("activity type is 9"));
        assert!(refused(|_, l| l.services[1].polarity = 2).contains("unknown direction 2"));
        assert_eq!(
            refused(|_, l| l.parameters[0].default = lend("11")),
            "its parameter `gain` has the default `11`, which it refuses itself: allowed: 0 < x <= 10"
        );
        assert_eq!(
            refused(|_, l| l.parameters[0].constraint = lend("(a")),
            "the constraint `(a` of its parameter `gain` cannot be read: `(` is never closed"
        );
        assert_eq!(
            refused(|m, _| m.type_name = lend("Other")),
            "it holds the type `Other`, not `Filter`"
        );
    }

    #[test]
    fn a_null_descriptor_or_function_is_refused() {
        // SAFETY: null is what is being tested.
        let error = unsafe { describe(std::ptr::null(), "Filter", "x") }.unwrap_err();
        assert_eq!(error, DescriptorError::Null);

        // SAFETY: only the address is looked at.
        let error = unsafe { describe(std::ptr::without_provenance(0x1001), "Filter", "x") };
        assert_eq!(error.unwrap_err(), DescriptorError::Unaligned(0x1001));

        let mut bytes = [0_u64; size_of::<abi::Module>() / 8];
        let base = bytes.as_mut_ptr().cast::<u32>();
        // SAFETY: inside `bytes`, which is as large and as aligned as a descriptor.
        let error = unsafe {
            base.byte_add(offset_of!(abi::Module, size))
                .write(size_of::<abi::Module>() as u32);
            base.write(ABI_VERSION);
            describe(base.cast(), "Filter", "x")
        };
        assert_eq!(error.unwrap_err(), DescriptorError::Function("create"));
    }
}
