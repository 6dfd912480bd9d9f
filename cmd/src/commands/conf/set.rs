//! `rtsctl conf NAME set`, and `act`.

use std::collections::BTreeMap;

use rts_agent_api::messages::Act;
use rts_controller_api::objects::Component;

use crate::commands::by_hand::Hand;
use crate::commands::connect::{pair, repeated};
use crate::error::CliError;
use crate::exit::Exit;
use crate::show::conf;

/// Set values of parameters
///
/// A value that begins with `-` and is no number is written PARAM=VALUE. What becomes of it in a system is for
/// `rtsctl.drift` to say: by default the controller sets the values back.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A parameter and its value (`gain 2`), or several (`gain=2 alpha=0.5`)
    #[arg(
        value_name = "PARAM=VALUE",
        required = true,
        allow_negative_numbers = true
    )]
    values: Vec<String>,
    /// The set that the values are of [default: the active one]
    #[arg(short, long, value_name = "SET")]
    set: Option<String>,
    /// Only say what would be done
    #[arg(long)]
    pub dry_run: bool,
}

impl Args {
    /// What they ask for.
    pub fn change(&self) -> Result<Change, CliError> {
        let values = pairs(&self.values).map_err(|message| {
            CliError::usage_help(message, "write PARAM VALUE, or PARAM=VALUE for several")
        })?;
        if let Some(parameter) = repeated(&values) {
            return Err(CliError::usage(format!(
                "parameter {parameter} is said twice"
            )));
        }
        Ok(Change {
            set: self.set.clone(),
            values: values.into_iter().collect(),
            active: None,
        })
    }
}

/// `[PARAM, VALUE]`, or each `PARAM=VALUE`.
fn pairs(words: &[String]) -> Result<Vec<(String, String)>, String> {
    match words {
        [parameter, value] if !parameter.contains('=') => {
            Ok(vec![(parameter.clone(), value.clone())])
        }
        words => words
            .iter()
            .map(|word| pair(word).map_err(|_| format!("{word:?} gives no value to a parameter")))
            .collect(),
    }
}

/// Values, or another active set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    set: Option<String>,
    values: BTreeMap<String, String>,
    active: Option<String>,
}

impl Change {
    /// Another active set.
    pub fn activate(set: &str) -> Self {
        Self {
            set: None,
            values: BTreeMap::new(),
            active: Some(set.to_owned()),
        }
    }

    /// Asks for it.
    pub async fn ask(self, component: &Component, hand: &Hand<'_>) -> Result<Exit, CliError> {
        let differences = self.differences(component);
        let act = Act::Configure {
            instance: component.metadata.name.clone(),
            set: self.set,
            values: self.values,
            active: self.active,
        };
        let (node, so) = (&component.status.node, differences.is_empty());
        hand.act(node, act, so, &differences.join(", ")).await?;
        Ok(Exit::Ok)
    }

    /// What is not so yet, old and new.
    fn differences(&self, component: &Component) -> Vec<String> {
        let is = &component.status.configuration;
        let active = is.active.as_deref().unwrap_or(conf::DEFAULT);
        let set = self.set.as_deref().unwrap_or(active);
        let own = is.sets.get(set);
        let mut differences = Vec::new();
        for (parameter, new) in &self.values {
            let old = own.and_then(|values| values.get(parameter));
            if old != Some(new) {
                differences.push(format!("{set}.{parameter}: {} -> {new}", none(old)));
            }
        }
        if let Some(new) = self.active.as_deref().filter(|new| *new != active) {
            differences.push(format!("active set: {active} -> {new}"));
        }
        differences
    }
}

fn none(value: Option<&String>) -> &str {
    value.map_or("none", String::as_str)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::{lists::typed, samples};
    use rts_controller_api::objects::Kind;

    fn words(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn values_are_given_in_one_word_or_two() {
        let read = |text| {
            let pairs = pairs(&words(text))?;
            let pairs: Vec<_> = pairs.iter().map(|(k, v)| format!("{k} is {v}")).collect();
            Ok::<_, String>(pairs.join(", "))
        };
        assert_eq!(read("gain 2").unwrap(), "gain is 2");
        assert_eq!(read("gain a=b").unwrap(), "gain is a=b");
        assert_eq!(read("gain=2").unwrap(), "gain is 2");
        assert_eq!(read("a=1 b=2 c=").unwrap(), "a is 1, b is 2, c is ");
        for wrong in ["gain", "a=1 b", "a 1 b 2", "=1"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_changes_is_told_with_what_it_was() {
        let mut all: Vec<Component> =
            typed(Kind::Component, &samples::values(Kind::Component)).unwrap();
        let component = &mut all[0];
        let values = BTreeMap::from([("gain".to_owned(), "1.0".to_owned())]);
        let configuration = &mut component.status.configuration;
        configuration.sets.insert("default".to_owned(), values);
        let differences = |set: Option<&str>, pairs_of: &str, active: Option<&str>| {
            let change = Change {
                set: set.map(str::to_owned),
                values: pairs(&words(pairs_of)).unwrap().into_iter().collect(),
                active: active.map(str::to_owned),
            };
            change.differences(component)
        };
        assert_eq!(
            differences(None, "gain=2", None),
            ["default.gain: 1.0 -> 2"]
        );
        assert!(differences(None, "gain=1.0", Some("default")).is_empty());
        assert_eq!(
            differences(Some("fast"), "gain=1.0", Some("fast")),
            ["fast.gain: none -> 1.0", "active set: default -> fast"]
        );
    }
}
