//! Reading the descriptor of a module with distrust.

#![allow(unsafe_code)]

use std::collections::{BTreeMap, BTreeSet};
use std::mem::{offset_of, size_of};

use rts_runtime::abi::{self, ABI_VERSION};

use super::{Code, Direction, Functions, Module, Port};
use crate::text::{self, TextError};

/// Most ports, and most parameters, of a type.
pub(super) const MAX_ITEMS: usize = 1024;
const MAX_NAME: usize = 256;
const MAX_VALUE: usize = 64 * 1024;

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
        "it was built for version {0} of the module interface, this manager knows version {ABI_VERSION}"
    )]
    Version(u32),
    /// Fewer fields than this version has.
    #[error("its descriptor has {0} bytes instead of {expected}", expected = size_of::<abi::Module>())]
    Size(u32),
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
    #[error("its default rate {0} Hz is not a positive number")]
    Rate(f64),
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
        check_head(module)?;
        let module = &*module;
        let found = name("its type name", module.type_name)?;
        if found != type_name {
            return Err(DescriptorError::Type {
                found,
                expected: type_name.to_owned(),
            });
        }
        if !(module.default_rate.is_finite() && module.default_rate > 0.0) {
            return Err(DescriptorError::Rate(module.default_rate));
        }
        Ok(Module {
            type_name: found,
            path: path.to_owned(),
            ports: ports(module)?,
            listed: Vec::new(),
            parameters: parameters(module)?,
            default_rate: module.default_rate,
            code: Code::Library(Functions {
                create: module.create,
                destroy: module.destroy,
                callback: module.callback,
                configure: module.configure,
            }),
            texts: [
                text("its vendor", module.vendor)?,
                text("its category", module.category)?,
                text("its version", module.version)?,
                text("its description", module.description)?,
            ],
        })
    }
}

/// Checks all that must hold before the descriptor may be seen as a Rust value.
unsafe fn check_head(module: *const abi::Module) -> Result<(), DescriptorError> {
    if module.is_null() {
        return Err(DescriptorError::Null);
    }
    if !module.is_aligned() {
        return Err(DescriptorError::Unaligned(module.addr()));
    }
    let base = module.cast::<u8>();
    // SAFETY: version and size are the first fields of every version of the descriptor.
    let (version, size) = unsafe {
        (
            base.cast::<u32>().read_unaligned(),
            base.add(offset_of!(abi::Module, size))
                .cast::<u32>()
                .read_unaligned(),
        )
    };
    if version != ABI_VERSION {
        return Err(DescriptorError::Version(version));
    }
    if (size as usize) < size_of::<abi::Module>() {
        return Err(DescriptorError::Size(size));
    }
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
    Ok(())
}

