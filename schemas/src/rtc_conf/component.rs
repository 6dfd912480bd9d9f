//! What is said of a component: by its configuration files, by `rtc.conf`, and where it is made.

use std::collections::HashMap;

use crate::diagnostic::{Finding, Place, Report, Severity};
use crate::rts_profile::parse_rate;

/// Configuration of a component. What is laid on it later wins.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ComponentConf {
    /// `configuration.active_config`.
    pub active: Option<String>,
    /// `conf.SET.KEY`: sets of values, those of editors (`__widget__`) too.
    pub sets: Named<Set>,
    /// `exec_cxt.periodic.rate`, in Hz.
    pub rate: Option<String>,
    /// `exec_cxt.periodic.type`.
    pub execution_type: Option<String>,
    /// `naming.formats`.
    pub naming_formats: Option<String>,
    /// All other keys.
    pub others: Named<String>,
}

/// Values of a configuration set.
pub type Set = Named<String>;

/// Things by name, in the order in which they came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named<T> {
    list: Vec<(String, T)>,
    index: HashMap<String, usize>,
}

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self {
            list: Vec::new(),
            index: HashMap::new(),
        }
    }
}

impl<T: Default> Named<T> {
    /// The one with this name, made if there is none.
    pub fn entry(&mut self, name: &str) -> &mut T {
        let next = self.list.len();
        let at = *self.index.entry(name.to_owned()).or_insert(next);
        if at == next {
            self.list.push((name.to_owned(), T::default()));
        }
        &mut self.list[at].1
    }

    /// All, with their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &T)> {
        self.list.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// The one with this name.
    pub fn get(&self, name: &str) -> Option<&T> {
        self.index.get(name).map(|at| &self.list[*at].1)
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

impl ComponentConf {
    /// Sets what a key says.
    pub fn lay(
        &mut self,
        key: &str,
        value: &str,
        place: impl Fn() -> Option<Place>,
        report: &mut Report,
    ) {
        let own = || (!value.is_empty()).then(|| value.to_owned());
        if let Some(rest) = key.strip_prefix("conf.")
            && let Some((set, name)) = rest.split_once('.')
        {
            value.clone_into(self.sets.entry(set).entry(name));
            return;
        }
        match key {
            "configuration.active_config" => self.active = own(),
            "exec_cxt.periodic.rate" => match rate(value) {
                Ok(rate) => self.rate = rate.or(self.rate.take()),
                Err(message) => report.push(bad_rate(message).at(place())),
            },
            "exec_cxt.periodic.type" => self.execution_type = own(),
            "naming.formats" => self.naming_formats = own(),
            // Said of a component where it is made; what the file says is read from it.
            "instance_name" | "config_file" | "manager_name" => {}
            _ => value.clone_into(self.others.entry(key)),
        }
    }
}

/// A rate as profiles have it; `None` when none is given.
pub(super) fn rate(text: &str) -> Result<Option<String>, String> {
    if text.trim().is_empty() {
        return Ok(None);
    }
    let rate = parse_rate(text).ok_or_else(|| format!("`{text}` is no rate"))?;
    Ok(Some(format!("{rate:?}")))
}

/// What is said of a rate that is none.
pub(super) fn bad_rate(message: String) -> Finding {
    let finding = Finding::new(Severity::Warning, "conf-bad-value", message);
    finding
        .help("write a number of cycles in a second, from 0.001 to 1000000; this one is left out")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_laid_later_wins() {
        let mut conf = ComponentConf::default();
        let mut report = Report::default();
        for (key, value) in [
            ("conf.default.b", "1"),
            ("conf.default.a", "2"),
            ("conf.__widget__.a", "text"),
            ("conf.default.b", "3"),
            ("exec_cxt.periodic.rate", "100"),
            ("exec_cxt.periodic.rate", "fast"),
            ("configuration.active_config", "mode0"),
            ("language", "Python"),
        ] {
            conf.lay(key, value, || None, &mut report);
        }
        let sets: Vec<_> = conf
            .sets
            .iter()
            .map(|(name, set)| (name, set.iter().collect::<Vec<_>>()))
            .collect();
        let (a, b, text) = ("2".to_owned(), "3".to_owned(), "text".to_owned());
        assert_eq!(
            sets,
            [
                ("default", vec![("b", &b), ("a", &a)]),
                ("__widget__", vec![("a", &text)])
            ]
        );
        assert_eq!(conf.rate.as_deref(), Some("100.0"));
        assert_eq!(conf.active.as_deref(), Some("mode0"));
        assert_eq!(
            conf.others.get("language").map(String::as_str),
            Some("Python")
        );
        assert_eq!(report.findings.len(), 1);
    }
}
