//! What is to be done to come from what is there to what is wanted: a list, made without touching anything.

use std::fmt;

use super::found::{Found, Record};
use super::service::{Keeper, Service};
use crate::store::StoredFile;

/// One thing that is done, in the order of the list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// A file is copied.
    Copy(StoredFile),
    /// An agent is ended; its managers go on.
    Stop(u32),
    /// Services of the account are to run while nobody is logged in.
    Linger,
    /// The file that starts it is written: a unit or a script.
    Write {
        /// Where.
        path: String,
        /// All of it.
        text: String,
    },
    /// The unit is enabled and started, or started anew.
    StartUnit {
        /// Its name.
        unit: String,
        /// It runs already.
        again: bool,
    },
    /// The plain process is started.
    StartProcess,
    /// Copies that nobody needs any more are removed, those of before among them.
    Forget,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Change::Copy(file) => {
                // Tenths of a MiB are enough to see what takes its time.
                let tenths = file.size.div_ceil(1024 * 1024 / 10);
                let (whole, tenth) = (tenths / 10, tenths % 10);
                write!(f, "copy {} ({whole}.{tenth} MiB) to {}", file.name, file.path)
            }
            Change::Stop(pid) => write!(f, "stop the agent that runs (process {pid}); managers go on"),
            Change::Linger => f.write_str("let services of the account run while nobody is logged in (loginctl enable-linger)"),
            Change::Write { path, .. } => write!(f, "write {path}"),
            Change::StartUnit { unit, again: true } => write!(f, "restart {unit}; managers go on"),
            Change::StartUnit { unit, again: false } => write!(f, "enable and start {unit}"),
            Change::StartProcess => f.write_str("start the agent as a process"),
            Change::Forget => f.write_str("remove copies that nobody needs any more"),
        }
    }
}

/// The list. `linger` is whether services run while nobody is logged in.
pub(super) fn changes(
    service: &Service,
    files: &[StoredFile],
    record: &Record,
    found: &Found,
    linger: bool,
) -> Vec<Change> {
    let mut changes: Vec<Change> = files
        .iter()
        .filter(|file| file.sent)
        .cloned()
        .map(Change::Copy)
        .collect();
    let before = found.record.as_ref();
    let runs = found.runs(service.program()) && found.serves;
    let was_process = before.is_none_or(|record| record.keeper == Keeper::Process);
    let agent = found.agent.as_ref().map(|(pid, _)| *pid);
    if service.keeper == Keeper::UserUnit && !linger {
        changes.push(Change::Linger);
    }
    let (path, text) = service.file();
    let written = found.file.as_ref() == Some(&text);
    if !written {
        changes.push(Change::Write { path, text });
    }
    if !written || !runs {
        // A unit is started anew by systemd, which knows its process.
        let by_hand = was_process || service.keeper == Keeper::Process;
        changes.extend(agent.filter(|_| by_hand).map(Change::Stop));
        changes.push(match service.keeper {
            Keeper::Process => Change::StartProcess,
            Keeper::SystemUnit | Keeper::UserUnit => Change::StartUnit {
                unit: service.unit_name(),
                again: agent.is_some() && !by_hand,
            },
        });
    }
    let needed: Vec<&str> = record.digests().collect();
    let mut of_before = before.iter().flat_map(|before| before.digests());
    if of_before.any(|digest| !needed.contains(&digest)) {
        changes.push(Change::Forget);
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn service(keeper: Keeper) -> Service {
        Service {
            node: "arm".to_owned(),
            home: "/h".to_owned(),
            keeper,
            command: vec!["/h/programs/new/rts-agent".to_owned()],
            unit_folder: "/u".to_owned(),
        }
    }

    fn file(sent: bool) -> StoredFile {
        StoredFile {
            name: "rts-agent".to_owned(),
            digest: "new".to_owned(),
            size: 3_000_000,
            path: "/h/programs/new/rts-agent".to_owned(),
            sent,
        }
    }

    fn shown(service: &Service, sent: bool, found: &Found) -> String {
        let record = service.record(vec!["new".to_owned()], Vec::new(), false);
        let changes = changes(service, &[file(sent)], &record, found, false);
        changes.iter().map(|change| format!("{change}\n")).collect()
    }

    /// What is there when the service has been installed, by an older program if `old`.
    fn installed(service: &Service, old: bool) -> Found {
        let digest = if old { "old" } else { "new" };
        let before = Service {
            command: vec![format!("/h/programs/{digest}/rts-agent")],
            ..service.clone()
        };
        Found {
            record: Some(before.record(vec![digest.to_owned()], Vec::new(), false)),
            file: Some(before.file().1),
            agent: Some((77, before.program().to_owned())),
            serves: true,
            ..Found::default()
        }
    }

    #[test]
    fn a_bare_account_gets_everything() {
        let unit = shown(&service(Keeper::UserUnit), true, &Found::default());
        insta::assert_snapshot!(unit, @r"
        copy rts-agent (2.9 MiB) to /h/programs/new/rts-agent
        let services of the account run while nobody is logged in (loginctl enable-linger)
        write /u/rtsctl-agent-arm.service
        enable and start rtsctl-agent-arm.service
        ");
        let process = shown(&service(Keeper::Process), true, &Found::default());
        insta::assert_snapshot!(process, @r"
        copy rts-agent (2.9 MiB) to /h/programs/new/rts-agent
        write /h/services/arm.sh
        start the agent as a process
        ");
    }

    #[test]
    fn what_is_there_is_left_alone() {
        for keeper in [Keeper::Process, Keeper::SystemUnit] {
            let service = service(keeper);
            assert_eq!(shown(&service, false, &installed(&service, false)), "");
        }
    }

    #[test]
    fn a_new_program_takes_the_place_of_the_old_one() {
        let system = service(Keeper::SystemUnit);
        insta::assert_snapshot!(shown(&system, true, &installed(&system, true)), @r"
        copy rts-agent (2.9 MiB) to /h/programs/new/rts-agent
        write /u/rtsctl-agent-arm.service
        restart rtsctl-agent-arm.service; managers go on
        remove copies that nobody needs any more
        ");
        let process = service(Keeper::Process);
        insta::assert_snapshot!(shown(&process, true, &installed(&process, true)), @r"
        copy rts-agent (2.9 MiB) to /h/programs/new/rts-agent
        write /h/services/arm.sh
        stop the agent that runs (process 77); managers go on
        start the agent as a process
        remove copies that nobody needs any more
        ");
    }

    #[test]
    fn what_has_died_is_started_again() {
        let system = service(Keeper::SystemUnit);
        let found = Found {
            agent: None,
            serves: false,
            ..installed(&system, false)
        };
        assert_eq!(
            shown(&system, false, &found),
            "enable and start rtsctl-agent-arm.service\n"
        );
    }
}
