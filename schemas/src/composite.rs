//! Composite components: which components they stand for, and how these are run because of them. Pure.

use std::collections::{BTreeMap, BTreeSet};

use crate::system::{ComponentSpec, CompositeSpec, SystemSpec};

/// Between the places of two members, so that an overlay can put a component between them.
const STEP: i32 = 10;

/// The composites of a system, by their names.
pub struct Composites<'a>(BTreeMap<&'a str, &'a CompositeSpec>);

impl<'a> Composites<'a> {
    /// Of a system.
    pub fn of(composites: &'a [CompositeSpec]) -> Self {
        let all = composites.iter();
        Self(all.map(|one| (one.instance.as_str(), one)).collect())
    }

    /// True for the name of one.
    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// The components that a name stands for, in the order of the members: those of a composite, through the composites in
    /// it, else itself. Each once.
    pub fn leaves(&self, name: &'a str) -> Vec<&'a str> {
        let (mut found, mut seen) = (Vec::new(), BTreeSet::new());
        self.walk(name, &mut seen, &mut found);
        found
    }

    fn walk(&self, name: &'a str, seen: &mut BTreeSet<&'a str>, found: &mut Vec<&'a str>) {
        if !seen.insert(name) {
            return;
        }
        match self.0.get(name) {
            None => found.push(name),
            Some(composite) => {
                for member in &composite.members {
                    self.walk(member, seen, found);
                }
            }
        }
    }

    /// Composites that contain themselves, each with the way from itself to itself.
    pub fn cycles(&self) -> Vec<Vec<&'a str>> {
        let all = self.0.keys();
        all.filter_map(|name| {
            let mut way = vec![*name];
            self.way_back(name, name, &mut way, &mut BTreeSet::new())
                .then_some(way)
        })
        .collect()
    }

    fn way_back(
        &self,
        from: &'a str,
        to: &str,
        way: &mut Vec<&'a str>,
        seen: &mut BTreeSet<&'a str>,
    ) -> bool {
        let members = self.0.get(from).map(|composite| &composite.members);
        for member in members.into_iter().flatten() {
            if member == to {
                return true;
            }
            if self.has(member) && seen.insert(member) {
                way.push(member);
                if self.way_back(member, to, way, seen) {
                    return true;
                }
                way.pop();
            }
        }
        false
    }
}

/// Puts the members of composites that share an execution context on that of the outermost one, in their order; those of
/// one that shares its state know so.
pub fn settle(components: &mut [ComponentSpec], composites: &[CompositeSpec]) {
    let all = Composites::of(composites);
    let inside = |which: fn(&CompositeSpec) -> bool| -> BTreeSet<&str> {
        let sharing = composites.iter().filter(|composite| which(composite));
        let members = sharing.flat_map(|composite| &composite.members);
        members
            .flat_map(|member| {
                let mut found = BTreeSet::new();
                all.within(member, &mut found);
                found
            })
            .collect()
    };
    let (in_context, in_state) = (
        inside(|composite| composite.kind.shares_context()),
        inside(|composite| composite.kind.shares_state()),
    );
    let index: BTreeMap<String, usize> = components
        .iter()
        .enumerate()
        .map(|(index, component)| (component.instance.clone(), index))
        .collect();
    for composite in composites {
        let name = composite.instance.as_str();
        let shares = composite.kind.shares_context() && !in_context.contains(name);
        let one_state = composite.kind.shares_state() && !in_state.contains(name);
        let mut order = 0;
        for leaf in all.leaves(name) {
            let Some(component) = index.get(leaf).and_then(|at| components.get_mut(*at)) else {
                continue;
            };
            let context = &mut component.execution_context;
            if shares {
                order += STEP;
                context.name = Some(name.to_owned());
                context.order = order;
                context.kind = composite.execution_context.kind;
                context.rate = composite.execution_context.rate;
            }
            if one_state {
                context.shared_state = Some(name.to_owned());
            }
        }
    }
}

impl<'a> Composites<'a> {
    /// A name and, of a composite, all names within it.
    fn within(&self, name: &'a str, found: &mut BTreeSet<&'a str>) {
        if !found.insert(name) {
            return;
        }
        let members = self.0.get(name).map(|composite| &composite.members);
        for member in members.into_iter().flatten() {
            self.within(member, found);
        }
    }
}

