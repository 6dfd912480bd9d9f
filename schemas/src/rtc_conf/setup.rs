//! A set-up: one or more `rtc.conf` files, each of a manager, with the configuration files that they name.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::component::{ComponentConf, bad_rate, rate};
use super::entries::{Conf, Entry, read};
use super::item::Precreate;
use super::keys;
use super::manager::{ComponentFile, ManagerConf};
use super::sources::{Bounded, Sources};
use crate::diagnostic::{Finding, Place, Report, Severity};
use crate::names;
use crate::suggest;

/// Most values that are laid on the components of a set-up.
const VALUES: usize = 100_000;

/// Most findings on unknown keys, and on unknown components, of a file; the rest is counted.
const UNKNOWN: usize = 50;

/// Managers with their components.
#[derive(Debug, Clone, Default)]
pub struct Setup {
    /// The managers, in the order of their files.
    pub managers: Vec<Manager>,
}

/// A manager.
#[derive(Debug, Clone)]
pub struct Manager {
    /// Its name: a manager's name of no other file.
    pub name: String,
    /// Its file.
    pub conf: Conf,
    /// What the file says.
    pub view: ManagerConf,
    /// What it makes.
    pub components: Vec<Component>,
}

/// A component that a manager makes.
#[derive(Debug, Clone)]
pub struct Component {
    /// Its name.
    pub instance: String,
    /// Its type.
    pub type_name: String,
    /// Vendor, category and version, when its manager is told.
    pub id: Option<[String; 3]>,
    /// Category, when a key of its configuration says it.
    pub category: Option<String>,
    /// Name of the manager that it is made in.
    pub manager: String,
    /// Where it is made.
    pub place: Option<Place>,
    /// Its configuration.
    pub conf: ComponentConf,
}

/// Reads a set-up: the files with their paths, and through `sources` what they name.
///
/// Findings go to the report. A file that cannot be read makes no manager.
pub fn load(files: &[(&str, &[u8])], sources: &dyn Sources, report: &mut Report) -> Setup {
    let mut loader = Loader {
        sources: Bounded::new(sources),
        report,
        names: HashSet::new(),
        numbers: HashMap::new(),
        values: 0,
    };
    let managers = files
        .iter()
        .filter_map(|(path, bytes)| loader.manager(path, bytes));
    Setup {
        managers: managers.collect(),
    }
}

struct Loader<'a> {
    sources: Bounded<'a>,
    report: &'a mut Report,
    names: HashSet<String>,
    /// How many components of a type a manager has made.
    numbers: HashMap<(String, String), usize>,
    values: usize,
}

/// What an `rtc.conf` itself says of components, by their names.
#[derive(Default)]
struct Own<'a> {
    values: HashMap<&'a str, Vec<(&'a str, &'a Entry)>>,
    files: HashMap<&'a str, Vec<&'a ComponentFile>>,
    categories: HashMap<&'a str, &'a str>,
}

