//! The configuration of a component: its sets, and what is in force.

use std::collections::BTreeSet;

use rts_controller_api::objects::Component;
use rts_schemas::suggest;

use super::lists::{escaped, readable};
use super::table::Table;
use crate::error::CliError;

/// The set that every component has, with all its parameters.
pub const DEFAULT: &str = "default";

/// Each parameter as it is, and as it is wanted where that differs. The active set has a `*`; one that should be active
/// and is not is `(wanted)`.
pub fn table(component: &Component, only: Option<&str>) -> Table {
    let (is, wanted) = (
        &component.status.configuration,
        &component.spec.configuration,
    );
    let mut table = Table::new(&["SET", "PARAMETER", "VALUE", "WANTED"]);
    let sets: BTreeSet<_> = is.sets.keys().chain(wanted.sets.keys()).collect();
    for set in sets
        .into_iter()
        .filter(|set| only.is_none_or(|only| only == *set))
    {
        let (has, wants) = (is.sets.get(set), wanted.sets.get(set));
        let both = [has, wants].into_iter().flatten();
        let keys: BTreeSet<_> = both.flat_map(|values| values.keys()).collect();
        for key in keys {
            let value = has.and_then(|values| values.get(key));
            let want = wants.and_then(|values| values.get(key));
            let want = want.filter(|_| want != value);
            table.row([
                format!("{}{}", escaped(set), mark(component, set)),
                escaped(key),
                value.map(|value| readable(value)).unwrap_or_default(),
                want.map(|want| readable(want)).unwrap_or_default(),
            ]);
        }
    }
    table
}

/// What stands behind the name of a set.
fn mark(component: &Component, set: &str) -> &'static str {
    let (is, wanted) = (
        &component.status.configuration,
        &component.spec.configuration,
    );
    let of = |active: &Option<String>| active.as_deref() == Some(set);
    match (of(&is.active), of(&wanted.active)) {
        (true, _) => "*",
        (false, true) => "(wanted)",
        (false, false) => "",
    }
}

/// A value in force, and the set that it is of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InForce<'a> {
    /// The set that has it.
    pub set: &'a str,
    /// The value.
    pub value: &'a str,
}

/// The value that a parameter has while a set is the active one (`None`: the one that is): the set's own, else that of
/// `default`.
pub fn in_force<'a>(
    component: &'a Component,
    parameter: &str,
    set: Option<&str>,
) -> Result<InForce<'a>, CliError> {
    let is = &component.status.configuration;
    if let Some(set) = set {
        has_set(component, set)?;
    }
    let first = set.or(is.active.as_deref()).unwrap_or(DEFAULT);
    let own = [first, DEFAULT]
        .into_iter()
        .filter_map(|set| is.sets.get_key_value(set));
    let mut values = own.filter_map(|(set, values)| Some((set, values.get(parameter)?)));
    match values.next() {
        Some((set, value)) => Ok(InForce { set, value }),
        None => {
            let sets = is
                .sets
                .iter()
                .filter(|(set, _)| [first, DEFAULT].contains(&set.as_str()));
            let names: BTreeSet<_> = sets.flat_map(|(_, values)| values.keys()).collect();
            Err(unknown(component, "parameter", parameter, &names))
        }
    }
}

/// An error for a set that the component does not have.
pub fn has_set(component: &Component, set: &str) -> Result<(), CliError> {
    let sets = &component.status.configuration.sets;
    if sets.contains_key(set) {
        return Ok(());
    }
    let names = sets.keys().collect();
    Err(unknown(component, "configuration set", set, &names))
}

fn unknown(component: &Component, what: &str, name: &str, known: &BTreeSet<&String>) -> CliError {
    let instance = &component.metadata.name;
    let known: Vec<_> = known.iter().map(|name| name.as_str()).collect();
    let help = match known.as_slice() {
        [] => format!("component/{instance} has none, or is not created yet"),
        known => suggest::advice(name, "there are", known),
    };
    CliError::usage_help(format!("component/{instance} has no {what} {name:?}"), help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::{lists::typed, samples};
    use rts_controller_api::objects::Kind;
    use rts_schemas::system::Configuration;

    fn configuration(active: &str, values: &[(&str, &str, &str)]) -> Configuration {
        let mut configuration = Configuration {
            active: Some(active.to_owned()),
            ..Configuration::default()
        };
        for (set, key, value) in values {
            let set = configuration.sets.entry((*set).to_owned()).or_default();
            set.insert((*key).to_owned(), (*value).to_owned());
        }
        configuration
    }

    fn component() -> Component {
        let all: Result<Vec<Component>, _> =
            typed(Kind::Component, &samples::values(Kind::Component));
        let mut component = all.unwrap().remove(0);
        component.status.configuration = configuration(
            "fast",
            &[
                ("default", "gain", "1.0"),
                ("default", "title", "left arm"),
                ("default", "alpha", "0.5"),
                ("fast", "gain", "9"),
            ],
        );
        component.spec.configuration = configuration(
            "slow",
            &[("default", "alpha", "0.1"), ("slow", "gain", "0.1")],
        );
        component
    }

    #[test]
    fn what_is_stands_beside_what_is_wanted() {
        let text = table(&component(), None).render(true, false);
        insta::assert_snapshot!(text, @r"
        SET           PARAMETER  VALUE     WANTED
        default       alpha      0.5       0.1
        default       gain       1.0       -
        default       title      left arm  -
        fast*         gain       9         -
        slow(wanted)  gain       -         0.1
        ");
        assert_eq!(table(&component(), Some("fast")).rows.len(), 1);
    }

    #[test]
    fn the_active_set_is_in_force_over_the_default_one() {
        let component = component();
        let value = |parameter, set| {
            let found = in_force(&component, parameter, set)?;
            Ok::<_, CliError>(format!("{} of {}", found.value, found.set))
        };
        assert_eq!(value("gain", None).unwrap(), "9 of fast");
        assert_eq!(value("alpha", None).unwrap(), "0.5 of default");
        assert_eq!(value("gain", Some("default")).unwrap(), "1.0 of default");
        let error = |parameter, set| {
            let error = value(parameter, set).unwrap_err();
            assert_eq!(error.exit().code(), 2);
            format!("{}; {}", error.line(), error.help().unwrap())
        };
        assert_eq!(
            error("gian", None),
            "component/Sine0 has no parameter \"gian\"; did you mean `gain`? there are: alpha, gain, title"
        );
        assert_eq!(
            error("gain", Some("slow")),
            "component/Sine0 has no configuration set \"slow\"; there are: default, fast"
        );
    }
}