/// The composites of a part of a system: those of `new` that have a member in `taken` or are not stored, the rest as
/// stored; none that lacks a member.
pub(crate) fn of_part(
    stored: &SystemSpec,
    new: &SystemSpec,
    taken: impl Fn(&str) -> bool,
    there: impl Fn(&str) -> bool,
) -> Vec<CompositeSpec> {
    let (old, newer) = (
        Composites::of(&stored.composites),
        Composites::of(&new.composites),
    );
    let touched = |all: &Composites<'_>, composite: &CompositeSpec| {
        all.leaves(&composite.instance).into_iter().any(&taken)
    };
    let kept = stored
        .composites
        .iter()
        .filter(|composite| !touched(&old, composite));
    let brought = new
        .composites
        .iter()
        .filter(|composite| touched(&newer, composite));
    let mut part: Vec<CompositeSpec> = Vec::new();
    for composite in kept.chain(brought) {
        part.retain(|other| other.instance != composite.instance);
        part.push(composite.clone());
    }
    loop {
        let before = part.len();
        let names: BTreeSet<String> = part.iter().map(|one| one.instance.clone()).collect();
        part.retain(|composite| {
            let mut members = composite.members.iter();
            members.all(|member| there(member) || names.contains(member))
        });
        if part.len() == before {
            return part;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::system::CompositeKind::{self, Grouping, PeriodicECShared, PeriodicStateShared};

    fn composite(name: &str, kind: CompositeKind, members: &str) -> CompositeSpec {
        CompositeSpec {
            instance: name.to_owned(),
            kind,
            members: members.split_whitespace().map(str::to_owned).collect(),
            ..CompositeSpec::default()
        }
    }

    fn settled(names: &str, composites: &[CompositeSpec]) -> String {
        let named = |name: &str| ComponentSpec {
            instance: name.to_owned(),
            ..ComponentSpec::default()
        };
        let mut components: Vec<_> = names.split_whitespace().map(named).collect();
        settle(&mut components, composites);
        let shown = components.iter().map(|component| {
            let context = &component.execution_context;
            let state = context.shared_state.as_deref().unwrap_or("-");
            let name = context.name.as_deref().unwrap_or("-");
            format!("{}:{name}/{}/{state}", component.instance, context.order)
        });
        shown.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn members_run_on_the_execution_context_of_the_outermost_composite_in_their_order() {
        let arm = composite("arm", PeriodicECShared, "c hand a");
        assert_eq!(
            settled("a b c d", &[arm.clone(), composite("hand", Grouping, "b")]),
            "a:arm/30/- b:arm/20/- c:arm/10/- d:-/0/-"
        );
        assert_eq!(
            settled(
                "a b c d",
                &[composite("hand", PeriodicStateShared, "b"), arm.clone()]
            ),
            "a:arm/30/- b:arm/20/hand c:arm/10/- d:-/0/-"
        );
        assert_eq!(
            settled(
                "a b c",
                &[composite("all", PeriodicStateShared, "arm"), arm]
            ),
            "a:all/20/all b:-/0/- c:all/10/all"
        );
        assert_eq!(
            settled("a b", &[composite("g", Grouping, "b a")]),
            "a:-/0/- b:-/0/-"
        );
    }

    #[test]
    fn a_composite_in_itself_is_told_with_its_way() {
        let composites = [
            composite("x", Grouping, "a y"),
            composite("y", Grouping, "x"),
            composite("z", Grouping, "x"),
        ];
        let all = Composites::of(&composites);
        assert_eq!(all.cycles(), [vec!["x", "y"], vec!["y", "x"]]);
        assert_eq!(all.leaves("z"), ["a"]);
    }

    proptest! {
        #[test]
        fn whatever_composites_contain_each_component_is_found_once_and_in_an_end(
            members in proptest::collection::vec(proptest::collection::vec(0_usize..9, 0..5), 5),
            kinds in proptest::collection::vec(0_usize..3, 5),
        ) {
            let kinds = kinds.iter().map(|kind| [PeriodicECShared, PeriodicStateShared, Grouping][*kind]);
            let name = |number: &usize| format!("{}{number}", if *number < 5 { "g" } else { "c" });
            let composites: Vec<_> = members.iter().zip(kinds).enumerate().map(|(index, (own, kind))| {
                let own = own.iter().map(name).collect::<Vec<_>>().join(" ");
                composite(&name(&index), kind, &own)
            }).collect();
            let all = Composites::of(&composites);
            for composite in &composites {
                let leaves = all.leaves(&composite.instance);
                let distinct: BTreeSet<_> = leaves.iter().collect();
                prop_assert_eq!(distinct.len(), leaves.len());
                prop_assert!(leaves.iter().all(|leaf| !all.has(leaf)));
            }
            let text = settled("c5 c6 c7 c8", &composites);
            prop_assert_eq!(text, settled("c5 c6 c7 c8", &composites));
        }
    }
}
