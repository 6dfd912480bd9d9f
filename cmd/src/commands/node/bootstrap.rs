//! `rtsctl node bootstrap`.

use std::path::{Path, PathBuf};

use rts_ssh::bootstrap::{Change, Installed, Request, install};
use rts_ssh::{Destination, Session as Ssh};
use serde_json::json;

use super::reach::{ReachArgs, control_folder, node_name};
use crate::commands::or_interrupted;
use crate::error::CliError;
use crate::exit::Exit;
use crate::session::Session;

/// Said when Ctrl-C ends it.
const AGAIN: &str =
    "run the same again: what is done is not done again, and half a file never counts";

/// Install the agent on a machine as a service of an account, over SSH
///
/// Copies rts-agent and rts-manager (and modules, if any are named) by their digests, and lets systemd keep the agent running:
/// as a unit of the machine for root, else of the account; without systemd it is a plain process. Run again, it changes
/// what differs and nothing else: that is how a newer version is installed too. Components go on meanwhile.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The machine.
    #[command(flatten)]
    reach: ReachArgs,
    /// Name of the node [default: the name that the machine has for itself]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Further host name by which profiles may mean this node; may be repeated
    #[arg(long = "alias", value_name = "HOST")]
    aliases: Vec<String>,
    /// A module, or a folder of modules, to install; may be repeated. Without it those that are there stay
    #[arg(long = "module", value_name = "FILE|DIR")]
    modules: Vec<PathBuf>,
    /// Folder with rts-agent and rts-manager for that machine [default: that of rtsctl]
    #[arg(long, value_name = "DIR")]
    programs: Option<PathBuf>,
    /// Only say what would be done
    #[arg(long)]
    dry_run: bool,
    /// How to print
    #[arg(short, long, value_name = "FORMAT", default_value = "text")]
    output: Format,
}

/// How to print.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Format {
    /// Sentences
    Text,
    /// JSON
    Json,
}

/// Installs it.
pub async fn run(args: Args, session: &Session) -> Result<Exit, CliError> {
    let destination = args.reach.settle()?;
    let programs = programs(args.programs)?;
    let modules = match args.modules.as_slice() {
        [] => None,
        named => Some(module_files(named)?),
    };
    let work = async {
        let ssh = open(&destination, session).await?;
        let survey = ssh.survey().await?;
        let request = Request {
            node: node_name(args.name, &survey)?,
            aliases: args.aliases,
            agent: programs.join("rts-agent"),
            manager: programs.join("rts-manager"),
            modules,
            dry_run: args.dry_run,
        };
        let say = |change: &Change| session.out.say(&format!("rtsctl: {change}"));
        let installed = install(&ssh, &survey, &request, say).await?;
        ssh.close().await;
        show(&destination, &installed, args.dry_run, args.output, session)
    };
    or_interrupted(work, session, AGAIN).await
}

/// Opens a session.
pub(super) async fn open(destination: &Destination, session: &Session) -> Result<Ssh, CliError> {
    session
        .out
        .detail(&format!("rtsctl: logging in to {destination}"));
    Ok(Ssh::open(destination, &control_folder(&session.home)).await?)
}

/// The folder with the programs, which are there.
fn programs(named: Option<PathBuf>) -> Result<PathBuf, CliError> {
    let folder = match named {
        Some(folder) => folder,
        None => {
            let own = std::env::current_exe().map_err(|source| CliError::Read {
                path: "/proc/self/exe".into(),
                source,
            })?;
            own.parent().unwrap_or(Path::new("/")).to_owned()
        }
    };
    for name in ["rts-agent", "rts-manager"] {
        let file = folder.join(name);
        if !file.is_file() {
            return Err(CliError::usage_help(
                format!("there is no {}", file.display()),
                "name the folder of rts-agent and rts-manager with --programs DIR; `cargo build --release` builds them",
            ));
        }
    }
    Ok(folder)
}

