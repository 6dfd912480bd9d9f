//! Composite components: what they share with their members, and who the members are.

use std::collections::HashMap;

use super::{Made, text};
use crate::rtc_conf::setup::Component;
use crate::rts_profile::forms::{self, Participants, TargetComponent};

/// What the types of composite components have in their names, and what the profile calls it.
const KINDS: [(&str, &str); 3] = [
    ("StateShared", "PeriodicStateShared"),
    ("ECShared", "PeriodicECShared"),
    ("Grouping", "Grouping"),
];

impl Made<'_> {
    /// Makes a composite of a component whose type is one, with the members that its configuration names.
    pub(super) fn composite(
        &mut self,
        component: &Component,
        ids: &HashMap<&str, String>,
        form: &mut forms::Component,
    ) {
        let kind = KINDS
            .iter()
            .find(|(part, _)| component.type_name.contains(part));
        let Some((_, kind)) = kind.filter(|_| component.type_name.ends_with("Composite")) else {
            return;
        };
        form.composite_type = text(*kind);
        let conf = &component.conf;
        let active = conf.active.as_deref().unwrap_or("default");
        let members = conf.sets.get(active).and_then(|set| set.get("members"));
        let members = members.map_or("", String::as_str).split(',').map(str::trim);
        for name in members.filter(|name| !name.is_empty()) {
            let Some(member) = self.resolve(name) else {
                let what = format!("the member of `{}`", component.instance);
                self.unknown(component.place.clone(), name, &what);
                continue;
            };
            let id = ids.get(member.instance.as_str());
            form.participants.push(Participants {
                participant: vec![TargetComponent {
                    component_id: id.and_then(|id| text(id.as_str())),
                    instance_name: text(member.instance.as_str()),
                    ..TargetComponent::default()
                }],
                ..Participants::default()
            });
        }
    }
}
