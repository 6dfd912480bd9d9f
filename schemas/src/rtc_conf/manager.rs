//! What an `rtc.conf` says of its manager.

use super::entries::{Conf, Entry};
use super::item::{Fault, Preconnect, Precreate};
use super::{keys, list};
use crate::diagnostic::{Finding, Report, Severity};
use crate::span::{Span, Text};

/// Most files of which one is looked for.
const PATHS: usize = 10;

/// A manager: what it makes, connects and activates when it starts, and how it names things.
#[derive(Debug, Clone, Default)]
pub struct ManagerConf {
    /// `manager.instance_name`, else `manager.name`.
    pub name: Option<Text>,
    /// `corba.nameservers`.
    pub nameservers: Vec<Text>,
    /// `naming.formats`: paths at the name servers, with `%n` for the instance name and others.
    pub naming_formats: Vec<Text>,
    /// `naming.enable`.
    pub naming_enabled: Option<bool>,
    /// `manager.components.naming_policy` is not `process_unique`: numbers count over all managers.
    pub numbered_together: bool,
    /// `manager.modules.load_path`: where modules are looked for.
    pub load_path: Vec<Text>,
    /// `manager.modules.preload`: modules that are loaded first.
    pub preload: Vec<Text>,
    /// `manager.modules.abs_path_allowed`.
    pub absolute_paths: Option<bool>,
    /// `manager.components.precreate`.
    pub precreate: Vec<Precreate>,
    /// `manager.components.preconnect`.
    pub preconnect: Vec<Preconnect>,
    /// `manager.components.preactivation`: names, or addresses that end in one.
    pub preactivation: Vec<Text>,
    /// `exec_cxt.periodic.rate`.
    pub rate: Option<Text>,
    /// `exec_cxt.periodic.type`.
    pub execution_type: Option<Text>,
    /// `CATEGORY.NAME.config_file`: configuration files of components, by type or by instance.
    pub component_files: Vec<ComponentFile>,
    /// Keys that are known and that no field here is for.
    pub others: Vec<Text>,
    /// Entries whose keys are not known: maybe `CATEGORY.NAME.KEY` of a component.
    pub unknown: Vec<Entry>,
}

/// A configuration file of components.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComponentFile {
    /// Category of the components.
    pub category: String,
    /// Name of a type or of an instance.
    pub name: String,
    /// The file, or several of which one is there.
    pub paths: Vec<String>,
    /// Where it is named.
    pub span: Span,
}

impl ManagerConf {
    /// Reads the entries of a file. What is odd in a value is reported.
    pub fn of(conf: &Conf, report: &mut Report) -> Self {
        let mut reader = Reader {
            conf,
            report,
            read: Self::default(),
        };
        for entry in &conf.entries {
            reader.entry(entry);
        }
        reader.read
    }
}

struct Reader<'a> {
    conf: &'a Conf,
    report: &'a mut Report,
    read: ManagerConf,
}

impl Reader<'_> {
    fn entry(&mut self, entry: &Entry) {
        let key = entry.key.value.as_str();
        let given = !entry.value.is_empty();
        match key {
            "manager.instance_name" if given => self.read.name = Some(entry.text()),
            "manager.name" => {
                if self.read.name.is_none() && given {
                    self.read.name = Some(entry.text());
                }
            }
            "corba.nameservers" | "corba.name_servers" => self.read.nameservers = self.list(entry),
            "naming.formats" => self.read.naming_formats = self.list(entry),
            "naming.enable" => self.read.naming_enabled = self.boolean(entry),
            "manager.components.naming_policy" => {
                let policy = entry.value.trim();
                self.read.numbered_together = matches!(policy, "node_unique" | "ns_unique");
            }
            "manager.modules.load_path" => self.read.load_path = self.list(entry),
            "manager.modules.preload" => self.read.preload = self.list(entry),
            "manager.modules.abs_path_allowed" => self.read.absolute_paths = self.boolean(entry),
            "manager.components.precreate" => {
                self.read.precreate = self.items(entry, Precreate::of);
            }
            "manager.components.preconnect" => {
                self.read.preconnect = self.items(entry, Preconnect::of);
            }
            "manager.components.preactivation" => self.read.preactivation = self.list(entry),
            "exec_cxt.periodic.rate" if given => self.read.rate = Some(entry.text()),
            "exec_cxt.periodic.type" if given => self.read.execution_type = Some(entry.text()),
            _ => self.other(entry),
        }
    }

    fn other(&mut self, entry: &Entry) {
        let key = entry.key.value.as_str();
        if let Some(head) = key.strip_suffix(".config_file")
            && let Some((category, name)) = head.rsplit_once('.')
        {
            if entry.value.is_empty() {
                return;
            }
            let paths = entry.path();
            let paths = paths
                .split(',')
                .map(str::trim)
                .filter(|path| !path.is_empty());
            let paths = paths.take(PATHS);
            self.read.component_files.push(ComponentFile {
                category: category.trim().to_owned(),
                name: name.trim().to_owned(),
                paths: paths.map(str::to_owned).collect(),
                span: entry.text().span,
            });
        } else if keys::is_known(key) {
            // What is empty says nothing.
            if !entry.value.is_empty() {
                self.read.others.push(entry.key.clone());
            }
        } else {
            self.read.unknown.push(entry.clone());
        }
    }

    fn list(&mut self, entry: &Entry) -> Vec<Text> {
        let (items, too_many) = list::items(entry);
        if too_many {
            let message = format!("`{}` has more than {} items", entry.key.value, items.len());
            let place = self.conf.place(entry.key.span);
            let finding = Finding::error("too-large", message).at(place);
            self.report.push(finding.help("is this the right file?"));
        }
        items
    }

    fn items<T>(&mut self, entry: &Entry, read: impl Fn(&Text) -> Result<T, Fault>) -> Vec<T> {
        let mut all = Vec::new();
        for item in self.list(entry) {
            match read(&item) {
                Ok(item) => all.push(item),
                Err((message, help)) => {
                    let finding = Finding::error("conf-bad-item", message);
                    self.report
                        .push(finding.at(self.conf.place(item.span)).help(help));
                }
            }
        }
        all
    }

    fn boolean(&mut self, entry: &Entry) -> Option<bool> {
        let read = yes_or_no(&entry.value);
        if read.is_none() {
            let message = format!(
                "`{}` is `{}`, which is neither YES nor NO",
                entry.key.value, entry.value
            );
            let finding = Finding::new(Severity::Warning, "conf-bad-value", message);
            let place = self.conf.place(entry.text().span);
            self.report
                .push(finding.at(place).help("write `YES` or `NO`"));
        }
        read
    }
}

fn yes_or_no(text: &str) -> Option<bool> {
    match text.trim().to_ascii_lowercase().as_str() {
        "yes" | "true" | "on" | "1" => Some(true),
        "no" | "false" | "off" | "0" => Some(false),
        _ => None,
    }
}