/// The files that are named, and the modules in the folders that are.
fn module_files(named: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    for path in named {
        let read = |source| CliError::Read {
            path: path.clone(),
            source,
        };
        if !std::fs::metadata(path).map_err(read)?.is_dir() {
            files.push(path.clone());
            continue;
        }
        let entries = std::fs::read_dir(path).map_err(read)?;
        let mut found: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|file| file.extension().is_some_and(|e| e == "so") && file.is_file())
            .collect();
        if found.is_empty() {
            return Err(CliError::usage(format!(
                "there is no module (*.so) in {}",
                path.display()
            )));
        }
        found.sort();
        files.append(&mut found);
    }
    for (n, file) in files.iter().enumerate() {
        let name = file.file_name();
        if files[..n].iter().any(|before| before.file_name() == name) {
            let name = name.unwrap_or_default().to_string_lossy();
            return Err(CliError::usage(format!("two modules are called {name}")));
        }
    }
    Ok(files)
}

fn show(
    destination: &Destination,
    installed: &Installed,
    dry_run: bool,
    format: Format,
    session: &Session,
) -> Result<Exit, CliError> {
    let service = &installed.service;
    let changes: Vec<String> = installed.changes.iter().map(ToString::to_string).collect();
    let notes = installed.notes();
    if format == Format::Json {
        let unit = service.keeper != rts_ssh::bootstrap::Keeper::Process;
        let object = json!({
            "node": service.node,
            "host": destination.to_string(),
            "home": service.home,
            "keeper": service.keeper,
            "unit": unit.then(|| service.unit_name()),
            "file": service.file().0,
            "command": service.command,
            "changed": !changes.is_empty() && !dry_run,
            "dryRun": dry_run,
            "changes": changes,
            "notes": notes,
        });
        session.out.result(&format!("{object:#}"))?;
        return Ok(Exit::Ok);
    }
    if dry_run {
        for change in &installed.changes {
            session.out.result(&format!("would {change}"))?;
            if let Change::Write { text, .. } = change {
                let lines = text
                    .lines()
                    .map(|line| format!("{}\n", format!("    {line}").trim_end()));
                session.out.result(&lines.collect::<String>())?;
            }
        }
    }
    session
        .out
        .result(&sentence(destination, installed, dry_run))?;
    for note in notes {
        session.out.say(&format!("rtsctl: {note}"));
    }
    Ok(Exit::Ok)
}

/// `node/arm7 runs on pi@robot as rtsctl-agent-arm7.service of the account: 4 changes`.
fn sentence(destination: &Destination, installed: &Installed, dry_run: bool) -> String {
    use rts_ssh::bootstrap::Keeper;
    let service = &installed.service;
    let kept = match service.keeper {
        Keeper::SystemUnit => service.unit_name(),
        Keeper::UserUnit => format!("{} of the account", service.unit_name()),
        Keeper::Process => "a plain process".to_owned(),
    };
    let changes = match installed.changes.len() {
        0 => "nothing to change".to_owned(),
        count => crate::local::plural("change", count),
    };
    let runs = if dry_run { "would run" } else { "runs" };
    format!(
        "node/{} {runs} on {destination} as {kept}: {changes}",
        service.node
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_are_named_or_found_in_folders_and_each_once() {
        let temp = tempfile::tempdir().unwrap();
        let path = |name: &str| temp.path().join(name);
        for name in ["libB.so", "libA.so", "notes.txt", "sub/libA.so"] {
            std::fs::create_dir_all(path(name).parent().unwrap()).unwrap();
            std::fs::write(path(name), "").unwrap();
        }
        let found = module_files(&[temp.path().to_owned()]).unwrap();
        assert_eq!(found, [path("libA.so"), path("libB.so")]);
        let twice = module_files(&[temp.path().to_owned(), path("sub/libA.so")]).unwrap_err();
        assert_eq!(twice.to_string(), "two modules are called libA.so");
        std::fs::remove_file(path("sub/libA.so")).unwrap();
        assert!(
            module_files(&[path("sub")])
                .unwrap_err()
                .to_string()
                .contains("no module")
        );
        assert_eq!(
            module_files(&[path("nothing")]).unwrap_err().exit().code(),
            3
        );
    }
}
