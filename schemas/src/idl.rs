//! OMG IDL: data types of ports and interfaces of service ports (OMG IDL 4.2, the part that CORBA 2.3 and OpenRTM use).
//!
//! What is accepted here, `omniidl` of omniORB accepts too. Value types, native and fixed-point types are not read.

mod decode;
mod findings;
mod lexer;
mod limits;
mod literal;
pub mod model;
mod names;
mod preprocessor;
mod reader;
mod sources;
mod token;

pub use limits::FILE as SIZE_LIMIT;
pub use model::{
    Attribute, Constant, ConstantValue, Definition, Direction, EnumType, Exception, Interface,
    Kind, Label, Member, Operation, Parameter, Primitive, StructType, Type, Typedef, Union,
    UnionCase, Unit,
};
pub use sources::{Found, Include, NoSources, Sources};

use self::reader::Reader;
use crate::diagnostic::{Finding, Report};

/// What files say.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Read {
    /// All of their definitions.
    pub unit: Unit,
    /// Warnings.
    pub findings: Report,
}

/// Reads a file, and through `sources` what it includes.
///
/// # Errors
/// Every mistake that was found, when there is one.
pub fn read(name: &str, bytes: &[u8], sources: &dyn Sources) -> Result<Read, Report> {
    read_all(&[(name, bytes)], sources)
}

/// Reads several files, one after the other, as one: what the first includes and guards is not read again.
///
/// # Errors
/// Every mistake that was found, when there is one.
pub fn read_all(files: &[(&str, &[u8])], sources: &dyn Sources) -> Result<Read, Report> {
    let mut reader = Reader::new(sources);
    let mut report = Report::default();
    for (name, bytes) in files {
        match decode::decode(name, bytes) {
            Ok(text) => {
                if reader.input.open(name, text) {
                    reader.file();
                } else {
                    let message =
                        format!("the files together have more than {} bytes", limits::BYTES);
                    report.push(Finding::error("too-large", message).help("read fewer at once"));
                }
            }
            Err(finding) => report.push(*finding),
        }
    }
    let (unit, findings) = reader.finish();
    report.extend(findings.report());
    match report.has_errors() {
        true => Err(report),
        false => Ok(Read {
            unit,
            findings: report,
        }),
    }
}
