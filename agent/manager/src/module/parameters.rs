//! Parameters of a descriptor: names, defaults, and which values are allowed.

#![allow(unsafe_code)]

use std::collections::BTreeMap;

use rts_manager_api::control::ParameterFacts;
use rts_runtime::abi;
use rts_schemas::check::Limits;

use super::descriptor::{DescriptorError, line, name, text};
use super::list::list;

/// What a descriptor says of parameters, by their name.
#[derive(Default)]
pub(super) struct Parameters {
    pub(super) defaults: BTreeMap<String, String>,
    pub(super) facts: BTreeMap<String, ParameterFacts>,
    pub(super) limits: BTreeMap<String, Limits>,
}

/// Copies them.
///
/// # Safety
/// The list has the length that it claims, and its texts live as long as the process.
pub(super) unsafe fn parameters(module: &abi::Module) -> Result<Parameters, DescriptorError> {
    let mut read = Parameters::default();
    // SAFETY: the caller vouches for the list.
    let items = unsafe { list("parameters", module.parameters, module.parameters_len)? };
    for (index, parameter) in items.iter().enumerate() {
        // SAFETY: the caller vouches for the texts.
        let (name, default, facts) = unsafe {
            let name = name(&format!("the name of parameter {index}"), parameter.name)?;
            let part = |what: &str, part| text(&format!("the {what} of `{name}`"), part);
            let default = part("default", parameter.default)?;
            let facts = ParameterFacts {
                value_type: part("type", parameter.value_type)?,
                unit: line(&format!("the unit of `{name}`"), parameter.unit)?,
                constraint: part("constraint", parameter.constraint)?,
                description: line(
                    &format!("the description of `{name}`"),
                    parameter.description,
                )?,
            };
            (name, default, facts)
        };
        let limits = Limits::read(&facts.value_type, &facts.constraint).map_err(|why| {
            DescriptorError::Constraint(name.clone(), facts.constraint.clone(), why)
        })?;
        if let Some(problem) = limits.problem(&default) {
            return Err(DescriptorError::Default(name, default, problem.reason));
        }
        if facts != ParameterFacts::default() {
            read.facts.insert(name.clone(), facts);
            read.limits.insert(name.clone(), limits);
        }
        if read.defaults.insert(name.clone(), default).is_some() {
            return Err(DescriptorError::Twice("parameter", name));
        }
    }
    Ok(read)
}