impl Loader<'_> {
    fn manager(&mut self, path: &str, bytes: &[u8]) -> Option<Manager> {
        let conf = match read(path, bytes) {
            Ok(conf) => conf,
            Err(report) => {
                self.report.extend(report);
                return None;
            }
        };
        let mut found = conf.findings.clone();
        let view = ManagerConf::of(&conf, &mut found);
        self.report.extend(found);
        let name = self.name(path, &conf, &view);
        let mut components = self.made(&conf, &view, &name);
        let own = self.own(&conf, &view, &components);
        let mut cache = HashMap::new();
        for (component, item) in components.iter_mut().zip(&view.precreate) {
            self.configure(component, item, &conf, &view, &own, &mut cache);
        }
        Some(Manager {
            name,
            conf,
            view,
            components,
        })
    }

    /// The name that the file gives, else the stem of the file; with a number if it is another file's.
    fn name(&mut self, path: &str, conf: &Conf, view: &ManagerConf) -> String {
        let stem = names::file_stem(path).unwrap_or("rtc");
        let stem = names::manager_name(stem).unwrap_or_else(|| "manager".to_owned());
        let place = view.name.as_ref().and_then(|text| conf.place(text.span));
        // `manager_%p`: the number of a process is nobody's name.
        let given = view.name.as_ref().map(|text| text.value.replace("%p", ""));
        let found = given.as_deref().and_then(names::manager_name);
        let mut name = found.unwrap_or_else(|| stem.clone());
        if let Some(text) = view.name.as_ref().filter(|text| text.trimmed() != name) {
            let message = format!(
                "`{}` cannot name a manager here, it is called `{name}`",
                text.value
            );
            let finding = Finding::new(Severity::Note, "conf-manager-name", message);
            let help = "a manager's name has 1 to 63 letters, digits, `-`, `_` and `.`";
            self.report.push(finding.at(place.clone()).help(help));
        }
        if self.names.contains(&name) {
            let mut numbers = (2..).map(|number| format!("{name}-{number}"));
            let other = Some(stem).filter(|stem| !self.names.contains(stem));
            let other = other.or_else(|| numbers.find(|n| !self.names.contains(n)));
            let other = other.unwrap_or_default();
            let message = format!(
                "another file's manager is called `{name}` too; this one is called `{other}`"
            );
            let finding = Finding::new(Severity::Note, "conf-manager-name", message);
            let help = "give each file a `manager.instance_name` of its own";
            self.report.push(finding.at(place).help(help));
            name = other;
        }
        self.names.insert(name.clone());
        name
    }

    /// The components in the order in which they are made, numbered as OpenRTM-aist does: one with a name of its own
    /// takes a number too.
    fn made(&mut self, conf: &Conf, view: &ManagerConf, manager: &str) -> Vec<Component> {
        let made = view.precreate.iter().map(|item| {
            let own = item.argument("manager_name").and_then(names::manager_name);
            let manager = own.unwrap_or_else(|| manager.to_owned());
            let process = match view.numbered_together {
                true => String::new(),
                false => manager.clone(),
            };
            let count = self
                .numbers
                .entry((process, item.type_name.clone()))
                .or_default();
            let number = *count;
            *count += 1;
            let given = item
                .argument("instance_name")
                .filter(|name| !name.is_empty());
            Component {
                instance: given
                    .map_or_else(|| format!("{}{number}", item.type_name), str::to_owned),
                type_name: item.type_name.clone(),
                id: item.id.clone(),
                category: None,
                manager,
                place: conf.place(item.span),
                conf: ComponentConf::default(),
            }
        });
        made.collect()
    }

    /// Sorts what the file says of components by their names, and says what is of none.
    fn own<'v>(&mut self, conf: &Conf, view: &'v ManagerConf, components: &[Component]) -> Own<'v> {
        let names: HashSet<&str> = components
            .iter()
            .flat_map(|c| [c.instance.as_str(), c.type_name.as_str()])
            .collect();
        let mut own = Own::default();
        let mut strangers = 0;
        for file in &view.component_files {
            if names.contains(file.name.as_str()) {
                own.files.entry(&file.name).or_default().push(file);
                own.categories.entry(&file.name).or_insert(&file.category);
                continue;
            }
            strangers += 1;
            if strangers > UNKNOWN {
                continue;
            }
            let message = format!(
                "no component called `{}`, or of this type, is made here",
                file.name
            );
            let all: Vec<&str> = components.iter().map(|c| c.instance.as_str()).collect();
            let help = format!(
                "its configuration is left out; {}",
                suggest::advice(&file.name, "components", &all)
            );
            let finding = Finding::warning("conf-unknown-instance", message);
            self.report
                .push(finding.at(conf.place(file.span)).help(help));
        }
        if strangers > UNKNOWN {
            let message = format!(
                "{} more configuration files are of no component",
                strangers - UNKNOWN
            );
            let finding = Finding::warning("conf-unknown-instance", message);
            self.report.push(finding.help("they are left out"));
        }
        let mut unknown = 0;
        let of_a_component = conf.is_of_a_component();
        for entry in &view.unknown {
            let key = entry.key.value.as_str();
            if of_a_component && key.starts_with("conf.") {
                continue;
            }
            match parts(key, &names) {
                Some((category, name, rest)) => {
                    own.categories.entry(name).or_insert(category);
                    own.values.entry(name).or_default().push((rest, entry));
                }
                None => {
                    unknown += 1;
                    if unknown <= UNKNOWN {
                        self.report.push(unknown_key(conf, entry));
                    }
                }
            }
        }
        if unknown > UNKNOWN {
            let message = format!("OpenRTM-aist has none of {} more keys", unknown - UNKNOWN);
            let finding = Finding::new(Severity::Note, "conf-unknown-key", message);
            self.report.push(finding.help("they are not carried over"));
        }
        own
    }

    /// Lays everything on a component, in the order of OpenRTM-aist: the manager's rate, where it is made, the file of
    /// its type, `rtc.conf` on its type, and the same for its name.
    fn configure(
        &mut self,
        component: &mut Component,
        item: &Precreate,
        conf: &Conf,
        view: &ManagerConf,
        own: &Own<'_>,
        cache: &mut HashMap<String, Option<Rc<Conf>>>,
    ) {
        if let Some(text) = &view.rate {
            match rate(&text.value) {
                Ok(rate) => component.conf.rate = rate,
                Err(message) => {
                    let finding = bad_rate(message).at(conf.place(text.span));
                    if !self.report.findings.contains(&finding) {
                        self.report.push(finding);
                    }
                }
            }
        }
        component.conf.execution_type = view.execution_type.as_ref().map(|text| text.value.clone());
        let place = component.place.clone();
        for (key, value) in &item.arguments {
            component
                .conf
                .lay(key, value, || place.clone(), self.report);
        }
        let names = [component.type_name.clone(), component.instance.clone()];
        for (at, name) in names.iter().enumerate() {
            if at == 1 && names[0] == names[1] {
                break;
            }
            if let Some(category) = own.categories.get(name.as_str()) {
                component.category = Some((*category).to_owned());
            }
            for file in own.files.get(name.as_str()).into_iter().flatten() {
                if let Some(found) = self.file(file, conf, cache) {
                    let entries = found
                        .entries
                        .iter()
                        .map(|entry| (entry.key.value.as_str(), entry));
                    self.lay(component, &found, entries);
                }
            }
            if let Some(values) = own.values.get(name.as_str()) {
                self.lay(component, conf, values.iter().copied());
            }
        }
    }

    fn lay<'e>(
        &mut self,
        component: &mut Component,
        conf: &Conf,
        entries: impl Iterator<Item = (&'e str, &'e Entry)>,
    ) {
        for (key, entry) in entries {
            self.values += 1;
            if self.values == VALUES {
                let message = format!("the components have more than {VALUES} values");
                let finding = Finding::error("too-large", message);
                self.report.push(finding.help("is this the right file?"));
            }
            if self.values >= VALUES {
                return;
            }
            let place = || conf.place(entry.text().span);
            component.conf.lay(key, &entry.value, place, self.report);
        }
    }

    /// A configuration file of components, read once.
    fn file(
        &mut self,
        file: &ComponentFile,
        conf: &Conf,
        cache: &mut HashMap<String, Option<Rc<Conf>>>,
    ) -> Option<Rc<Conf>> {
        let key = file.paths.join(",");
        if let Some(known) = cache.get(&key) {
            return known.clone();
        }
        let found = self.find(file, conf).map(Rc::new);
        cache.insert(key, found.clone());
        found
    }

    fn find(&mut self, file: &ComponentFile, conf: &Conf) -> Option<Conf> {
        let place = conf.place(file.span);
        if let [first, _, ..] = file.paths.as_slice() {
            let message = format!(
                "{} files are named; OpenRTM-aist takes them for one name",
                file.paths.len()
            );
            let finding = Finding::warning("conf-several-files", message).at(place.clone());
            self.report
                .push(finding.help(format!("name one file: `{first}`")));
        }
        for path in &file.paths {
            match self.sources.find(conf.source.name(), path) {
                Ok(None) => {}
                Ok(Some((path, bytes))) => match read(&path, &bytes) {
                    Ok(read) => {
                        self.report.extend(read.findings.clone());
                        return Some(read);
                    }
                    Err(report) => {
                        self.report.extend(report);
                        return None;
                    }
                },
                Err(reason) => {
                    let message = format!("`{path}` cannot be read: {reason}");
                    let finding = Finding::error("conf-file-missing", message).at(place);
                    self.report
                        .push(finding.help("take the line away, or put the file there"));
                    return None;
                }
            }
        }
        let message = format!("there is no file `{}`", file.paths.join(","));
        let finding = Finding::warning("conf-file-missing", message).at(place);
        let help = "paths count from the folder of the `rtc.conf`, or one above it; nothing is read of this one";
        self.report.push(finding.help(help));
        None
    }
}

/// `CATEGORY.NAME.KEY` with a name of these.
fn parts<'k>(key: &'k str, names: &HashSet<&str>) -> Option<(&'k str, &'k str, &'k str)> {
    let dots: Vec<usize> = key.match_indices('.').map(|(at, _)| at).collect();
    dots.windows(2).find_map(|pair| {
        let name = &key[pair[0] + 1..pair[1]];
        let found = names.contains(name);
        found.then(|| (&key[..pair[0]], name, &key[pair[1] + 1..]))
    })
}

fn unknown_key(conf: &Conf, entry: &Entry) -> Finding {
    let key = &entry.key.value;
    let place = conf.place(entry.key.span);
    let message = format!("OpenRTM-aist has no key `{key}`");
    match keys::nearest(key) {
        Some(near) => {
            Finding::warning("conf-unknown-key", message).help(format!("did you mean `{near}`?"))
        }
        None => {
            Finding::new(Severity::Note, "conf-unknown-key", message).help("it is not carried over")
        }
    }
    .at(place)
}
