//! A service: the agent's command, who keeps it running, and the text of its unit.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::found::Record;
use crate::survey::{Survey, Systemd};

/// Who keeps the agent running.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Keeper {
    /// A unit of the machine, as root.
    SystemUnit,
    /// A unit of the account.
    UserUnit,
    /// Nobody: a process that does not come back after a reboot.
    Process,
}

impl Keeper {
    /// What an account has. Root has the machine's units.
    pub fn of(survey: &Survey) -> Self {
        match (survey.systemd, survey.uid) {
            (Systemd::System | Systemd::User, 0) => Keeper::SystemUnit,
            (Systemd::User, _) => Keeper::UserUnit,
            _ => Keeper::Process,
        }
    }

    /// The flag of `systemctl`.
    pub(super) fn flag(self) -> &'static str {
        match self {
            Keeper::UserUnit => "--user",
            _ => "",
        }
    }
}

/// A service, whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Service {
    /// Node.
    pub node: String,
    /// Folder of rtsctl there.
    pub home: String,
    /// Who keeps it.
    pub keeper: Keeper,
    /// Command of the agent; the program first.
    pub command: Vec<String>,
    /// Where units are kept.
    pub unit_folder: String,
}

impl Service {
    /// Of an account, kept by what is best there.
    pub(super) fn new(survey: &Survey, node: &str) -> Self {
        Self::kept_by(Keeper::of(survey), survey, node)
    }

    /// Of an account.
    pub(super) fn kept_by(keeper: Keeper, survey: &Survey, node: &str) -> Self {
        let config = || format!("{}/.config", survey.home.trim_end_matches('/'));
        let unit_folder = match keeper {
            Keeper::SystemUnit => "/etc/systemd/system".to_owned(),
            _ => {
                let config = survey.config.clone().unwrap_or_else(config);
                format!("{}/systemd/user", config.trim_end_matches('/'))
            }
        };
        Self {
            node: node.to_owned(),
            home: survey.rtsctl_home(),
            keeper,
            command: Vec::new(),
            unit_folder,
        }
    }

    /// The agent's program there.
    pub fn program(&self) -> &str {
        self.command.first().map_or("", String::as_str)
    }

    /// Name of the unit.
    pub fn unit_name(&self) -> String {
        format!("rtsctl-agent-{}.service", self.node)
    }

    /// File of the unit.
    pub fn unit_file(&self) -> String {
        format!("{}/{}", self.unit_folder, self.unit_name())
    }

    /// Folder of programs there.
    pub fn programs(&self) -> String {
        format!("{}/programs", self.home)
    }

    /// Folder of modules there.
    pub fn modules(&self) -> String {
        format!("{}/modules", self.home)
    }

    /// What is remembered of it.
    pub fn record_file(&self) -> String {
        format!("{}/services/{}.json", self.home, self.node)
    }

    /// Script that starts a plain process.
    pub fn script_file(&self) -> String {
        format!("{}/services/{}.sh", self.home, self.node)
    }

    /// Log of a plain process.
    pub fn log_file(&self) -> String {
        format!("{}/services/{}.log", self.home, self.node)
    }

    /// Adds the arguments of the agent.
    pub(super) fn run(
        &mut self,
        agent: &str,
        manager: &str,
        modules: &[(String, String)],
        aliases: &[String],
    ) {
        let mut command = vec![agent.to_owned()];
        let mut add = |key: &str, value: String| command.extend([key.to_owned(), value]);
        add("--home", self.home.clone());
        add("--node", self.node.clone());
        add(
            "--controller",
            format!("{}/run/{}/controller.sock", self.home, self.node),
        );
        add("--manager-program", manager.to_owned());
        let root = format!("{}/modules", self.home);
        let folders: Vec<String> = match modules {
            [] => vec![root],
            modules => modules
                .iter()
                .map(|(digest, _)| format!("{root}/{digest}"))
                .collect(),
        };
        add("--module-path", folders.join(":"));
        for alias in aliases {
            add("--alias", alias.clone());
        }
        self.command = command;
    }

    /// What is remembered of it when it is installed.
    pub(super) fn record(
        &self,
        programs: Vec<String>,
        modules: Vec<(String, String)>,
        lingers: bool,
    ) -> Record {
        Record {
            node: self.node.clone(),
            keeper: self.keeper,
            command: self.command.clone(),
            programs,
            modules,
            lingers,
        }
    }