unsafe fn ports(module: &abi::Module) -> Result<Vec<Port>, DescriptorError> {
    // SAFETY: the caller vouches for the list.
    let list = unsafe { list("ports", module.ports, module.ports_len)? };
    let mut names = BTreeSet::new();
    let mut ports = Vec::with_capacity(list.len());
    for (index, port) in list.iter().enumerate() {
        // SAFETY: texts of a descriptor live as long as the process.
        let (name, data_type) = unsafe {
            let name = name(&format!("the name of port {index}"), port.name)?;
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

unsafe fn parameters(module: &abi::Module) -> Result<BTreeMap<String, String>, DescriptorError> {
    // SAFETY: the caller vouches for the list.
    let list = unsafe { list("parameters", module.parameters, module.parameters_len)? };
    let mut parameters = BTreeMap::new();
    for (index, parameter) in list.iter().enumerate() {
        // SAFETY: texts of a descriptor live as long as the process.
        let (name, default) = unsafe {
            let name = name(&format!("the name of parameter {index}"), parameter.name)?;
            let default = text(&format!("the default of `{name}`"), parameter.default)?;
            (name, default)
        };
        if parameters.insert(name.clone(), default).is_some() {
            return Err(DescriptorError::Twice("parameter", name));
        }
    }
    Ok(parameters)
}

unsafe fn list<'a, T>(
    what: &'static str,
    items: *const T,
    length: usize,
) -> Result<&'a [T], DescriptorError> {
    if length == 0 {
        return Ok(&[]);
    }
    if length > MAX_ITEMS || items.is_null() || !items.is_aligned() {
        return Err(DescriptorError::List(what, length));
    }
    // SAFETY: bounded, not null, aligned; the caller vouches for the length.
    Ok(unsafe { std::slice::from_raw_parts(items, length) })
}

unsafe fn name(what: &str, text: abi::Text) -> Result<String, DescriptorError> {
    // SAFETY: the caller vouches for the text.
    let name = unsafe { text::read(text, MAX_NAME) }
        .map_err(|e| DescriptorError::Text(what.to_owned(), e))?;
    if name.is_empty() {
        return Err(DescriptorError::Empty(what.to_owned()));
    }
    Ok(name)
}

unsafe fn text(what: &str, text: abi::Text) -> Result<String, DescriptorError> {
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
            name: lend(name),
            type_id: lend("IDL:RTC/TimedLong:1.0"),
            direction,
        }
    }

    /// A good descriptor, changed by `change`, and what comes of it.
    fn described(
        change: impl FnOnce(&mut abi::Module, &mut Vec<abi::Port>),
    ) -> Result<Module, DescriptorError> {
        let mut ports: Vec<_> = PORTS.map(port).into();
        let parameters = [abi::Parameter {
            name: lend("gain"),
            default: lend("1.0"),
        }];
        let mut module = abi::Module {
            abi_version: ABI_VERSION,
            size: size_of::<abi::Module>() as u32,
            type_name: lend("Filter"),
            vendor: lend("v"),
            category: lend("c"),
            version: lend("1"),
            description: lend(""),
            default_rate: 100.0,
            ports: ports.as_ptr(),
            ports_len: ports.len(),
            parameters: parameters.as_ptr(),
            parameters_len: 1,
            create,
            destroy,
            callback,
            configure,
        };
        change(&mut module, &mut ports);
        // SAFETY: lists and texts live until the end of this function.
        unsafe { describe(&module, "Filter", "libfilter.so") }
    }

    fn refused(change: impl FnOnce(&mut abi::Module, &mut Vec<abi::Port>)) -> String {
        described(change).unwrap_err().to_string()
    }

    #[test]
    fn a_good_descriptor_is_copied() {
        let module = described(|_, _| ()).unwrap();
        let info = module.info();
        assert_eq!(info.ports[1].name, "out");
        assert_eq!(info.ports[1].direction, "out");
        assert_eq!(info.parameters["gain"], "1.0");
    }

    #[test]
    fn each_fault_is_named() {
        assert_eq!(
            refused(|m, _| m.abi_version = 7),
            "it was built for version 7 of the module interface, this manager knows version 0"
        );
        assert!(refused(|m, _| m.size = 16).contains("16 bytes"));
        assert!(refused(|m, _| m.default_rate = f64::NAN).contains("NaN"));
        assert!(refused(|m, _| m.ports_len = 1025).contains("1025 ports"));
        assert!(refused(|m, _| m.ports = std::ptr::null()).contains("null pointer"));
        assert!(refused(|m, _| m.parameters = std::ptr::null()).contains("1 parameters"));
        assert!(refused(|_, p| p[1].direction = 9).contains("unknown direction 9"));
        assert_eq!(
            refused(|_, p| p[1].name = lend("in")),
            "port `in` is there twice"
        );
        assert_eq!(
            refused(|_, p| p[0].name = lend("")),
            "the name of port 0 is empty"
        );
        assert!(refused(|_, p| p[0].name.len = 1 << 40).contains("longer than the limit"));
        assert!(refused(|m, _| m.type_name.data = std::ptr::null()).contains("null pointer"));
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
            describe(base.cast(), "Filter", "x")
        };
        assert_eq!(error.unwrap_err(), DescriptorError::Function("create"));
    }
}
