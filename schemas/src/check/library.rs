//! RTC Profiles that are at hand, found by the id or type of a component.

use std::collections::{BTreeMap, HashMap};

use crate::names;
use crate::rtc_profile::ReadRtcProfile;
use crate::rts_profile::model::Component;
use crate::rts_profile::type_name;
use crate::span::Text;

/// RTC Profiles by the type that they describe. Of several that describe the same, the first one counts.
#[derive(Debug, Default)]
pub struct Library {
    profiles: Vec<ReadRtcProfile>,
    /// By vendor, category, type and version.
    by_id: HashMap<[String; 4], usize>,
    /// By vendor, category and type.
    by_origin: HashMap<[String; 3], usize>,
    by_type: BTreeMap<String, usize>,
}

/// The RTC Profile of a component.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found<'a> {
    pub(super) index: usize,
    pub(super) profile: &'a ReadRtcProfile,
    /// The whole id is the same, its version too.
    pub(super) exact: bool,
}

impl Library {
    /// Adds a profile.
    pub fn add(&mut self, profile: ReadRtcProfile) {
        let index = self.profiles.len();
        let info = profile.profile.basic_info.as_deref();
        let name = info.and_then(|info| info.name.as_ref()).map(Text::trimmed);
        let id = profile.profile.id.as_ref();
        let by_id = id.and_then(|id| names::type_name(&id.value, ""));
        let types = by_id.into_iter().chain(name.map(str::to_owned));
        for kind in types.filter(|kind| !kind.is_empty()) {
            self.by_type.entry(kind).or_insert(index);
        }
        if let Some(id) = id {
            let [vendor, category, kind, version] = fields(&id.value).map(str::to_owned);
            let origin = [vendor.clone(), category.clone(), kind.clone()];
            self.by_origin.entry(origin).or_insert(index);
            let whole = [vendor, category, kind, version];
            self.by_id.entry(whole).or_insert(index);
        }
        self.profiles.push(profile);
    }

    /// How many profiles there are.
    pub fn len(&self) -> usize {
        self.profiles.len()
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.profiles.is_empty()
    }

    /// All profiles, in the order in which they came.
    pub fn profiles(&self) -> &[ReadRtcProfile] {
        &self.profiles
    }

    /// The types that are described, sorted.
    pub(super) fn types(&self) -> impl Iterator<Item = &str> {
        self.by_type.keys().map(String::as_str)
    }

    /// The profile of a component's type: that of its very id, else of its vendor and category, else any.
    pub(super) fn find(&self, component: &Component) -> Option<Found<'_>> {
        let id = component.id.as_ref().map(|id| id.value.as_str());
        self.find_by(id, &type_name(component)?)
    }

    /// The profile of a type, whatever the version; that of this id before others.
    pub fn of_type(&self, id: &str, kind: &str) -> Option<&ReadRtcProfile> {
        Some(self.find_by(Some(id), kind)?.profile)
    }

    fn find_by(&self, id: Option<&str>, kind: &str) -> Option<Found<'_>> {
        let fields = id.map(|id| fields(id).map(str::to_owned));
        let exact = fields.as_ref().and_then(|fields| self.by_id.get(fields));
        let near = || {
            let [vendor, category, kind, _] = fields.clone()?;
            self.by_origin.get(&[vendor, category, kind])
        };
        let index = *exact.or_else(near).or_else(|| self.by_type.get(kind))?;
        Some(Found {
            index,
            profile: self.profiles.get(index)?,
            exact: exact.is_some(),
        })
    }
}

/// Vendor, category, type and version of an id in either form.
fn fields(id: &str) -> [&str; 4] {
    let fields: Vec<&str> = id.split(':').map(str::trim).collect();
    match fields.as_slice() {
        [_, vendor, category, name, version, ..] => [vendor, category, name, version],
        [_, dotted, version] => {
            let mut parts = dotted.rsplitn(3, '.');
            let name = parts.next().unwrap_or_default();
            let category = parts.next().unwrap_or_default();
            [parts.next().unwrap_or_default(), category, name, version]
        }
        _ => ["", "", id.trim(), ""],
    }
}

#[cfg(test)]
mod tests {
    use super::fields;

    #[test]
    fn both_forms_of_an_id_are_the_same() {
        let expected = ["AIST", "example", "Sine", "1.0"];
        assert_eq!(fields("RTC:AIST:example:Sine:1.0"), expected);
        assert_eq!(fields("RTC : AIST.example.Sine : 1.0"), expected);
    }
}