    /// Text of the unit. Its managers outlive it, and are its own group of processes below it (`Delegate`).
    pub fn unit(&self) -> String {
        // In a command a dollar is a variable.
        let word = |word: &String| unit_word(word).replace('$', "$$");
        let words: Vec<String> = self.command.iter().map(word).collect();
        let mut text = String::new();
        let _ = write!(
            text,
            "[Unit]\n\
             Description=rtsctl agent of node {node}\n\
             Documentation=https://github.com/rtsctl/rtsctl\n\
             After=network.target\n\
             \n\
             [Service]\n\
             ExecStart={command}\n\
             Environment={home}\n\
             # The components' processes go on while the agent is restarted or replaced.\n\
             KillMode=process\n\
             Delegate=yes\n\
             Restart=on-failure\n\
             RestartSec=1\n\
             \n\
             [Install]\n\
             WantedBy={target}\n",
            node = self.node,
            command = words.join(" "),
            home = unit_word(&format!("RTSCTL_HOME={}", self.home)),
            target = match self.keeper {
                Keeper::UserUnit => "default.target",
                _ => "multi-user.target",
            },
        );
        text
    }

    /// Text of the script that starts a plain process.
    pub fn script(&self) -> String {
        let quoted = |word: &str| shell_escape::unix::escape(word.to_owned().into()).into_owned();
        let words: Vec<String> = self.command.iter().map(|word| quoted(word)).collect();
        let (home, log) = (quoted(&self.home), quoted(&self.log_file()));
        format!(
            "#!/bin/sh\n\
             # Starts the agent of node {node}, as `rtsctl node bootstrap` installed it.\n\
             RTSCTL_HOME={home}; export RTSCTL_HOME\n\
             exec {command} </dev/null >>{log} 2>&1\n",
            node = self.node,
            command = words.join(" "),
        )
    }

    /// The file that starts it, and its text.
    pub fn file(&self) -> (String, String) {
        match self.keeper {
            Keeper::Process => (self.script_file(), self.script()),
            _ => (self.unit_file(), self.unit()),
        }
    }

    /// A line for the account's table of cron, which starts the process when the machine does.
    pub fn cron_line(&self) -> String {
        // Cron takes a percent sign for a line break.
        let script = shell_escape::unix::escape(self.script_file().into()).replace('%', "\\%");
        format!("@reboot {script}")
    }
}

/// A word as systemd takes it: quoted where need be, without specifiers (systemd.syntax).
fn unit_word(word: &str) -> String {
    let escaped = word
        .replace('\\', "\\\\")
        .replace('"', "\\\"")
        .replace('%', "%%");
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=@+,".contains(c);
    match word.chars().all(plain) {
        true => escaped,
        false => format!("\"{escaped}\""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn survey(systemd: Systemd, uid: u32) -> Survey {
        Survey {
            kernel: "Linux".to_owned(),
            release: String::new(),
            machine: "x86_64".to_owned(),
            node: "arm7".to_owned(),
            bits: Some(64),
            libc: String::new(),
            home: "/home/pi".to_owned(),
            state: None,
            config: None,
            user: "pi".to_owned(),
            uid,
            systemd,
            linger: false,
            sha256sum: true,
            free: None,
        }
    }

    fn service(systemd: Systemd, uid: u32) -> Service {
        let mut service = Service::new(&survey(systemd, uid), "arm7");
        let modules = [
            ("d1".to_owned(), "libA.so".to_owned()),
            ("d2".to_owned(), "libB.so".to_owned()),
        ];
        let (agent, manager) = (
            "/home/pi/.local/state/rtsctl/programs/d3/rts-agent",
            "/p/d4/rts-manager",
        );
        service.run(agent, manager, &modules, &["robot.local".to_owned()]);
        service
    }

    #[test]
    fn the_unit_of_an_account_is_as_reviewed() {
        let service = service(Systemd::User, 1000);
        assert_eq!(
            service.unit_file(),
            "/home/pi/.config/systemd/user/rtsctl-agent-arm7.service"
        );
        insta::assert_snapshot!(service.unit());
    }

    #[test]
    fn the_unit_of_a_machine_is_as_reviewed() {
        let service = service(Systemd::System, 0);
        assert_eq!(
            service.unit_file(),
            "/etc/systemd/system/rtsctl-agent-arm7.service"
        );
        insta::assert_snapshot!(service.unit());
    }

    #[test]
    fn who_has_no_unit_is_a_process_and_cron_may_start_it() {
        assert_eq!(Keeper::of(&survey(Systemd::Absent, 0)), Keeper::Process);
        let service = service(Systemd::System, 1000);
        assert_eq!(service.keeper, Keeper::Process);
        insta::assert_snapshot!(service.cron_line(), @"@reboot /home/pi/.local/state/rtsctl/services/arm7.sh");
        insta::assert_snapshot!(service.script());
    }

    #[test]
    fn words_are_taken_as_they_are() {
        assert_eq!(unit_word("/a/b:c"), "/a/b:c");
        assert_eq!(unit_word("/a b%h/\"$X\\"), "\"/a b%%h/\\\"$X\\\\\"");
    }
}
