//! The data types of OpenRTM-aist, as our own IDL files.

use super::sources::{Found, Include, Sources};

/// Files, by the name that they have in OpenRTM-aist.
const FILES: [(&str, &str); 3] = [
    (
        "BasicDataType.idl",
        include_str!("../../idl/BasicDataType.idl"),
    ),
    (
        "ExtendedDataTypes.idl",
        include_str!("../../idl/ExtendedDataTypes.idl"),
    ),
    (
        "InterfaceDataTypes.idl",
        include_str!("../../idl/InterfaceDataTypes.idl"),
    ),
];

/// The folder of OpenRTM-aist that `#include <rtm/idl/BasicDataType.idl>` names.
const FOLDER: &str = "rtm/idl/";

/// Gives the files of OpenRTM-aist, by their own name or below `rtm/idl/`, and nothing else.
///
/// ```
/// use rts_schemas::idl;
///
/// let text = b"#include <rtm/idl/BasicDataType.idl>\nmodule Arm { typedef RTC::TimedDoubleSeq Angles; };\n";
/// let unit = idl::read("arm.idl", text, &idl::standard()).unwrap().unit;
/// assert!(unit.find("IDL:RTC/TimedLong:1.0").is_some() && unit.find("Arm::Angles").is_some());
/// ```
pub fn standard() -> Standard {
    Standard
}

/// See [`standard`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Standard;

impl Standard {
    /// The files with their names and texts.
    pub fn files() -> impl Iterator<Item = (&'static str, &'static str)> {
        FILES.into_iter()
    }
}

impl Sources for Standard {
    fn find(&self, include: Include<'_>) -> Result<Option<Found>, String> {
        let name = include.name.strip_prefix(FOLDER).unwrap_or(include.name);
        let found = FILES.into_iter().find(|(known, _)| *known == name);
        Ok(found.map(|(name, text)| Found {
            path: format!("{FOLDER}{name}"),
            bytes: text.as_bytes().to_vec(),
        }))
    }
}
