//! Mirror → the one model. What cannot be understood is left out here and reported by the checks.

mod component;
mod composite;
mod connector;
mod managers;
mod order;
mod places;

use super::ReadProfile;
use super::model::property_value;
use crate::diagnostic::{Finding, Report};
use crate::names;
use crate::span::Text;
use crate::system::SystemSpec;

pub(crate) use component::{execution_kind, is_pseudo_set, parse_rate, type_name};
pub(crate) use connector::{
    CHOICES, data_type_of, direction_of, free_name, is_reversed, normal_data_type, properties,
    unused_name,
};
pub(crate) use order::{parse_timing, parse_whole};
pub use places::Places;
pub(crate) use places::{escaped, places, unescaped};

/// The property that names a system or connector otherwise than its id or ends would.
pub(crate) const NAME_KEY: &str = "rtsctl.name";

/// The property that says the type of a component whose id does not.
pub(crate) const TYPE_KEY: &str = "rtsctl.type";

/// What the caller knows besides the file.
#[derive(Debug, Clone, Copy, Default)]
pub struct LowerOptions<'a> {
    /// A name that was given by hand; it wins.
    pub name: Option<&'a str>,
    /// Stem of the file's name, for profiles that nobody named.
    pub file_stem: Option<&'a str>,
}

/// Lowers a profile. `None` when the system has no usable name; then the report says so.
///
/// Components without instance name or type, and connectors without both ends, are left out: the checks report them
/// as errors, so that such a system is never deployed in part.
pub fn lower(read: &ReadProfile, options: &LowerOptions<'_>) -> (Option<SystemSpec>, Report) {
    let (spec, report) = lower_any(read, options);
    (Some(spec).filter(|spec| !spec.name.is_empty()), report)
}

/// The same; a system without a usable name has none, so that the rest of it can be checked.
pub(crate) fn lower_any(read: &ReadProfile, options: &LowerOptions<'_>) -> (SystemSpec, Report) {
    let mut report = Report::default();
    let name = name(read, options, &mut report);
    let mut components = component::components(read, &mut report);
    let composites = composite::composites(read);
    crate::composite::settle(&mut components, &composites);
    let connectors = connector::connectors(read, &mut report);
    let spec = SystemSpec {
        name: name.unwrap_or_default(),
        full_id: read
            .profile
            .id
            .as_ref()
            .map_or_else(String::new, |id| id.trimmed().to_owned()),
        components,
        orders: order::orders(read, &composites),
        composites,
        connectors,
    };
    (spec, report)
}

fn name(read: &ReadProfile, options: &LowerOptions<'_>, report: &mut Report) -> Option<String> {
    if let Some(given) = options.name {
        if names::is_dns_label(given) {
            return Some(given.to_owned());
        }
        let mut help = "a name has 1 to 63 of `a-z`, `0-9` and `-`".to_owned();
        if let Some(near) = names::dns_label(given) {
            help.push_str(&format!("; for example `--name {near}`"));
        }
        report.push(
            Finding::error("bad-system-name", format!("`{given}` cannot name a system")).help(help),
        );
        return None;
    }
    if let Some(own) = property_value(&read.profile.properties, NAME_KEY) {
        return own_name(read, own, report);
    }
    let id = read.profile.id.as_ref();
    let found = names::system_name(id.map_or("", |id| &id.value), options.file_stem);
    if found.is_none() {
        let message = match id {
            Some(id) => format!("the id `{}` gives the system no usable name", id.trimmed()),
            None => "the profile has no id to name the system by".to_owned(),
        };
        report.push(
            Finding::error("no-system-name", message)
                .at(read.place(id.map_or(read.profile.span, |id| id.span)))
                .help("name it with `--name NAME`"),
        );
    }
    found
}

/// The name that the profile gives its system beside its id.
fn own_name(read: &ReadProfile, own: &Text, report: &mut Report) -> Option<String> {
    let name = own.trimmed();
    if names::is_dns_label(name) {
        return Some(name.to_owned());
    }
    let message = format!("`{name}` cannot name a system");
    report.push(
        Finding::error("bad-system-name", message)
            .at(read.place(own.span))
            .help("a name has 1 to 63 of `a-z`, `0-9` and `-`"),
    );
    None
}
